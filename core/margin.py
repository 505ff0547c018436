"""Margins: rows and columns of a picture beyond the frame that its intrinsics and labels belong to."""

from __future__ import annotations

import numpy as np

#: Columns and rows beyond the left, the top, the right and the bottom border of the frame [px].
Sides = tuple[int, int, int, int]
NO_MARGIN: Sides = (0, 0, 0, 0)


def in_frame(picture: np.ndarray, margin: Sides) -> np.ndarray:
    """Return the frame of a picture that has a margin, (H + top + bottom, W + left + right, ...) to (H, W, ...)."""
    left, top, right, bottom = margin
    height, width = picture.shape[:2]
    return picture[top : height - bottom, left : width - right]


def pixel_grid(width: int, height: int, margin: Sides) -> np.ndarray:
    """Return the coordinates (u, v) of all pixels in the frame's own system; those of the margin lie outside of it.

    Parameters
    ----------
    width, height : int
        Of the frame [px].
    margin : Sides
        Around it.

    Returns
    -------
    (H + top + bottom, W + left + right, 2) int
        [px]
    """
    left, top, right, bottom = margin
    return np.stack(np.meshgrid(np.arange(-left, width + right), np.arange(-top, height + bottom)), axis=-1)
