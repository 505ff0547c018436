"""Silhouettes and depths beyond the edges of a picture, from meshes: labels hold only what is inside."""

from __future__ import annotations

import numpy as np

from ....annotate.projection import project_camera

#: Pixels of triangles' boxes that are tested at once: bounds the memory to some 100 MB.
_AT_ONCE = 1 << 21


def wide_silhouette(points: np.ndarray, faces: np.ndarray, K: np.ndarray, width: int, height: int) -> np.ndarray:
    """Return which pixel centres a mesh covers, (3 H, 3 W) bool; arguments as of `wide_depth`."""
    return np.isfinite(wide_depth(points, faces, K, width, height))


def wide_depth(points: np.ndarray, faces: np.ndarray, K: np.ndarray, width: int, height: int) -> np.ndarray:
    """Return the planar depth of a mesh at pixel centres, on a canvas of three pictures by three.

    Parameters
    ----------
    points : (n, 3) float
        Vertices in the camera frame [m].
    faces : (m, 3) int
        Triangles; those with a vertex behind the camera are left out.
    K : (3, 3) float
        Intrinsic matrix [px].
    width, height : int
        Size of the picture [px].

    Returns
    -------
    (3 H, 3 W) float64
        Depth of the nearest surface [m], +inf without one. The picture is the middle: pixel (0, 0) is ``[H, W]``.
    """
    pixels, Z = project_camera(points, K)
    before = faces[(Z[faces] > 0.0).all(axis=1)]
    triangles, nearness = pixels[before] + (width, height), 1.0 / Z[before]
    last = np.array([3 * width - 1, 3 * height - 1])
    low = np.clip(np.ceil(triangles.min(axis=1)), 0, last + 1).astype(np.int64)
    high = np.clip(np.floor(triangles.max(axis=1)), -1, last).astype(np.int64)
    sides = np.maximum(high - low + 1, 0)
    counts = sides.prod(axis=1)
    canvas = np.full((3 * height, 3 * width), np.inf)
    groups = np.cumsum(counts) // _AT_ONCE
    for group in np.unique(groups):
        chosen = (groups == group) & (counts > 0)
        _cover(canvas, triangles[chosen], nearness[chosen], low[chosen], sides[chosen, 0], counts[chosen])
    return canvas


def _cover(
    canvas: np.ndarray,
    triangles: np.ndarray,
    nearness: np.ndarray,
    low: np.ndarray,
    across: np.ndarray,
    counts: np.ndarray,
) -> None:
    """Set the pixels whose centres lie in a triangle or on its edge; `low` and `across` are the triangles' boxes.

    In the picture the inverse depth is linear over a triangle: `nearness` has it at the corners.
    """
    which = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    x, y = low[which, 0] + place % across[which], low[which, 1] + place // across[which]
    a, b, c = (triangles[which, k] for k in range(3))
    sides = np.stack([_side(b, c, x, y), _side(c, a, x, y), _side(a, b, x, y)])
    inside = (sides >= 0.0).all(axis=0) | (sides <= 0.0).all(axis=0)
    weights, near = sides[:, inside], nearness[which[inside]].T
    total = weights.sum(axis=0)
    flat = total == 0.0  # seen from the edge: any of its corners
    depth = np.where(
        flat, 1.0 / near[0], np.where(flat, 1.0, total) / np.where(flat, 1.0, (weights * near).sum(axis=0))
    )
    np.minimum.at(canvas, (y[inside], x[inside]), depth)


def _side(a: np.ndarray, b: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return on which side of the lines from a to b points are: the sign of a cross product."""
    return (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])
