"""A solid along vertical lines: where a grid of lines enters and leaves it, and the free space between.

This is the depth-element representation of solids (Van Hook 1986, "Real-time shaded NC milling display", SIGGRAPH '86).
Heights are exact; only across the lines is the solid sampled.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Most lines of a grid [1], and the fractions of the wall's thickness and of the solid's width that lines are apart: a
#: wall that is thicker than the distance of two lines is met by one of them wherever it stands upright.
MOST_LINES = 640 * 640
PITCH_PER_WALL, PITCH_PER_WIDTH = 0.6, 1.0 / 160.0
#: Place of the first line off the solid's box, in distances of lines [1]: such that vertices of regular meshes, at
#: round numbers or on the axis, lie on no line.
_OFFSET = (1.381966, 1.414214)
#: Shorter pieces of a line count as rounding [distances of lines].
_NO_LENGTH = 0.05
#: Edges of faces that run over less of x may be met anywhere, and how far beyond a face's edges lines are looked at
#: [distances of lines]: what rounding makes of a crossing is a thousandth at most.
_STEEP, _BEYOND = 1e-6, 1e-3


@dataclass(frozen=True, eq=False)
class Columns:
    """Free space along vertical lines, bottom to top: interval 0 is the outside, below and around the solid.

    Parameters
    ----------
    pitch : float
        Distance between lines [m].
    origin : (2,) float64
        Place of the first line [m].
    shape : (int, int)
        Lines along x and y.
    column : (n,) int
        Line of each interval; -1 for the outside.
    bottom, top : (n,) float64
        Heights between which the line is free [m]; -inf and inf where there is no end.
    first : (lines,) float64
        Where each line first meets the solid from below [m]; inf where it never does.
    crossing_face, crossing_interval : (c,) int
        The faces that lines go through, and the free interval that begins or ends there; faces inside the solid are
        left out.
    crossing_height : (c,) float64
        Heights of these crossings [m].
    """

    pitch: float
    origin: np.ndarray
    shape: tuple[int, int]
    column: np.ndarray
    bottom: np.ndarray
    top: np.ndarray
    first: np.ndarray
    crossing_face: np.ndarray
    crossing_interval: np.ndarray
    crossing_height: np.ndarray


def pitch_for(vertices: np.ndarray, wall: float) -> float:
    """Return the distance of lines for a solid with a wall of a thickness [m]."""
    width, depth = np.ptp(vertices[:, :2], axis=0)
    wanted = min(PITCH_PER_WALL * wall, PITCH_PER_WIDTH * max(width, depth))
    return float(max(wanted, np.sqrt(width * depth / MOST_LINES)))


def columns_of(vertices: np.ndarray, faces: np.ndarray, pitch: float) -> Columns:
    """Return the free space of a solid along vertical lines.

    Parameters
    ----------
    vertices : (n, 3) float64
        Positions, each once [m].
    faces : (m, 3) int
        Closed, counter-clockwise seen from outside. Where solids overlap, what is in any of them is solid.
    pitch : float
        Distance between lines [m].
    """
    lines = _lines(vertices, faces, pitch)
    column, height, start = lines.column, lines.height, lines.start
    leaves, enters = (lines.after == 0) & lines.rising, (lines.before == 0) & ~lines.rising
    number = np.cumsum(leaves)  # intervals from 1; 0 is the outside
    first = np.full(lines.shape[0] * lines.shape[1], np.inf)
    first[column[start]] = height[start]
    in_first = number == np.where(start > 0, number[start - 1], 0)  # none left yet: the outside, below the solid
    bottom = np.concatenate([[-np.inf], height[leaves]])
    top = np.full(len(bottom), np.inf)
    ends = enters & ~in_first
    top[number[ends]] = height[ends]
    kept = leaves | enters
    return Columns(
        pitch=pitch,
        origin=lines.origin,
        shape=lines.shape,
        column=np.concatenate([[-1], column[leaves]]),
        bottom=bottom,
        top=top,
        first=first,
        crossing_face=lines.face[kept],
        crossing_interval=np.where(in_first, 0, number)[kept],
        crossing_height=height[kept],
    )


def solid_runs(vertices: np.ndarray, faces: np.ndarray, pitch: float) -> np.ndarray:
    """Return the lengths of the pieces of vertical lines that are in the solid, (k,) float64 [m]."""
    lines = _lines(vertices, faces, pitch)
    enters, leaves = (lines.before == 0) & ~lines.rising, (lines.after == 0) & lines.rising
    return lines.height[leaves] - lines.height[enters]


def crossed_twice(vertices: np.ndarray, faces: np.ndarray, pitch: float) -> np.ndarray | None:
    """Return a point that is in two solids at once or in a solid that is inside out, (3,) [m]; None where none is."""
    lines = _lines(vertices, faces, pitch)
    again = np.append(lines.column[:-1] == lines.column[1:], False)
    # Lines through an edge may count a piece of no length.
    long = np.append(np.diff(lines.height), 0.0) > _NO_LENGTH * pitch
    wrong = np.flatnonzero(again & long & ((lines.after < 0) | (lines.after > 1)))
    if not len(wrong):
        return None
    index = int(wrong[len(wrong) // 2])
    x, y = divmod(int(lines.column[index]), lines.shape[1])
    place = lines.origin + pitch * np.array([x, y])
    return np.array([*place, 0.5 * (lines.height[index] + lines.height[index + 1])])


@dataclass(frozen=True, eq=False)
class _Lines:
    """Crossings of vertical lines with faces, line by line, upwards."""

    origin: np.ndarray  #: (2,) where line 0 is [m]
    shape: tuple[int, int]
    column: np.ndarray
    face: np.ndarray
    height: np.ndarray  #: [m]
    rising: np.ndarray  #: whether the face looks up, and the line leaves the solid
    before: np.ndarray  #: in how many solids the line is below the crossing
    after: np.ndarray  #: and above it
    start: np.ndarray  #: the first crossing of the line


def _lines(vertices: np.ndarray, faces: np.ndarray, pitch: float) -> _Lines:
    low, high = vertices[:, :2].min(0), vertices[:, :2].max(0)
    origin = low - np.array(_OFFSET) * pitch
    nx, ny = (np.ceil((high - origin) / pitch).astype(int) + 2).tolist()
    column, face, height, rising = _crossings(vertices, faces, origin, pitch, ny)
    order = np.lexsort((height, column))
    column, face, height, rising = column[order], face[order], height[order], rising[order]
    steps = np.where(rising, -1, 1)
    total = np.cumsum(steps)
    begins = np.flatnonzero(np.diff(column, prepend=-1))
    start = np.repeat(begins, np.diff(np.append(begins, len(column))))
    after = total - np.where(start > 0, total[start - 1], 0)
    return _Lines(origin, (nx, ny), column, face, height, rising, after - steps, after, start)


def _crossings(
    vertices: np.ndarray, faces: np.ndarray, origin: np.ndarray, pitch: float, ny: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the line, the face, the height and whether the face looks up, of each crossing of a line and a face."""
    grid = (vertices[:, :2] - origin) / pitch
    corners = grid[faces]
    area = _cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    face, x, y = _candidates(corners, area != 0.0)
    sign = np.sign(area[face])
    sides = [_side(grid, faces[face, k], faces[face, (k + 1) % 3], x, y) for k in range(3)]
    # On an edge, the two faces that share it decide in the same way: one of them has the point.
    inside = np.logical_and.reduce([np.where(flip, -value, value) * sign > 0.0 for value, flip in map(_decided, sides)])
    face, x, y = face[inside], x[inside], y[inside]
    a, b, c = (grid[faces[face, k]] for k in range(3))
    point = np.stack([x, y], axis=1)
    weights = np.stack([_cross(b - point, c - point), _cross(c - point, a - point)], axis=1) / area[face][:, None]
    z = vertices[faces[face], 2]
    height = z[:, 2] + weights[:, 0] * (z[:, 0] - z[:, 2]) + weights[:, 1] * (z[:, 1] - z[:, 2])
    return x * ny + y, face, np.clip(height, z.min(1), z.max(1)), area[face] > 0.0


def _candidates(corners: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return lines (x, y) that may go through a face, with its number, for all faces (n, 3, 2) that are wanted.

    Along each row of lines that a face reaches, those between its edges, a little beyond them, and no others: of a long
    face that lies askew few of the lines in its box go through it.
    """
    low, high = np.ceil(corners.min(1)).astype(np.int64), np.floor(corners.max(1)).astype(np.int64)
    reached = wanted & (high >= low).all(1)
    face, x = _runs(np.where(reached, high[:, 0] - low[:, 0] + 1, 0), low[:, 0])
    lowest, highest = low[face, 1], high[face, 1]
    least, most = highest + 1.0, lowest - 1.0  # of a row that meets no edge: nothing
    for k in range(3):
        a, b = corners[face, k], corners[face, (k + 1) % 3]
        run = b[:, 0] - a[:, 0]
        steep = np.abs(run) < _STEEP  # such an edge may be met anywhere
        t = np.clip((x - a[:, 0]) / np.where(steep, 1.0, run), 0.0, 1.0)
        met = (np.minimum(a[:, 0], b[:, 0]) - _STEEP <= x) & (x <= np.maximum(a[:, 0], b[:, 0]) + _STEEP)
        at = a[:, 1] + t * (b[:, 1] - a[:, 1])
        least = np.where(met, np.minimum(least, np.where(steep, np.minimum(a[:, 1], b[:, 1]), at)), least)
        most = np.where(met, np.maximum(most, np.where(steep, np.maximum(a[:, 1], b[:, 1]), at)), most)
    first = np.maximum(np.ceil(least - _BEYOND).astype(np.int64), lowest)
    last = np.minimum(np.floor(most + _BEYOND).astype(np.int64), highest)
    row, y = _runs(np.maximum(last - first + 1, 0), first)
    return face[row], x[row], y


def _runs(counts: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the number of each run, as often as it is long, and the whole numbers of the run from its first on."""
    run = np.repeat(np.arange(len(counts)), counts)
    return run, first[run] + np.arange(len(run)) - np.repeat(np.cumsum(counts) - counts, counts)


def _side(
    grid: np.ndarray, start: np.ndarray, end: np.ndarray, x: np.ndarray, y: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return on which side of edges points lie, computed the same way for both faces of an edge; and the turned."""
    turned = start > end
    a, b = grid[np.where(turned, end, start)], grid[np.where(turned, start, end)]
    return (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0]), turned


def _decided(side: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    value, turned = side
    return np.where(value == 0.0, np.finfo(float).tiny, value), turned


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
