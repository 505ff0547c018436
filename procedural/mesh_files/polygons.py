"""Polygons as triangles: fans where they are convex, ears cut off where they are not."""

from __future__ import annotations

import numpy as np

#: A polygon with more corners is cut into a fan without a search for ears [1]: the search takes the square of them.
MOST_CORNERS = 1_000


def triangulated(corners: np.ndarray, counts: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of polygons.

    Parameters
    ----------
    corners : (c,) int
        Indices into `points`, polygon after polygon.
    counts : (p,) int
        Number of corners of each polygon; those of fewer than three have no triangle.
    points : (n, 3) float
        Positions.

    Returns
    -------
    (m, 3) int, (m,) int
        Triangles as places in `corners`, and the number of the polygon of each, ascending.
    """
    firsts = np.cumsum(counts) - counts
    triangles, owners = [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)]
    for count in np.unique(counts[counts >= 3]).tolist():
        which = np.flatnonzero(counts == count)
        places = firsts[which, None] + np.arange(count)
        fan = np.stack([np.zeros(count - 2, np.int64), np.arange(1, count - 1), np.arange(2, count)], 1)
        pieces = np.broadcast_to(fan, (len(which), *fan.shape)).copy()
        if 3 < count <= MOST_CORNERS:
            shapes = points[corners[places]]
            for number in np.flatnonzero(~_fan_fits(shapes)):
                pieces[number] = _ears(shapes[number])
        triangles.append((firsts[which, None, None] + pieces).reshape(-1, 3))
        owners.append(np.repeat(which, count - 2))
    triangles, owners = np.concatenate(triangles), np.concatenate(owners)
    order = np.argsort(owners, kind="stable")
    return triangles[order], owners[order]


def _fan_fits(shapes: np.ndarray) -> np.ndarray:
    """Return whether the triangles between the first corner and the others all face as the polygon does, (p,) bool."""
    normal = _normal(shapes)
    arms = shapes[:, 1:] - shapes[:, :1]
    with np.errstate(all="ignore"):
        facing = np.einsum("pij,pj->pi", np.cross(arms[:, :-1], arms[:, 1:]), normal)
    return ~(facing < 0.0).any(1)


def _normal(shapes: np.ndarray) -> np.ndarray:
    """Return the vector area of each polygon, (p, 3) (Newell's method)."""
    with np.errstate(all="ignore"):
        return np.cross(shapes, np.roll(shapes, -1, axis=1)).sum(1)


def _ears(shape: np.ndarray) -> np.ndarray:
    """Return the triangles of one polygon (n, 3) by ear clipping (Meisters 1975), (n - 2, 3) int."""
    normal = _normal((shape - shape[0])[None])[0]
    axis = int(np.abs(normal).argmax())
    flat = np.delete(shape, axis, axis=1) * np.array([1.0, -1.0 if (axis == 1) != (normal[axis] < 0) else 1.0])
    rest, found = list(range(len(shape))), []
    while len(rest) > 3:
        place = next((place for place in range(len(rest)) if _is_ear(flat, rest, place)), 0)
        found.append((rest[place - 1], rest[place], rest[(place + 1) % len(rest)]))
        del rest[place]
    return np.array([*found, tuple(rest)])


def _is_ear(flat: np.ndarray, rest: list[int], place: int) -> bool:
    """Return whether a corner turns left and no other corner is inside its triangle."""
    before, here, after = rest[place - 1], rest[place], rest[(place + 1) % len(rest)]
    a, b, c = flat[before], flat[here], flat[after]
    if _side(a, b, c[None])[0] <= 0.0:
        return False
    # Corners at the same place as one of the three do not count: a hole is joined to the outline by two equal edges.
    others = flat[[corner for corner in rest if corner not in (before, here, after)]]
    others = others[~np.any([(others == corner).all(1) for corner in (a, b, c)], axis=0)]
    inside = (_side(a, b, others) >= 0.0) & (_side(b, c, others) >= 0.0) & (_side(c, a, others) >= 0.0)
    return not inside.any()


def _side(a: np.ndarray, b: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return twice the signed area of the triangles between a, b and each point; positive to the left."""
    along, to = b - a, points - a
    return along[0] * to[:, 1] - along[1] * to[:, 0]
