"""Masks as polygons along the edges of pixels, which COCO's rasteriser turns into the same masks again.

COCO's polygons have no holes and are united. A part with a hole is therefore cut in two through the hole.
"""

from __future__ import annotations

import cv2
import numpy as np


def polygons_of(mask: np.ndarray) -> list[list[float]]:
    """Return the polygons of a mask, (H, W) bool: x, y, x, y, ... [px]; the first pixel covers 0 to 1."""
    return [_outline(piece) for piece in _pieces(mask)]


def _pieces(mask: np.ndarray) -> list[np.ndarray]:
    """Return the parts of a mask that are connected along edges, cut so that none has a hole."""
    found, waiting = [], [mask]
    while waiting:
        count, numbers = cv2.connectedComponents(waiting.pop().astype(np.uint8), connectivity=4)
        for number in range(1, count):
            part = numbers == number
            column = _column_through_a_hole(part)
            if column is None:
                found.append(part)
                continue
            left, right = part.copy(), part
            left[:, column:] = False
            right[:, :column] = False
            waiting += [left, right]
    return found


def _column_through_a_hole(part: np.ndarray) -> int | None:
    outside = np.pad(~part, 1, constant_values=True).astype(np.uint8)
    # Corners join what is outside, as parts are joined by edges alone.
    count, numbers, stats, _ = cv2.connectedComponentsWithStats(outside, connectivity=8)
    around = numbers[0, 0]
    for number in range(1, count):
        if number != around:
            left, width = stats[number, cv2.CC_STAT_LEFT], stats[number, cv2.CC_STAT_WIDTH]
            # Between two columns of the hole, or at the edge of a hole of one column; less the padding of one pixel.
            return int(left + max(width // 2, 1) - 1)
    return None


def _outline(part: np.ndarray) -> list[float]:
    """Return the corners of a part's outline, with the part on the right hand of each step (y points down)."""
    padded = np.pad(part, 1)
    follow: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for (dy, dx), start, step in (
        ((-1, 0), (0, 0), (1, 0)),  # nothing above: along the upper edge, to the right
        ((0, 1), (1, 0), (0, 1)),
        ((1, 0), (1, 1), (-1, 0)),
        ((0, -1), (0, 1), (0, -1)),
    ):
        free = part & ~np.roll(padded, (-dy, -dx), (0, 1))[1:-1, 1:-1]
        for y, x in np.argwhere(free).tolist():
            follow.setdefault((x + start[0], y + start[1]), []).append(step)
    begin = min(follow)
    at, direction, corners = begin, (0, 0), []
    while follow:
        steps = follow[at]
        # Where two edges go on, the part touches itself at a corner: the right turn stays on the same pixel.
        step = steps[0] if len(steps) == 1 else next(s for s in steps if s == (-direction[1], direction[0]))
        steps.remove(step)
        if not steps:
            del follow[at]
        if step != direction:
            corners += [float(at[0]), float(at[1])]
        at, direction = (at[0] + step[0], at[1] + step[1]), step
    return corners
