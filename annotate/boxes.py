"""Boxes: oriented in 3D, axis-aligned in the picture.

A 2D box is ``(left, top, right, bottom)`` in image coordinates [px]: the outer edges, half a pixel beyond the centres
of the outermost pixels, so that ``right - left`` is the width in pixels.
"""

from __future__ import annotations

import numpy as np

from .projection import project_camera

Box = tuple[float, float, float, float]

#: Signs of the corners in the object frame, (8, 3): bit 0 of the corner's number is x, bit 1 is y, bit 2 is z; a bit
#: that is set is the positive side.
CORNER_SIGNS = np.array([[1 if corner >> axis & 1 else -1 for axis in range(3)] for corner in range(8)])
#: The 12 edges as pairs of corners: those that differ in one bit.
EDGES = tuple((a, a | 1 << axis) for axis in range(3) for a in range(8) if not a >> axis & 1)


def box_corners(size: tuple[float, float, float]) -> np.ndarray:
    """Return the corners of a bounding box about the origin of its object's frame, (8, 3) float64 [m]."""
    return CORNER_SIGNS * (np.asarray(size, np.float64) / 2.0)


def modal_box(mask: np.ndarray) -> Box | None:
    """Return the bounding box of the pixels of a mask, (H, W) bool; None where the mask is empty."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return None
    left, top, right, bottom = (int(n) for n in (columns[0], rows[0], columns[-1], rows[-1]))
    return (left - 0.5, top - 0.5, right + 0.5, bottom + 0.5)


def amodal_box(points: np.ndarray, K: np.ndarray) -> Box | None:
    """Return the bounding box of the projection of a whole surface, also outside the picture.

    Parameters
    ----------
    points : (n, 3) float
        Vertices of the surface in the camera frame [m]. The projection of a mesh lies in the convex hull of the
        projection of its vertices, so they bound it exactly.
    K : (3, 3) float
        Intrinsic matrix [px].

    Returns
    -------
    tuple of 4 float, or None
        None where a vertex is behind the camera: the projection is then unbounded.
    """
    pixels, Z = project_camera(points, K)
    if (Z <= 0.0).any():
        return None
    (left, top), (right, bottom) = pixels.min(axis=0), pixels.max(axis=0)
    return (float(left), float(top), float(right), float(bottom))


def clipped_box(box: Box | None, width: int, height: int) -> Box | None:
    """Return a box clipped to the picture; None where it is outside."""
    if box is None:
        return None
    left, top, right, bottom = box
    part = (max(left, -0.5), max(top, -0.5), min(right, width - 0.5), min(bottom, height - 0.5))
    return part if part[0] < part[2] and part[1] < part[3] else None
