"""How far points are from the glass of a vessel of revolution, and how low bodies can lie in it."""

from __future__ import annotations

import numpy as np

#: Distance of points on a section in search of what is near it [m].
_SAMPLED = 1e-3
#: Points for which distances from all segments are computed at once [1]: a bound on memory.
_AT_ONCE = 4096


def clearance(outer: np.ndarray, inner: np.ndarray, points: np.ndarray, within: float = np.inf) -> np.ndarray:
    """Return the distance of points from the glass [m], negative in it, or inf where it is over `within`.

    Parameters
    ----------
    outer, inner : (n, 2) float
        The profiles, rows (r, z), from the axis to the rim's crown [m].
    points : (k, 3) float
        Points in the same frame [m].
    within : float
        A bound of a few millimetres saves most of the time [m].
    """
    section = np.stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]], axis=1)
    ring = np.concatenate([outer, inner[-2::-1]])  # around the glass, closed along the axis
    found = np.full(len(points), np.inf)
    near = np.ones(len(points), bool) if np.isinf(within) else _near(section, ring, within)
    distance = _distance(section[near], ring)
    found[near] = np.where(_within(section[near], ring), -distance, distance)
    return found


def _near(points: np.ndarray, ring: np.ndarray, within: float) -> np.ndarray:
    """Return which points may be within a distance of a ring, and all that are."""
    from scipy.spatial import cKDTree

    across = np.zeros((len(ring), 3))
    across[:, [0, 2]] = ring
    samples = along_edges(np.stack([across[:-1], across[1:]], axis=1), _SAMPLED)[:, [0, 2]]
    # No place on the ring is farther than a step from a sample.
    bound = within + _SAMPLED
    return np.isfinite(cKDTree(samples).query(points, distance_upper_bound=bound)[0])


def along_edges(edges: np.ndarray, step: float) -> np.ndarray:
    """Return points on edges (n, 2, 3), at most a step apart [m], (k, 3)."""
    length = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    counts = np.maximum(np.ceil(length / step).astype(int), 1)
    edge = np.repeat(np.arange(len(edges)), counts)
    t = (np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[edge]
    return edges[edge, 0] + t[:, None] * (edges[edge, 1] - edges[edge, 0])


def floor_under(inner: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Return the height of the inside at distances from the axis [m]: of its lowest place there; inf beyond it."""
    widest = int(inner[:, 0].argmax())
    r, z = inner[: widest + 1].T
    rising = np.maximum.accumulate(r)
    height = np.interp(radius, rising, z)
    return np.where(radius <= rising[-1], height, np.inf)


def _distance(points: np.ndarray, ring: np.ndarray) -> np.ndarray:
    start, along = ring[:-1], np.diff(ring, axis=0)
    length2 = np.maximum((along**2).sum(1), np.finfo(float).tiny)
    found = np.empty(len(points))
    for first in range(0, len(points), _AT_ONCE):
        some = points[first : first + _AT_ONCE, None] - start
        t = np.clip((some * along).sum(-1) / length2, 0.0, 1.0)
        found[first : first + _AT_ONCE] = np.sqrt(((some - t[..., None] * along) ** 2).sum(-1).min(1))
    return found


def _within(points: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Return which points the glass's section holds, by the crossings of a ray along +r."""
    (r0, z0), (r1, z1) = ring[:-1].T, ring[1:].T
    spans = (z0 > points[:, 1:]) != (z1 > points[:, 1:])
    rise = np.where(z1 == z0, 1.0, z1 - z0)
    crossing = r0 + (points[:, 1:] - z0) / rise * (r1 - r0)
    return (spans & (crossing > points[:, :1])).sum(1) % 2 == 1
