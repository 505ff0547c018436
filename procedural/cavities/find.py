"""Find the cavities of a solid: where it would hold liquid as it stands, up to which height, and how much.

Liquid stands in a part of the free space that is not connected to the outside below a height: the highest such height
is the brim. It is the smallest, over all ways out, of the highest point of the way (a minimax path), which the minimum
spanning tree of the free space has (Hu 1961, "The maximum capacity route problem", Operations Research 9(6)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from .columns import Columns

#: A cavity is deeper than this [m], and holds more than this [m^3] and this fraction of the largest one [1]: dents of
#: feet, handles and ornaments hold less.
LEAST_DEPTH, LEAST_VOLUME, LEAST_PART = 2e-3, 2e-7, 0.02


@dataclass(frozen=True, eq=False)
class Hollow:
    """A cavity, as vertical lines meet it.

    Parameters
    ----------
    intervals : (k,) int
        Its intervals of the columns' free space.
    bottom, top : (k,) float64
        Their ends, of which the upper one is at most the brim [m].
    brim : float
        Height at which liquid would flow out [m].
    area : float
        What each line stands for [m^2].
    """

    intervals: np.ndarray
    bottom: np.ndarray
    top: np.ndarray
    brim: float
    area: float

    @property
    def floor(self) -> float:
        """Height of the lowest point [m]."""
        return float(self.bottom.min())

    @property
    def volume(self) -> float:
        """Volume up to the brim [m^3]."""
        return self.volume_below(self.brim)

    def volume_below(self, level: float) -> float:
        """Return the volume up to a level [m^3]."""
        return float(np.maximum(np.minimum(self.top, level) - self.bottom, 0.0).sum()) * self.area

    def area_at(self, level: float) -> float:
        """Return the area of a liquid's surface at a level [m^2]."""
        return float(((self.bottom < level) & (level <= self.top)).sum()) * self.area


def hollows(columns: Columns) -> tuple[Hollow, ...]:
    """Return the cavities of a solid, the largest first."""
    start, end, pass_height = _links(columns)
    brim, tree = _brims(len(columns.bottom), start, end, pass_height)
    holds = np.isfinite(brim) & (brim > columns.bottom)
    holds[0] = False
    a, b, height = tree
    joined = holds[a] & holds[b] & (height < np.minimum(brim[a], brim[b]))
    links = coo_array((np.ones(joined.sum()), (a[joined], b[joined])), shape=(len(brim), len(brim)))
    _, label = connected_components(links, directed=False)
    members = np.flatnonzero(holds)
    members = members[np.argsort(label[members], kind="stable")]
    groups = np.split(members, np.flatnonzero(np.diff(label[members])) + 1) if len(members) else []
    found = [_hollow(columns, group, brim) for group in groups]
    found = [one for one in found if one.brim - one.floor > LEAST_DEPTH and one.volume > LEAST_VOLUME]
    found.sort(key=lambda one: -one.volume)
    return tuple(one for one in found if one.volume >= LEAST_PART * found[0].volume)


def _hollow(columns: Columns, group: np.ndarray, brim: np.ndarray) -> Hollow:
    height = float(brim[group[0]])
    return Hollow(group, columns.bottom[group], np.minimum(columns.top[group], height), height, columns.pitch**2)


def _links(columns: Columns) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return pairs of intervals of lines side by side that meet, and the height from which on they do."""
    nx, ny = columns.shape
    counts = np.bincount(columns.column[1:], minlength=nx * ny)
    firsts = 1 + np.cumsum(counts) - counts
    lines = np.arange(nx * ny).reshape(nx, ny)
    sides = [(lines[:-1].ravel(), lines[1:].ravel()), (lines[:, :-1].ravel(), lines[:, 1:].ravel())]
    left, right = (np.concatenate([side[k] for side in sides]) for k in (0, 1))
    most = int(counts.max())
    unequal = [(i, j) for i in range(most) for j in range(-1, i)]
    parts = [_met(columns, left, right, firsts, counts, i, j) for i, j in unequal]
    parts += [_met(columns, right, left, firsts, counts, i, j) for i, j in unequal]
    parts += [_met(columns, left, right, firsts, counts, i, i) for i in range(most)]
    start, end, height = (np.concatenate([part[k] for part in parts]) for k in range(3))
    # Several ways to the outside are one: the lowest.
    order = np.lexsort((height, end, start))
    start, end, height = start[order], end[order], height[order]
    new = np.concatenate([[True], (np.diff(start) != 0) | (np.diff(end) != 0)])
    return start[new], end[new], height[new]


def _met(
    columns: Columns, left: np.ndarray, right: np.ndarray, firsts: np.ndarray, counts: np.ndarray, i: int, j: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return where interval i of the left line meets interval j of the right one; -1 is the part below the solid."""
    both = (counts[left] > i) & (counts[right] > j)
    left, right = left[both], right[both]
    a, bottom_a, top_a = _interval(columns, left, firsts, i)
    b, bottom_b, top_b = _interval(columns, right, firsts, j)
    height = np.maximum(bottom_a, bottom_b)
    meet = height < np.minimum(top_a, top_b)
    a, b, height = a[meet], b[meet], height[meet]
    return np.minimum(a, b), np.maximum(a, b), height


def _interval(
    columns: Columns, lines: np.ndarray, firsts: np.ndarray, number: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    if number < 0:
        return np.zeros(len(lines), np.int64), np.full(len(lines), -np.inf), columns.first[lines]
    index = firsts[lines] + number
    return index, columns.bottom[index], columns.top[index]


def _brims(
    count: int, start: np.ndarray, end: np.ndarray, height: np.ndarray
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return the height at which each interval's liquid would reach the outside, and the tree that it follows from."""
    # Ranks instead of heights: zero would be no link.
    order = np.argsort(height, kind="stable")
    rank = np.empty(len(order))
    rank[order] = np.arange(1, len(order) + 1)
    graph = coo_array((rank, (start, end)), shape=(count, count)).tocsr()
    tree = minimum_spanning_tree(graph).tocoo()
    place = order[tree.data.astype(np.int64) - 1]
    a, b, weight = tree.row.astype(np.int64), tree.col.astype(np.int64), height[place]
    reached, before = breadth_first_order(tree.tocsr(), 0, directed=False)
    brim, up = np.full(count, np.inf), np.arange(count)
    child = np.where(before[b] == a, b, a)
    brim[child] = weight
    closed = np.ones(count, dtype=bool)  # bubbles, from which no way leads out
    closed[reached] = False
    brim[closed], brim[0] = np.inf, -np.inf
    up[reached[1:]] = before[reached[1:]]
    for _ in range(count.bit_length()):
        brim = np.maximum(brim, brim[up])
        up = up[up]
    return brim, (a, b, weight)
