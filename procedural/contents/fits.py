"""Places for ice, beads and bubbles in a vessel, apart from each other and from what leans there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from ...core.mesh import Mesh
from ..description.floating import GAP
from .room import Room

#: Least distance between bodies in a vessel [m], and of bubbles from the glass that they stick to: far above the
#: renderer's ray offset of a micrometre, far below what a picture shows.
APART, STUCK = 2e-4, 2e-5
#: Places that are tried for each bead and each bubble [1].
_PLACES, _BUBBLE_PLACES = 400, 40
#: Depth of bubbles below the surface and from where liquids meet [m].
_DEPTH = 1e-3


def ice_places(
    rng: np.random.Generator,
    room: Room,
    edges: np.ndarray,
    level: float,
    others: Sequence[np.ndarray],
    *,
    sinks: bool = False,
) -> np.ndarray | None:
    """Return places for floating cubes: rows (x, y, turn about z) in [m] and [rad]; None where there is no room.

    Parameters
    ----------
    rng : numpy.random.Generator
        The stream.
    room : Room
        The vessel.
    edges : (n,) float
        Edges of the cubes [m].
    level : float
        About where the liquid's surface is [m].
    others : sequence of (k, 3) float
        Points of other bodies, dense [m].
    sinks : bool
        Whether a liquid is lighter than ice, so that cubes need room down to the floor.
    """
    placed: list[tuple[float, float, float]] = []
    for edge in edges.tolist():
        low, high = max(level - 1.05 * edge, room.floor), min(level + 0.5 * edge, room.brim)
        # (On the axis the floor has no width: half an edge over it, it has nearly that of a cube that lies there.)
        low = min(low, room.floor + 0.5 * edge) if sinks else low
        reach = room.narrowest(low, high) - 0.5 * edge * np.sqrt(2.0) - APART
        beside = [points[(points[:, 2] > low - edge) & (points[:, 2] < high + edge), :2] for points in others]
        near = [cKDTree(points) for points in beside if len(points)]
        for _ in range(_PLACES if reach > 0.0 else 0):
            radius, angle, turn = reach * np.sqrt(rng.random()), rng.uniform(0, 2 * np.pi), rng.uniform(0, np.pi / 2)
            x, y = room.axis + np.array([radius * np.cos(angle), radius * np.sin(angle)])
            square = _square(x, y, turn, 0.5 * edge + 0.5 * APART)
            free = all(
                _apart(square, _square(*other, 0.5 * e + 0.5 * APART)) for other, e in zip(placed, edges, strict=False)
            )
            if free and not any(_holds(square, some) for some in near):
                placed.append((x, y, turn))
                break
        else:
            return None
    return np.array(placed)


def _square(x: float, y: float, turn: float, half: float) -> np.ndarray:
    c, s = np.cos(turn), np.sin(turn)
    corners = half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return corners @ np.array([[c, s], [-s, c]]) + np.array([x, y])


def _apart(a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether two squares are apart: a side of one has the other beyond it."""
    for one, other in ((a, b), (b, a)):
        along = np.roll(one, -1, axis=0) - one
        outwards = np.stack([along[:, 1], -along[:, 0]], 1)
        beyond = np.einsum("ki,kji->kj", outwards, other[None] - one[:, None])
        if (beyond > 0.0).all(1).any():
            return True
    return False


def _holds(square: np.ndarray, tree: cKDTree) -> bool:
    """Return whether a point of a plane lies in a square or nearly so."""
    along, middle = square[1] - square[0], square.mean(0)
    side = float(np.hypot(*along))
    away = tree.data[tree.query_ball_point(middle, np.sqrt(0.5) * side + 2.0 * APART)] - middle
    half, (x, y) = 0.5 * side + APART, along / side
    beside = np.abs(away[:, 0] * x + away[:, 1] * y) < half
    return bool((beside & (np.abs(away[:, 1] * x - away[:, 0] * y) < half)).any())


def bead_places(
    rng: np.random.Generator, room: Room, radius: float, count: int, others: Sequence[np.ndarray]
) -> np.ndarray:
    """Return where balls come to lie that are dropped one after the other, (n, 3) [m]; fewer where no more have room.

    Each goes to the lowest of many places: on the floor, or in a hollow between others.
    """
    inner_reach = room.narrowest(room.floor + radius, room.floor + 3.0 * radius) - radius - GAP
    heights = room.ball_heights(radius, GAP)
    tree = cKDTree(np.concatenate(others)) if others else None
    placed, (x, y) = np.zeros((0, 3)), room.axis
    for _ in range(count):
        r = max(inner_reach, 0.0) * np.sqrt(rng.random(_PLACES))
        angle = rng.uniform(0.0, 2.0 * np.pi, _PLACES)
        places = np.stack([r * np.cos(angle) + x, r * np.sin(angle) + y, heights(r, angle)], 1)
        on_floor = places[:, 2].copy()
        for ball in placed:
            flat = np.hypot(*(places[:, :2] - ball[:2]).T)
            over = ball[2] + np.sqrt(np.maximum((2.0 * radius + GAP) ** 2 - flat**2, 0.0))
            places[:, 2] = np.where(flat < 2.0 * radius + GAP, np.maximum(places[:, 2], over), places[:, 2])
        free = np.isfinite(places[:, 2]) & (places[:, 2] + radius < room.brim)
        if len(placed):
            distance = np.linalg.norm(places[:, None] - placed, axis=2).min(1)
            free &= distance >= 2.0 * radius + 0.5 * GAP
        if tree is not None:
            free &= tree.query(places)[0] > radius + APART
        # The reach is that of the lowest layer: higher up, a shoulder may be in the way.
        higher = free & (places[:, 2] > on_floor)
        free[higher] = room.clearance(places[higher]) >= radius + 0.5 * GAP
        if not free.any():
            break
        best = int(np.where(free, places[:, 2], np.inf).argmin())
        placed = np.concatenate([placed, places[best : best + 1]])
    return placed


def bubble_places(
    rng: np.random.Generator, room: Room, radii: np.ndarray, levels: Sequence[float], others: Sequence[Mesh]
) -> np.ndarray:
    """Return where bubbles stick to the wall under liquids, (n, 4): middles and radii [m]; fewer without room.

    Parameters
    ----------
    rng : numpy.random.Generator
        The stream.
    room : Room
        The vessel.
    radii : (n,) float
        Their radii [m].
    levels : sequence of float
        Least heights of the liquids' surfaces [m], from the floor up.
    others : sequence of Mesh
        Bodies in the vessel.
    """
    wall = room.wall_below(levels[-1] - _DEPTH)
    if wall is None:
        return np.zeros((0, 4))
    points = [mesh.vertices.astype(np.float64) for mesh in others]
    tree = cKDTree(np.concatenate(points)) if points else None
    found = np.zeros((0, 4))
    for radius in radii.tolist():
        for _ in range(_BUBBLE_PLACES):
            middle = wall(rng, radius + STUCK)
            free = room.clearance(middle[None])[0] >= radius + 0.5 * STUCK
            free &= all(abs(middle[2] - level) > radius + _DEPTH for level in levels) and middle[2] < levels[-1]
            free &= tree is None or tree.query(middle)[0] > radius + 2.0 * _DEPTH
            if free and (np.linalg.norm(found[:, :3] - middle, axis=1) > found[:, 3] + radius + APART).all():
                found = np.concatenate([found, [[*middle, radius]]])
                break
    return found
