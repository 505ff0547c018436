"""Invented letters: strokes in a box, so that print looks set in type and says nothing."""

from __future__ import annotations

import cv2
import numpy as np

#: Letters of an invented alphabet, and the height at which each is drawn before it is scaled [px].
LETTERS, MASTER = 22, 48
#: Height of short letters over that of tall ones [1], as Latin type has it, and width of a letter over its height.
X_HEIGHT, LETTER_WIDTH = 0.68, (0.42, 0.72)
#: Letters in a word, and the space between words over the height [1].
WORD, SPACE = (2, 10), 0.38


def alphabet(rng: np.random.Generator, weight: float) -> list[np.ndarray]:
    """Return the letters of an invented alphabet, each (MASTER, w) float32 coverage, the first row on top.

    Parameters
    ----------
    rng : numpy.random.Generator
        Draws the strokes.
    weight : float
        Width of a stroke over the height of a letter [1]: 0.08 light, 0.2 black.
    """
    return [_letter(rng, max(2, round(weight * MASTER))) for _ in range(LETTERS)]


def text_line(
    rng: np.random.Generator, letters: list[np.ndarray], height: int, width: int, capitals: bool = False
) -> np.ndarray:
    """Return a line of words that fills at most a width [px], (height, width) float32 coverage."""
    line, place = np.zeros((height, width), np.float32), 0
    while True:
        word = word_picture(rng, letters, height, capitals=capitals)
        if place + word.shape[1] > width:
            return line
        line[:, place : place + word.shape[1]] = word
        place += word.shape[1] + max(1, round(SPACE * height))


def word_picture(
    rng: np.random.Generator, letters: list[np.ndarray], height: int, length: int | None = None, capitals: bool = False
) -> np.ndarray:
    """Return a word, (height, w) float32 coverage; all its letters are tall where it is set in capitals."""
    count = int(rng.integers(*WORD)) if length is None else length
    parts = []
    for number in range(count):
        master = letters[int(rng.integers(len(letters)))]
        tall = capitals or (number == 0 and rng.random() < 0.2) or rng.random() < 0.25
        rows = max(1, round(height * (1.0 if tall else X_HEIGHT)))
        columns = max(1, round(master.shape[1] * height / MASTER * (0.95 if tall else 0.85)))
        letter = np.zeros((height, columns + max(1, round(0.08 * height))), np.float32)
        letter[height - rows :, :columns] = cv2.resize(master, (columns, rows), interpolation=cv2.INTER_AREA)
        parts.append(letter)
    return np.concatenate(parts, axis=1)


def barcode(rng: np.random.Generator, modules: int = 95) -> np.ndarray:
    """Return the bars of a code of as many modules as EAN-13 has, (modules,) float32: 1 is a bar."""
    bars, place = np.zeros(modules, np.float32), 0
    dark = True
    while place < modules:
        width = int(rng.choice((1, 1, 1, 2, 2, 3)))
        bars[place : place + width] = float(dark)
        place, dark = place + width, not dark
    bars[[0, 2, -1, -3]], bars[[1, -2]] = 1.0, 0.0
    return bars


def _letter(rng: np.random.Generator, stroke: int) -> np.ndarray:
    """Return one letter: one or two stems with bowls, bars or diagonals between them."""
    width = round(MASTER * rng.uniform(*LETTER_WIDTH))
    canvas = np.zeros((MASTER, width), np.uint8)
    left, right, top, bottom = stroke // 2, width - 1 - stroke // 2, stroke // 2, MASTER - 1 - stroke // 2
    middle = round(MASTER * rng.choice((0.36, 0.5, 0.62)))

    def stroke_to(start: tuple[int, int], end: tuple[int, int]) -> None:
        cv2.line(canvas, start, end, 255, stroke, cv2.LINE_AA)

    kind = int(rng.integers(6))
    if kind == 0:  # round
        cv2.ellipse(
            canvas, (width // 2, MASTER // 2), (right - width // 2, bottom - MASTER // 2), 0, 0, 360, 255, stroke
        )
    elif kind == 1:  # diagonals
        stroke_to((left, top if rng.random() < 0.5 else bottom), (width // 2, bottom if rng.random() < 0.5 else top))
        stroke_to((width // 2, bottom), (right, top))
    else:
        stroke_to((left, top), (left, bottom))
    if kind in (2, 3):  # a stem and a bowl
        low, high = ((top, middle), (middle, bottom))[int(rng.integers(2))]
        centre, axes = (left, (low + high) // 2), (max(1, right - left), max(1, (high - low) // 2))
        cv2.ellipse(canvas, centre, axes, 0, -90, 90, 255, stroke, cv2.LINE_AA)
    if kind == 4:
        stroke_to((right, top), (right, bottom))
        stroke_to((left, middle), (right, middle if rng.random() < 0.5 else top))
    if kind == 5:
        for level in (top, middle, bottom):
            if rng.random() < 0.7:
                stroke_to((left, level), (right, level))
    if kind == 0 and rng.random() < 0.6:
        stroke_to((width // 2, middle), (right, middle))
    return canvas.astype(np.float32) / np.float32(255.0)
