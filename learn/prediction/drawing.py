"""A prediction as a picture to look at: masks, boxes, axes and labels over the picture, beside its depth in colours."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from ...annotate.boxes import EDGES
from ...dataset.cameras.lens import distorted
from ..data.visualise import coloured_depth
from .predictor import Prediction

#: Colours of objects in turn, and of the axes x, y, z, sRGB.
_OBJECTS = ((255, 96, 80), (70, 210, 110), (90, 150, 255), (255, 205, 60), (225, 105, 255), (60, 220, 220))
_AXES = ((255, 40, 40), (40, 220, 40), (60, 90, 255))
#: Least width of the picture in the drawing [px]: smaller ones are enlarged, so that text can be read.
_WIDTH = 640
#: Height of letters relative to OpenCV's font, per width of the drawing [1/px]; bounds of it.
_FONT, _LEAST_FONT, _MOST_FONT = 0.42 / 640, 0.4, 1.2
#: How much of an object's colour covers its mask, how light its outline is drawn.
_TINT = 0.35
#: Pieces of each edge of a box, so that a lens may bend it.
_PIECES = 12
#: Points nearer than this are not drawn [m]: they are beside or behind the camera.
_NEAREST = 0.02
#: Percentiles of the depth that are the ends of its colours.
_ENDS = (2.0, 98.0)
#: Width of the scale of depth, relative to the picture's.
_SCALE = 0.13
_INK, _PAPER = (255, 255, 255), (20, 20, 24)


def drawn(picture: np.ndarray, found: Prediction) -> np.ndarray:
    """Return a picture with all that was found in it beside its depth with a scale, (H, W, 3) uint8.

    Parameters
    ----------
    picture : (H, W, 3) uint8
        The picture that was labelled.
    found : Prediction
        In the pixels of that picture.
    """
    factor = max(1, -(-_WIDTH // picture.shape[1]))
    size = (factor * picture.shape[1], factor * picture.shape[0])
    over = cv2.resize(picture, size, interpolation=cv2.INTER_CUBIC if factor > 1 else cv2.INTER_AREA)
    for row in range(len(found)):
        _draw_mask(over, cv2.resize(found.mask[row].astype(np.uint8), size, interpolation=cv2.INTER_NEAREST), row)
    # Far objects first, so that near ones are drawn over them.
    for row in np.argsort(-found.camera_T_object[:, 2, 3]):
        _draw_box(over, found, int(row), factor)
    for row in range(len(found)):
        _draw_number(over, found, row, factor)
    depth, ends = _depth(found.depth, size)
    top = np.concatenate([over, depth, _scale(size, ends)], axis=1)
    return np.concatenate([top, _legend(found, top.shape[1], _font(over))], axis=0)


def _draw_mask(over: np.ndarray, mask: np.ndarray, row: int) -> None:
    colour = np.array(_OBJECTS[row % len(_OBJECTS)])
    inside = mask.astype(bool)
    over[inside] = ((1.0 - _TINT) * over[inside] + _TINT * colour).astype(np.uint8)
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(over, outlines, -1, colour.tolist(), _line(over), cv2.LINE_AA)


def _draw_box(over: np.ndarray, found: Prediction, row: int, factor: int) -> None:
    corners = found.corners[row]
    steps = np.linspace(0.0, 1.0, _PIECES + 1)[:, None]
    for a, b in EDGES:
        _draw_line(over, corners[a] + steps * (corners[b] - corners[a]), found, factor, _OBJECTS[row % len(_OBJECTS)])
    pose, half = found.camera_T_object[row], found.size[row] / 2.0
    for axis, colour in enumerate(_AXES):
        _draw_line(over, pose[:3, 3] + steps * half[axis] * pose[:3, axis], found, factor, colour, wider=1)


def _draw_line(
    over: np.ndarray, points: np.ndarray, found: Prediction, factor: int, colour: Sequence[int], wider: int = 0
) -> None:
    ends = _pixels(points, found, factor)
    if ends is not None:
        cv2.polylines(over, [ends[:, None]], False, tuple(colour), _line(over) + wider, cv2.LINE_AA)


def _pixels(points: np.ndarray, found: Prediction, factor: int) -> np.ndarray | None:
    """Return the pixels of points in the drawing, (n, 2) int; None where one is not in front of the camera."""
    if (points[:, 2] < _NEAREST).any():
        return None
    slopes = points[:, :2] / points[:, 2:]
    bent = slopes if found.distortion.absent else distorted(slopes, found.distortion)
    pixels = (bent @ found.K[:2, :2].T + found.K[:2, 2] + 0.5) * factor - 0.5
    # OpenCV draws in 32-bit integers.
    return np.rint(pixels).astype(np.int32) if np.abs(pixels).max() < 1e5 else None


def _draw_number(over: np.ndarray, found: Prediction, row: int, factor: int) -> None:
    """Draw the number of an object above its box; in its mask where the box is not seen."""
    ends = _pixels(found.corners[row], found, factor)
    x, y = found.peak[row] * factor if ends is None else (ends[:, 0].mean(), ends[:, 1].min())
    text, font = str(row + 1), _font(over)
    (width, height), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, font, 1)
    left = int(np.clip(x - width / 2 - 4, 0, max(0, over.shape[1] - width - 8)))
    top = int(np.clip(y - height - 9, 0, max(0, over.shape[0] - height - 8)))
    cv2.rectangle(over, (left, top), (left + width + 8, top + height + 8), _PAPER, -1)
    cv2.rectangle(over, (left, top), (left + width + 8, top + height + 8), _OBJECTS[row % len(_OBJECTS)], _line(over))
    _write(over, text, (left + 4, top + height + 4), font)


def _legend(found: Prediction, width: int, font: float) -> np.ndarray:
    """Return a strip with a line for each object: number, kind, score, depth of its middle and sides of its box."""
    lines = [_label(found, row) for row in range(len(found))] or ["no objects found"]
    (longest, height), _ = max(
        (cv2.getTextSize(line, cv2.FONT_HERSHEY_SIMPLEX, font, 1) for line in lines), key=lambda one: one[0][0]
    )
    step, cell = 2 * height + 2, longest + 6 * height
    columns = max(1, min(len(lines), width // cell))
    rows = -(-len(lines) // columns)
    strip = np.full((rows * step + height, width, 3), _PAPER, np.uint8)
    for number, line in enumerate(lines):
        x, y = number // rows * cell + height, number % rows * step + step
        if len(found):
            cv2.rectangle(strip, (x, y - height), (x + height, y), _OBJECTS[number % len(_OBJECTS)], -1)
        _write(strip, line, (x + 2 * height, y), font)
    return strip


def _label(found: Prediction, row: int) -> str:
    sides = " x ".join(f"{1e3 * one:.0f}" for one in found.size[row])
    kind = "transparent" if found.transparent[row] else "opaque"
    return f"{row + 1}  {kind} {found.score[row]:.2f}, at {found.camera_T_object[row, 2, 3]:.2f} m, {sides} mm"


def _write(over: np.ndarray, text: str, at: tuple[int, int], font: float) -> None:
    cv2.putText(over, text, at, cv2.FONT_HERSHEY_SIMPLEX, font, _INK, 1, cv2.LINE_AA)


def _depth(depth: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, tuple[float, float]]:
    known = depth[np.isfinite(depth) & (depth > 0.0)]
    near, far = np.percentile(known, _ENDS).tolist() if known.size else (0.0, 1.0)
    ends = (near, max(far, near + 1e-3))
    return cv2.resize(coloured_depth(depth, ends), size, interpolation=cv2.INTER_NEAREST), ends


def _scale(size: tuple[int, int], ends: tuple[float, float]) -> np.ndarray:
    """Return a bar of the colours of depth, near at the bottom, with five depths beside it [m]."""
    width, height = size
    panel = np.full((height, round(_SCALE * width), 3), _PAPER, np.uint8)
    near, far = ends
    margin, bar = height // 12, max(10, panel.shape[1] // 5)
    column = np.linspace(far, near, height - 2 * margin)[:, None]
    panel[margin : height - margin, bar // 2 : bar // 2 + bar] = coloured_depth(column, ends)
    font = _font(panel, width)
    for part in np.linspace(0.0, 1.0, 5):
        y = round(margin + part * (height - 2 * margin - 1))
        _write(panel, f"{far + part * (near - far):.2f} m", (2 * bar, y + round(10 * font)), font)
    return panel


def _font(over: np.ndarray, width: int | None = None) -> float:
    return float(np.clip(_FONT * (over.shape[1] if width is None else width), _LEAST_FONT, _MOST_FONT))


def _line(over: np.ndarray) -> int:
    return max(1, round(over.shape[1] / 640))
