"""View selection: which views can be a reference, and which are its sources."""

from __future__ import annotations

import numpy as np

from ...procedural.surroundings.camera_poses import RING_VIEWS, RINGS

#: Last grid index of a reference view: views of the lowest ring look along the table (rule of the released code).
LAST_REFERENCE = 1 + (RINGS - 1) * RING_VIEWS - 1


def grid_neighbours(index: int) -> frozenset[int]:
    """Return the neighbours of a grid index: left, right, and three in each adjacent ring.

    The zenith is a neighbour of the first ring only. (Rule of the released MVTrans, whose grid goes from the zenith
    down in 4 rings of 14.)
    """
    if index == 0:
        return frozenset(range(1, 1 + RING_VIEWS))
    ring, column = divmod(index - 1, RING_VIEWS)
    found = {_index(ring, column - 1), _index(ring, column + 1)}
    for other in (ring - 1, ring + 1):
        if 0 <= other < RINGS:
            found |= {_index(other, column + shift) for shift in (-1, 0, 1)}
    if ring == 0:
        found.add(0)
    return frozenset(found)


def nearest_cameras(positions: np.ndarray, reference: int, count: int) -> np.ndarray:
    """Return the indices of the cameras nearest to one, the nearest first, (min(count, n - 1),) int.

    Parameters
    ----------
    positions : (n, 3) float
        Positions of the cameras [m].
    reference : int
        Index of the reference camera.
    count : int
        Number of cameras.
    """
    distance = np.linalg.norm(positions - positions[reference], axis=1)
    distance[reference] = np.inf
    return np.argsort(distance, kind="stable")[: min(count, len(positions) - 1)]


def _index(ring: int, column: int) -> int:
    return 1 + ring * RING_VIEWS + column % RING_VIEWS
