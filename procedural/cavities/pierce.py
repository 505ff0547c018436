"""Make holes in the surface of a liquid where bodies reach through it.

The triangles that a hole touches are taken out, and the gap up to the hole is filled again without new points: the
hole's edges are then those of the body, and the other triangles stay what they were.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from ...core.mesh import Mesh
from .polygon import triangulated

#: Holes count as wider by this [m], so that no triangle is left that a hole all but touches.
_MARGIN = 2e-5


def pierced(
    surface: Mesh,
    rings: Sequence[np.ndarray],
    normal: Callable[[np.ndarray], np.ndarray],
    flatten: Callable[[np.ndarray], np.ndarray],
) -> Mesh:
    """Return the surface of a liquid less what bodies take of it.

    Parameters
    ----------
    surface : Mesh
        One height above each place; normals up.
    rings : sequence of (k, 3) float32
        Closed lines on it, the liquid on their left seen from above (`split.split_at`): around bodies clockwise, and
        counter-clockwise around liquid in a tube [m].
    normal : callable
        Unit normals (n, 3) of the surface at places (n, 3).
    flatten : callable
        The surface laid out in a plane: places (n, 3) to (n, 2), without a turn. Seen from above, triangles where it is
        steep would be too thin to tell their sides.

    Raises
    ------
    ValueError
        Where a hole reaches over the surface's edge, or two holes meet.
    """
    if not rings:
        return surface
    places, index = _welded(surface.vertices)
    faces = index[surface.faces]
    plan = flatten(places.astype(np.float64))
    gone = _touched(plan, faces, [flatten(ring.astype(np.float64)) for ring in rings])
    gone = _without_pinches(faces, gone, len(places))
    border = _loops(faces[gone])
    ends = len(places) + np.cumsum([0, *(len(ring) for ring in rings)])
    holes = [np.arange(start, end) for start, end in itertools.pairwise(ends)]
    points = np.concatenate([places, *rings])
    fill = triangulated(flatten(points.astype(np.float64)), [*border, *holes])
    return _joined(surface, faces, gone, points, fill, normal)


def lid(mesh: Mesh) -> Mesh | None:
    """Return flat triangles that close a surface whose borders lie level, normals up; None for a closed surface."""
    places, index = _welded(mesh.vertices)
    faces = index[mesh.faces]
    start, _end = _border(faces)
    if not len(start):
        return None
    # The border of the lid runs the other way.
    loops = [loop[::-1] for loop in _loops(faces)]
    fill = triangulated(places[:, :2].astype(np.float64), loops)
    return Mesh("lid", places, fill)


def _joined(
    surface: Mesh,
    faces: np.ndarray,
    gone: np.ndarray,
    points: np.ndarray,
    fill: np.ndarray,
    normal: Callable[[np.ndarray], np.ndarray],
) -> Mesh:
    a, b, c = (points[fill[:, k]] for k in range(3))
    proper = (a != b).any(1) & (b != c).any(1) & (c != a).any(1)
    all_faces = np.concatenate([faces[~gone], fill[proper]])
    used, numbers = np.unique(all_faces, return_inverse=True)
    vertices = points[used]
    return Mesh(surface.name, vertices, numbers.reshape(-1, 3), normal(vertices.astype(np.float64)))


def _welded(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    keys = np.ascontiguousarray(vertices + np.float32(0.0)).view("V12").ravel()
    _, first, index = np.unique(keys, return_index=True, return_inverse=True)
    return vertices[first], index.reshape(-1)


def _touched(places: np.ndarray, faces: np.ndarray, rings: list[np.ndarray]) -> np.ndarray:
    """Return which triangles holes touch, (m,) bool."""
    corners = places[faces]
    low, high = corners.min(1), corners.max(1)
    gone = np.zeros(len(faces), dtype=bool)
    for ring in rings:
        # Triangles are convex: one that is met has a corner in the ring, a point of the ring in it, or crossing edges.
        near = ((low <= ring.max(0) + _MARGIN) & (high >= ring.min(0) - _MARGIN)).all(1) & ~gone
        some = np.flatnonzero(near)
        if not len(some):
            continue
        met = _inside(ring, corners[some].reshape(-1, 2)).reshape(-1, 3).any(1)
        rest = some[~met]
        gone[some[met]] = True
        gone[rest] = _near_ring(corners[rest], ring)
    return gone


def _inside(ring: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return which points (k, 2) a ring goes round, by the crossings of a ray along +x."""
    a, b = ring[:, None], np.roll(ring, -1, axis=0)[:, None]
    spans = (a[..., 1] > points[:, 1]) != (b[..., 1] > points[:, 1])
    rise = np.where(b[..., 1] == a[..., 1], 1.0, b[..., 1] - a[..., 1])
    x = a[..., 0] + (points[:, 1] - a[..., 1]) / rise * (b[..., 0] - a[..., 0])
    return (spans & (x > points[:, 0])).sum(0) % 2 == 1


def _near_ring(corners: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Return which triangles (k, 3, 2) come nearer to the edges of a ring than the margin, (k,) bool."""
    found = np.zeros(len(corners), dtype=bool)
    start, end = ring, np.roll(ring, -1, axis=0)
    for _k, (p, q) in enumerate(zip(start, end, strict=True)):
        box = (corners.max(1) >= np.minimum(p, q) - _MARGIN) & (corners.min(1) <= np.maximum(p, q) + _MARGIN)
        some = np.flatnonzero(box.all(1) & ~found)
        found[some] = _segment_near(corners[some], p, q)
    return found


def _segment_near(corners: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return which triangles a segment, as wide as the margin, meets: no axis of their sides separates them."""
    axes = [np.stack([-(b - a)[:, 1], (b - a)[:, 0]], 1) for a, b in _sides(corners)]
    along = np.broadcast_to(np.array([-(q - p)[1], (q - p)[0]]), (len(corners), 2))
    met = np.ones(len(corners), dtype=bool)
    for axis in (*axes, along):
        length = np.linalg.norm(axis, axis=1)
        spread = np.einsum("kij,kj->ki", corners, axis)
        one, other = axis @ p, axis @ q
        gap = np.maximum(np.minimum(one, other) - spread.max(1), spread.min(1) - np.maximum(one, other))
        met &= gap <= _MARGIN * length
    return met


def _sides(corners: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    return [(corners[:, k], corners[:, (k + 1) % 3]) for k in range(3)]


def _without_pinches(faces: np.ndarray, gone: np.ndarray, count: int) -> np.ndarray:
    """Return the triangles to take out, with all around points where two parts of the gap would only touch."""
    while True:
        begin, _ = _border(faces[gone])
        pinched = np.flatnonzero(np.bincount(begin, minlength=count) > 1)
        if not len(pinched):
            return gone
        more = gone | np.isin(faces, pinched).any(1)
        if (more == gone).all():
            raise ValueError("expected a surface of one sheet, found triangles that touch in a point")
        gone = more


def _border(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the edges that only one of some faces has, in that face's direction."""
    start, end = faces.ravel().astype(np.int64), np.roll(faces, -1, axis=1).ravel().astype(np.int64)
    count = int(faces.max()) + 1 if len(faces) else 1
    alone = ~np.isin(start * count + end, end * count + start)
    return start[alone], end[alone]


def _loops(faces: np.ndarray) -> list[np.ndarray]:
    start, end = _border(faces)
    after = dict(zip(start.tolist(), end.tolist(), strict=True))
    loops = []
    while after:
        first, place = after.popitem()
        loop = [first]
        while place != first:
            loop.append(place)
            place = after.pop(place)
        loops.append(np.array(loop, np.int64))
    return loops
