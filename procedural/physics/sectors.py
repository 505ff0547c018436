"""Walls of any shape as convex bodies: sectors around the vertical axis, cut by levels until every piece is convex.

What is no wall around an axis, as the cover of a book, is cut into slices instead where a few of them are convex.

Vessels with handles, spouts, flutes or corners are no solids of revolution, but their walls still run around an axis.
Cuts by planes are exact, and the hull of a piece contains it, so bodies that keep apart from the hulls keep apart from
the vessel.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...core.mesh import Mesh
from .wedges import ConvexPart

#: Sectors of a full turn, a power of two [1]: at a radius of 4 cm a chord lies 0.2 mm inside the circle.
SECTORS = 32
#: How far the surface may move so that it has fewer triangles [m].
SIMPLIFICATION = 1e-4
#: Mean depth of the dents of a piece that is convex enough, and the height of the lowest piece [m].
MEAN_DENT, LEAST_HEIGHT = 3e-4, 3e-3

#: Thinnest slice [m], and most of them [1]: a dozen halvings find both boards of a book.
LEAST_SLICE, MOST_SLICES = 4e-4, 24
#: How far the corners of a flat foot or rim may differ in height [m]: rounding to single precision.
_FLAT = 1e-7


def sector_parts(mesh: Mesh, wall: bool = True) -> tuple[np.ndarray, list[ConvexPart]]:
    """Return the corners of the hull (n, 3), and convex bodies that together contain a closed mesh around the z axis.

    Both are empty where the mesh is not closed. What is no `wall` around the axis is cut into slices where few of them
    are convex.
    """
    from manifold3d import Error, Manifold, Mesh64

    points, index = np.unique(mesh.vertices, axis=0, return_inverse=True)
    faces = index.reshape(-1)[mesh.faces].astype(np.uint64)
    solid = Manifold(Mesh64(points.astype(np.float64), faces))
    if solid.status() != Error.NoError or solid.volume() <= 0.0:
        return np.empty((0, 3)), []
    solid = solid.simplify(SIMPLIFICATION)
    components = solid.decompose()
    if any(some.volume() <= 0.0 for some in components):  # the surface of a hollow within
        components = [solid]
    pieces = [piece for whole in components for piece in _pieces(whole, wall)]
    return _standing(_corners(solid.hull()), points), [ConvexPart(_corners(piece)) for piece in pieces]


def _standing(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the corners of a hull with the foot and the rim of the surface that it was simplified from.

    A foot whose corners differ by a twentieth of a millimetre rocks, and a full vessel would count as upset.
    """
    low, high = points[:, 2].min(), points[:, 2].max()
    ends = points[(points[:, 2] < low + _FLAT) | (points[:, 2] > high - _FLAT)]
    inner = corners[(corners[:, 2] > low + SIMPLIFICATION) & (corners[:, 2] < high - SIMPLIFICATION)]
    return np.concatenate([inner, ends])


def _pieces(whole: Any, wall: bool) -> list[Any]:
    """Return hulls that together contain a connected solid."""
    hull = _hull_of(whole)
    if hull is not None:
        return [hull]
    for axis in () if wall else (2, 0, 1):
        slices = _slices(whole, axis)
        if slices is not None:
            return slices
    halves = whole.split_by_plane((0.0, 1.0, 0.0), 0.0)
    sectors = [
        sector
        for number, half in enumerate(halves)
        for part in half.decompose()
        for sector in _sectors(part, np.pi * number, np.pi * (number + 1), SECTORS // 2)
    ]
    return [piece for sector in sectors for piece in _levels(sector)]


def _slices(whole: Any, axis: int) -> list[Any] | None:
    """Return hulls of slices across an axis that together contain a solid; None where they are not convex or many."""
    found, waiting = [], [whole]
    normal = tuple(float(k == axis) for k in range(3))
    while waiting:
        piece = waiting.pop()
        hull = _hull_of(piece)
        if hull is not None:
            found.append(hull)
            continue
        box = piece.bounding_box()
        low, high = box[axis], box[axis + 3]
        if high - low < LEAST_SLICE or len(found) + len(waiting) >= MOST_SLICES:
            return None
        for part in piece.split_by_plane(normal, 0.5 * (low + high)):
            waiting += part.decompose()
    return found


def _corners(solid: Any) -> np.ndarray:
    return np.array(solid.to_mesh64().vert_properties, dtype=np.float64)[:, :3]


def _hull_of(piece: Any) -> Any:
    """Return the hull of a piece that is convex enough, or None."""
    hull = piece.hull()
    return hull if hull.volume() - piece.volume() <= 0.5 * MEAN_DENT * hull.surface_area() else None


def _sectors(solid: Any, start: float, end: float, count: int) -> list[Any]:
    """Return sectors between two angles [rad], which the solid lies between: a number of equal ones, or fewer.

    What is convex enough is cut no further.
    """
    if solid.is_empty():
        return []
    if count == 1 or _hull_of(solid) is not None:
        return [solid]
    middle = 0.5 * (start + end)
    after, before = solid.split_by_plane((-np.sin(middle), np.cos(middle), 0.0), 0.0)
    return [
        sector
        for some, low, high in ((before, start, middle), (after, middle, end))
        for part in some.decompose()
        for sector in _sectors(part, low, high, count // 2)
    ]


def _levels(sector: Any) -> list[Any]:
    """Return hulls of the pieces of a sector between levels, each convex enough or low."""
    found, waiting = [], list(sector.decompose())
    while waiting:
        piece = waiting.pop()
        low, high = piece.bounding_box()[2], piece.bounding_box()[5]
        hull = piece.hull() if high - low < LEAST_HEIGHT else _hull_of(piece)
        if hull is None:
            for part in piece.split_by_plane((0.0, 0.0, 1.0), 0.5 * (low + high)):
                waiting += part.decompose()
        elif hull.volume() > 0.0:
            found.append(hull)
    return found
