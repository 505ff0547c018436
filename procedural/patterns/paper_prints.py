"""Sheets that lie on tables: pages with text, forms and plots, newspapers, and cards that are all picture."""

from __future__ import annotations

import numpy as np

from .glyphs import text_line
from .grid import Grid, Layers, covered, step
from .prints import Sheet, draw_picture, printed

#: Margin of a page over its shorter side [1]: 20-25 mm of A4.
MARGIN = 0.11
#: Heights of letters [m]: 10 to 12 point type has capitals of 2.4-2.9 mm, that of newspapers 1.7-2.1 mm.
PAGE_TYPE, NEWS_TYPE = (0.0024, 0.0030), (0.0017, 0.0021)
#: Distance of lines over the height of capitals [1], and pixels of a letter's height in the pictures of lines [px].
LEADING, LETTER = 1.6, 12
#: Different lines of a column [1]: their order is random, so nobody sees that they come again.
LINES = 6
#: Width of a newspaper's column [m].
COLUMN = (0.042, 0.056)
#: Distance of ruled lines [m]: squared paper has 5 mm, ruled paper 7-8 mm.
RULED = (0.005, 0.007, 0.008)
#: Height of waves of paper that does not lie quite flat, and their length [m].
WAVE, WAVE_LENGTH = 2.5e-4, 0.12


def printed_sheet(grid: Grid, colours: np.ndarray) -> Layers:
    """Return a page: a letter, a report with a picture, a form, a plot, or ruled paper.

    Colours: paper, two inks, and that of letters.
    """
    sheet = Sheet(grid, colours[0])
    margin = MARGIN * min(grid.width, grid.height)
    box = (margin, margin, grid.width - 2 * margin, grid.height - 2 * margin)
    kind = int(grid.rng.choice(len(_PAGES), p=(0.3, 0.25, 0.15, 0.2, 0.1)))
    _PAGES[kind](sheet, box, colours)
    return _wavy(grid, printed(grid, sheet.colour))


def newspaper(grid: Grid, colours: np.ndarray) -> Layers:
    """Return a newspaper, one page or, where it is wider than high, two: title, headlines, columns, pictures, a fold.

    Colours as for `printed_sheet`.
    """
    sheet, rng = Sheet(grid, colours[0]), grid.rng
    pages = 2 if grid.width > grid.height else 1
    wide, ink = grid.width / pages, colours[-1]
    for page in range(pages):
        margin = 0.05 * wide
        x, y, width, height = page * wide + margin, margin, wide - 2 * margin, grid.height - 2 * margin
        if rng.random() < 0.6:
            sheet.word(x, y + 0.91 * height, width, 0.08 * height, ink, int(rng.integers(6, 12)))
            sheet.rectangle(x, y + 0.895 * height, x + width, y + 0.895 * height + 0.0008, ink)
            height *= 0.88
        headline = rng.uniform(0.03, 0.07) * height
        sheet.word(x, y + height - headline, width, headline, ink, int(rng.integers(14, 26)))
        _columns(sheet, (x, y, width, height - 1.3 * headline), rng.uniform(*COLUMN), rng.uniform(*NEWS_TYPE), ink)
        for _ in range(int(rng.integers(1, 4))):
            _news_picture(sheet, (x, y, width, height - 1.3 * headline), colours)
    layers = printed(grid, sheet.colour)
    fold = np.minimum(np.abs(grid.x - wide) if pages == 2 else np.inf, np.abs(grid.y - grid.height / 2))
    crease = np.broadcast_to(step(0.004, 0.0, fold), grid.shape)
    colour = layers.colour * (1.0 - 0.12 * crease)[..., None]
    return _wavy(grid, Layers(colour, layers.roughness, layers.height + 1e-3 * crease))


def card(grid: Grid, colours: np.ndarray) -> Layers:
    """Return a card, a photograph, a poster or a magazine: a picture out to its edge or to a white rim, with words."""
    sheet, rng = Sheet(grid, colours[1]), grid.rng
    width, height = grid.width, grid.height
    box = (0.0, 0.0, width, height)
    for _ in range(int(rng.integers(1, 4))):
        low, high = np.sort(rng.uniform(0.0, 1.0, 2))
        sheet.rectangle(0.0, low * height, width, high * height, colours[int(rng.integers(len(colours)))])
    draw_picture(sheet, rng, *box, (colours[int(rng.integers(1, 3))], colours[0], colours[1]))
    if rng.random() < 0.5:
        words = int(rng.integers(4, 12))
        sheet.word(0.08 * width, rng.uniform(0.05, 0.8) * height, 0.84 * width, 0.14 * height, None, words)
    if rng.random() < 0.4:
        rim = rng.uniform(0.03, 0.08) * min(width, height)
        for side in ((0, 0, width, rim), (0, height - rim, width, height)):
            sheet.rectangle(*side, colours[0])
        for side in ((0, 0, rim, height), (width - rim, 0, width, height)):
            sheet.rectangle(*side, colours[0])
    return printed(grid, sheet.colour)


def _letter(sheet: Sheet, box: tuple[float, float, float, float], colours: np.ndarray) -> None:
    x, y, width, height = box
    rng, size = sheet.rng, sheet.rng.uniform(*PAGE_TYPE)
    if rng.random() < 0.5:
        sheet.rectangle(x, y + 0.94 * height, x + 0.3 * width, y + height, colours[1])
    sheet.word(x, y + 0.86 * height, rng.uniform(0.4, 0.9) * width, 2.2 * size, colours[-1], int(rng.integers(6, 18)))
    top = 0.82 * height
    for _ in range(int(rng.integers(1, 5))):
        part = rng.uniform(0.1, 0.3) * height
        if top < part:
            break
        _columns(sheet, (x, y + top - part, width, part), width, size, colours[-1])
        top -= part + 2.0 * size


def _report(sheet: Sheet, box: tuple[float, float, float, float], colours: np.ndarray) -> None:
    x, y, width, height = box
    rng, size = sheet.rng, sheet.rng.uniform(*PAGE_TYPE)
    sheet.word(x, y + 0.93 * height, width, 0.06 * height, colours[-1], int(rng.integers(8, 20)))
    _columns(sheet, (x, y, width, 0.9 * height), width / int(rng.integers(1, 3)), size, colours[-1])
    _news_picture(sheet, (x, y, width, 0.9 * height), colours)


def _form(sheet: Sheet, box: tuple[float, float, float, float], colours: np.ndarray) -> None:
    x, y, width, height = box
    rng, pitch = sheet.rng, sheet.rng.uniform(0.006, 0.012)
    rows, columns = int(0.85 * height / pitch), int(sheet.rng.integers(2, 6))
    sheet.word(x, y + 0.91 * height, 0.8 * width, 0.05 * height, colours[1], int(rng.integers(6, 14)))
    sheet.rectangle(x, y + (rows - 1) * pitch, x + width, y + rows * pitch, colours[1])
    for row in range(rows + 1):
        sheet.rectangle(x, y + row * pitch, x + width, y + row * pitch + 0.0004, colours[-1])
    for column in range(columns + 1):
        place = x + column * width / columns
        sheet.rectangle(place, y, place + 0.0004, y + rows * pitch, colours[-1])
    for row in range(rows - 1):
        sheet.word(x + 0.01 * width, y + (row + 0.3) * pitch, 0.8 * width / columns, 0.4 * pitch, colours[-1], 6)


def _plot(sheet: Sheet, box: tuple[float, float, float, float], colours: np.ndarray) -> None:
    x, y, width, height = box
    rng = sheet.rng
    low, high = y + 0.5 * height, y + 0.95 * height
    for number in range(count := int(rng.integers(4, 14))):
        left, top = x + number * width / count, low + rng.uniform(0.1, 0.9) * (high - low)
        sheet.rectangle(left, low, left + 0.7 * width / count, top, colours[1 + number % 2])
    for side in ((x, low, x + width, low + 0.0006), (x, low, x + 0.0006, high)):
        sheet.rectangle(*side, colours[-1])
    _columns(sheet, (x, y, width, 0.45 * height), width, rng.uniform(*PAGE_TYPE), colours[-1])


def _ruled(sheet: Sheet, box: tuple[float, float, float, float], colours: np.ndarray) -> None:
    del box
    grid, pitch, squared = sheet.grid, float(sheet.rng.choice(RULED)), sheet.rng.random() < 0.5
    lines = covered(np.abs(grid.y % pitch - pitch / 2), 0.00015, grid.texel[1])
    if squared:
        lines = np.maximum(lines, covered(np.abs(grid.x % pitch - pitch / 2), 0.00015, grid.texel[0]))
    lines = np.broadcast_to(lines, grid.shape)
    sheet.ink(np.ascontiguousarray(lines), colours[1], slice(None), slice(None))


_PAGES = (_letter, _report, _form, _plot, _ruled)


def _columns(
    sheet: Sheet, box: tuple[float, float, float, float], column: float, size: float, colour: np.ndarray
) -> None:
    """Set text in columns of about a width [m] into a box, with capitals of a height `size` [m]."""
    x, y, width, height = box
    count = max(1, round(width / column))
    pitch, gap = width / count, 0.06 * width / count if count > 1 else 0.0
    pixels, number = max(1, round((pitch - gap) / size * LETTER)), int(height / (LEADING * size))
    if number < 1:
        return
    lines = np.stack([text_line(sheet.rng, sheet.body, LETTER, pixels) for _ in range(LINES)])
    for index in range(count):
        rows = np.zeros((number, round(LEADING * LETTER), pixels), np.float32)
        rows[:, :LETTER] = lines[sheet.rng.integers(LINES, size=number)]
        ends = sheet.rng.random(number) < 0.15  # the last lines of paragraphs
        rows[ends, :, pixels // 3 :] = 0.0
        text = rows.reshape(-1, pixels)
        sheet.stamp(text, x + index * pitch, y + height - len(text) * size / LETTER, size / LETTER, colour)


def _news_picture(sheet: Sheet, box: tuple[float, float, float, float], colours: np.ndarray) -> None:
    """Print a picture over a part of a box, in colour or in grey."""
    rng, (x, y, width, height) = sheet.rng, box
    wide, high = rng.uniform(0.3, 0.7) * width, rng.uniform(0.12, 0.3) * height
    left, low = x + rng.uniform(0.0, width - wide), y + rng.uniform(0.0, height - high)
    inks = (colours[1], colours[2])
    if rng.random() < 0.5:
        inks = tuple(np.full(3, level, np.float32) for level in rng.uniform(0.05, 0.5, 2))
    sheet.rectangle(left, low, left + wide, low + high, 0.75 * colours[0])
    draw_picture(sheet, rng, left, low, wide, high, (inks[0], inks[1], colours[0]))


def _wavy(grid: Grid, layers: Layers) -> Layers:
    """Return layers of paper that does not lie quite flat."""
    height = layers.height + WAVE * grid.noise(WAVE_LENGTH)
    return Layers(layers.colour, layers.roughness, height.astype(np.float32))
