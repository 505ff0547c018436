"""How thick the wall around a cavity is: the distance from points of its inside to the outside."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

#: Points on the inside, and on the outside [1]: on a 1-litre vessel, of 0.06 m^2, the latter are 1 mm apart. Distances
#: are to the triangles that the nearest of them lie in.
INSIDE_POINTS, OUTSIDE_POINTS = 2000, 60_000
#: Nearest points of the outside whose triangles are looked at [1].
_NEAREST = 8
#: Quantile of the distances that is the thickness of the thinnest wall [1]: single triangles decide nothing.
THINNEST = 0.02
#: Steps of the two-dimensional golden-ratio sequence (Roberts 2018, "The unreasonable effectiveness of quasirandom
#: sequences").
_STEPS = np.array([0.7548776662466927, 0.5698402909980532])


def thicknesses(corners: np.ndarray, inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
    """Return the distances of points of inner faces from the outer faces, sorted, (k,) float64 [m].

    Parameters
    ----------
    corners : (m, 3, 3) float64
        Corners of all faces [m].
    inner, outer : (m,) bool
        Faces of the cavities, without those near their brim; and of the outside.
    """
    points, _ = spread(corners[inner], INSIDE_POINTS)
    targets, face = spread(corners[outer], OUTSIDE_POINTS)
    _, near = cKDTree(targets).query(points, k=min(_NEAREST, len(targets)))
    triangles = corners[outer][face[near.reshape(len(points), -1)]]
    distance = np.stack([point_triangle(points, triangles[:, k]) for k in range(triangles.shape[1])]).min(0)
    return np.sort(distance)


def spread(corners: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points spread evenly over triangles (m, 3, 3), (count, 3), and the triangle of each."""
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    total = np.cumsum(area)
    face = np.searchsorted(total, (np.arange(count) + 0.5) / count * total[-1]).clip(0, len(corners) - 1)
    u, v = (0.5 + np.arange(1, count + 1)[:, None] * _STEPS).T % 1.0
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u)[:, None], np.where(over, 1.0 - v, v)[:, None]
    a, b, c = (corners[face, k] for k in range(3))
    return a + u * (b - a) + v * (c - a), face


def point_triangle(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the distance of each point (k, 3) from its triangle (k, 3, 3) [m]."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    sides = np.stack([_segment(points, p, q) for p, q in ((a, b), (b, c), (c, a))]).min(0)
    normal = np.cross(b - a, c - a)
    within = np.all(
        [np.einsum("ij,ij->i", np.cross(q - p, points - p), normal) >= 0.0 for p, q in ((a, b), (b, c), (c, a))], axis=0
    )
    length = np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)
    plane = np.abs(np.einsum("ij,ij->i", points - a, normal)) / length
    return np.where(within & (length > np.finfo(float).tiny), plane, sides)


def _segment(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    along = end - start
    length2 = np.maximum((along**2).sum(1), np.finfo(float).tiny)
    t = np.clip(((points - start) * along).sum(1) / length2, 0.0, 1.0)
    return np.linalg.norm(points - start - t[:, None] * along, axis=1)
