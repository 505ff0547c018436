"""Which views are seen together with a reference view."""

from __future__ import annotations

import numpy as np

from ...procedural.surroundings.cameras import RING_VIEWS, RINGS

#: Last grid index of a reference view: those of the lowest ring look along the table (the released code's rule).
LAST_REFERENCE = 1 + (RINGS - 1) * RING_VIEWS - 1


def grid_neighbours(index: int) -> frozenset[int]:
    """Return the grid indices next to one: left, right, and three in each ring beside its own.

    The zenith is next to all of the first ring, and to it alone. (The rule of the released MVTrans, where the grid goes
    from the zenith down in 4 rings of 14.)
    """
    if index == 0:
        return frozenset(range(1, 1 + RING_VIEWS))
    ring, place = divmod(index - 1, RING_VIEWS)
    found = {_at(ring, place - 1), _at(ring, place + 1)}
    for other in (ring - 1, ring + 1):
        if 0 <= other < RINGS:
            found |= {_at(other, place + shift) for shift in (-1, 0, 1)}
    if ring == 0:
        found.add(0)
    return frozenset(found)


def nearest_cameras(positions: np.ndarray, reference: int, count: int) -> np.ndarray:
    """Return the indices of the cameras nearest to one, (count,) int, the nearest first; fewer where there are fewer.

    Parameters
    ----------
    positions : (n, 3) float
        Where the cameras are [m].
    reference : int
        Which of them is the reference.
    count : int
        How many.
    """
    away = np.linalg.norm(positions - positions[reference], axis=1)
    away[reference] = np.inf
    return np.argsort(away, kind="stable")[: min(count, len(positions) - 1)]


def _at(ring: int, place: int) -> int:
    return 1 + ring * RING_VIEWS + place % RING_VIEWS
