"""Triangulate flat regions with holes, without new points: every edge of the outline is an edge of one triangle.

Holes are joined to their outline by bridges, and ears are cut off (Meisters 1975, "Polygons have ears", American
Mathematical Monthly 82(6); bridges after Eberly, "Triangulation by Ear Clipping", 2008).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def triangulated(points: np.ndarray, loops: Sequence[np.ndarray]) -> np.ndarray:
    """Return triangles that fill outlines less their holes.

    Parameters
    ----------
    points : (n, 2) float64
        Positions.
    loops : sequence of (k,) int
        Closed rings of points that do not cross: outlines counter-clockwise, holes clockwise.

    Returns
    -------
    (m, 3) int64
        Indices into `points`, counter-clockwise.

    Raises
    ------
    ValueError
        Where a hole has no outline around it.
    """
    rings = [np.asarray(loop, np.int64) for loop in loops]
    areas = [_area(points[ring]) for ring in rings]
    outlines = [ring for ring, area in zip(rings, areas, strict=True) if area > 0.0]
    holes: dict[int, list[np.ndarray]] = {number: [] for number in range(len(outlines))}
    sizes = [area for area in areas if area > 0.0]
    for ring, area in zip(rings, areas, strict=True):
        if area > 0.0:
            continue
        around = [k for k, outline in enumerate(outlines) if _contains(points[outline], points[ring[0]])]
        if not around:
            raise ValueError("expected an outline around every hole, found none")
        holes[min(around, key=lambda k: sizes[k])].append(ring)
    parts = [_clipped(points, _bridged(points, outline, holes[k])) for k, outline in enumerate(outlines)]
    return np.concatenate(parts) if parts else np.zeros((0, 3), np.int64)


def _area(ring: np.ndarray) -> float:
    x, y = (ring - ring[0]).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _contains(ring: np.ndarray, point: np.ndarray) -> bool:
    a, b = ring, np.roll(ring, -1, axis=0)
    spans = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
    a, b = a[spans], b[spans]
    x = a[:, 0] + (point[1] - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    return bool((x > point[0]).sum() % 2)


def _bridged(points: np.ndarray, outline: np.ndarray, holes: list[np.ndarray]) -> np.ndarray:
    """Return one ring that goes round the outline and, over bridges, round every hole."""
    ring = outline
    for hole in sorted(holes, key=lambda one: -points[one, 0].max()):
        start = int(points[hole, 0].argmax())
        place = _visible(points[ring], points[hole[start]])
        turned = np.roll(hole, -start)
        ring = np.concatenate([ring[: place + 1], turned, turned[:1], ring[place:]])
    return ring


def _visible(ring: np.ndarray, point: np.ndarray) -> int:
    """Return a corner of a ring that the point, the rightmost of a hole, sees: by a ray along +x (Eberly)."""
    a, b = ring, np.roll(ring, -1, axis=0)
    upward = (a[:, 1] <= point[1]) & (b[:, 1] > point[1])  # the hole's outline is counter-clockwise: it is to the left
    with np.errstate(divide="ignore", invalid="ignore"):
        x = a[:, 0] + (point[1] - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    x = np.where(upward & (x >= point[0]), x, np.inf)
    edge = int(x.argmin())
    hit = np.array([x[edge], point[1]])
    end = edge if a[edge, 0] > b[edge, 0] else (edge + 1) % len(ring)
    inside = _within(ring, point, hit, ring[end]) | _within(ring, point, ring[end], hit)
    inside &= (ring != ring[end]).any(1) & _reflex(ring)
    if not inside.any():
        return end
    away = ring - point
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(inside, np.abs(away[:, 1]) / np.maximum(away[:, 0], 1e-300), np.inf)
    best = np.flatnonzero(slope <= slope.min() * (1.0 + 1e-12))
    return int(best[np.hypot(*away[best].T).argmin()])


def _reflex(ring: np.ndarray) -> np.ndarray:
    return _turns(np.roll(ring, 1, axis=0), ring, np.roll(ring, -1, axis=0)) <= 0.0


def _turns(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return twice the signed area of the triangles (a, b, c)."""
    u, v = b - a, c - a
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def _within(points: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    return (_turns(a, b, points) >= 0.0) & (_turns(b, c, points) >= 0.0) & (_turns(c, a, points) >= 0.0)


def _clipped(points: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Return the triangles of a ring, whose bridges it passes twice: ears are cut off, round and round."""
    places = points[ring]
    count = len(ring)
    after, before = np.roll(np.arange(count), -1), np.roll(np.arange(count), 1)
    left = np.ones(count, dtype=bool)
    triangles, corner, since = [], 0, 0
    while count > 3:
        a, b, c = int(before[corner]), corner, int(after[corner])
        # After a whole round without an ear, rounding is in the way: any corner that turns left will do, then any.
        if _is_ear(places, left, (a, b, c), since // (count + 1)):
            triangles.append((a, b, c))
            left[b] = False
            after[a], before[c] = c, a
            count -= 1
            since = 0
            corner = int(after[c])  # not the next one: fans from one corner are thin
        else:
            corner, since = c, since + 1
    triangles.append((before[corner], corner, after[corner]))
    return ring[np.array(triangles)]


def _is_ear(places: np.ndarray, left: np.ndarray, corners: tuple[int, int, int], rounds: int) -> bool:
    a, b, c = (places[k] for k in corners)
    if rounds > 1:
        return True
    if _turns(a, b, c) <= 0.0:
        return False
    if rounds:
        return True
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    near = places[left & ((places >= low) & (places <= high)).all(1)]
    # Ends of bridges are twice in the ring: what is at a corner is not inside.
    near = near[~((near == a).all(1) | (near == b).all(1) | (near == c).all(1))]
    return not _within(near, a, b, c).any()
