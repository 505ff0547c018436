"""Split the surface of a body where the surface of a liquid meets it: what is below, what is above, and the line.

Whether a point is below depends on its position alone, and each point of the line on the two ends of an edge alone. So
bodies and pieces that share an edge have the same points of the line, bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...core.mesh import Mesh

#: Heights of points (n, 3) over the surface of a liquid, (n,) [m].
Height = Callable[[np.ndarray], np.ndarray]
#: Halvings of an edge in search of the surface [1]: an edge of 10 mm ends in pieces of 1e-15 m.
_HALVINGS = 44
#: Distance within which points of the line are one [m]. On edges that leave a vertex just beside the surface they may
#: be 1e-8 m apart, a step of single precision: in the frames of a rod and of its vessel they would be one here and two
#: there.
_ONE_POINT = 2e-7


@dataclass(frozen=True, eq=False)
class Halves:
    """The two parts of a surface.

    Parameters
    ----------
    below, above : Mesh
        Its parts, with the line as part of their borders; None where there is none.
    rings : tuple of (k, 3) float32
        The closed lines between them, liquid on their left seen from above [m].
    """

    below: Mesh | None
    above: Mesh | None
    rings: tuple[np.ndarray, ...]


def split_at(mesh: Mesh, height: Height) -> Halves:
    """Return the parts of a body's surface below and above the surface of a liquid.

    Parameters
    ----------
    mesh : Mesh
        Normals out of the body. Where it is not closed, its borders lie on neither side of the line.
    height : callable
        Height over the liquid's surface.

    Raises
    ------
    ValueError
        Where the line is not closed.
    """
    low = height(mesh.vertices.astype(np.float64)) < 0.0
    below = low[mesh.faces]
    split = np.flatnonzero(below.any(1) & ~below.all(1))
    if not len(split):
        columns = (mesh.vertices, mesh.normals, mesh.uv)
        return Halves(
            _mesh(mesh, columns, mesh.faces[below.all(1)]), _mesh(mesh, columns, mesh.faces[~below.any(1)]), ()
        )
    alone_low = below[split].sum(1) == 1
    alone = np.where(alone_low, below[split].argmax(1), (~below[split]).argmax(1))
    p, q, r = np.take_along_axis(mesh.faces[split].astype(np.int64), (alone[:, None] + np.arange(3)) % 3, 1).T
    columns, number = _with_cuts(mesh, np.concatenate([p, p]), np.concatenate([q, r]), height, low)
    a, b = number[: len(p)], number[len(p) :]
    tip, rest = np.stack([p, a, b], 1), np.concatenate([np.stack([a, q, r], 1), np.stack([a, r, b], 1)])
    twice = np.concatenate([alone_low, alone_low])
    wet = np.concatenate([mesh.faces[below.all(1)], tip[alone_low], rest[~twice]])
    dry = np.concatenate([mesh.faces[~below.any(1)], tip[~alone_low], rest[twice]])
    # Normals point out of the body, so with the lower part's order the body is on the right and the liquid on the left.
    segments = np.where(alone_low[:, None], np.stack([a, b], 1), np.stack([b, a], 1))
    return Halves(_mesh(mesh, columns, wet), _mesh(mesh, columns, dry), _rings(columns[0], segments))


def volume_below(mesh: Mesh, height: Height) -> float:
    """Return the volume of a closed body below the surface of a liquid [m^3].

    By Gauss's theorem with the field (0, 0, z - f), f the surface's height, it is the integral of (z - f) dx dy over
    the body's own surface below the liquid's, on which z - f is taken as linear within each triangle.
    """
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    # Each vertex once: it is a corner of six triangles.
    d = np.sort(height(mesh.vertices.astype(np.float64))[mesh.faces], axis=1)
    one, other = corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2]
    area = 0.5 * (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    low, middle, high = d.T
    whole, tiny = d.sum(1), np.finfo(float).tiny
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        below = low**3 / np.maximum((middle - low) * (high - low), tiny)
        above = high**3 / np.maximum((high - low) * (high - middle), tiny)
    parts = np.select([high <= 0.0, low >= 0.0, middle >= 0.0], [whole, 0.0 * whole, below], whole - above)
    return float(area @ parts) / 3.0


def whole(pieces: Sequence[Mesh], name: str) -> Mesh:
    """Return one mesh of the pieces of a surface, with their normals and texture coordinates where all have them."""
    offsets = np.cumsum([0] + [len(piece.vertices) for piece in pieces[:-1]])
    faces = np.concatenate([piece.faces + offset for piece, offset in zip(pieces, offsets, strict=True)])
    columns = [[getattr(piece, field) for piece in pieces] for field in ("normals", "uv", "colours")]
    others = [None if any(x is None for x in column) else np.concatenate(column) for column in columns]
    return Mesh(name, np.concatenate([piece.vertices for piece in pieces]), faces, *others)


def without_folds(mesh: Mesh) -> Mesh:
    """Return a surface without faces that have two equal corners, and without pairs that lie on each other face down.

    Where a body was cut there are points a step of single precision apart. Some become one when it moves.
    """
    _, index = np.unique(np.ascontiguousarray(mesh.vertices + np.float32(0.0)).view("V12").ravel(), return_inverse=True)
    corners = index.reshape(-1)[mesh.faces].astype(np.int64)
    proper = (corners != np.roll(corners, 1, axis=1)).all(1)
    kinds, number = np.unique(np.sort(corners, axis=1), axis=0, return_inverse=True)
    # Of three numbers the order is even or odd, and turning a face over changes it.
    steps = np.sign(np.roll(corners, -1, axis=1) - corners).sum(1)
    turns = np.bincount(number.reshape(-1), np.where(proper, steps, 0), len(kinds))
    kept = proper & (turns[number.reshape(-1)] != 0.0)
    return mesh if kept.all() else replace(mesh, faces=mesh.faces[kept])


def _with_cuts(
    mesh: Mesh, one: np.ndarray, other: np.ndarray, height: Height, low: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray | None, np.ndarray | None], np.ndarray]:
    """Return positions, normals and texture coordinates with those of new points on edges, and the points' numbers."""
    foot, head = np.where(low[one], one, other), np.where(low[one], other, one)
    _keys, first, number = np.unique(foot * len(mesh.vertices) + head, return_index=True, return_inverse=True)
    foot, head = foot[first], head[first]
    start, end = (mesh.vertices[ends].astype(np.float64) for ends in (foot, head))
    along = _crossing(start, end, height)[:, None]
    points = start + along * (end - start)
    vertices = np.concatenate([mesh.vertices, points[_first_near(points)].astype(np.float32)])
    normals, uv = mesh.normals, mesh.uv
    if normals is not None:
        mixed = normals[foot] + along * (normals[head] - normals[foot])
        mixed /= np.maximum(np.linalg.norm(mixed, axis=1, keepdims=True), 1e-12)
        normals = np.concatenate([normals, mixed.astype(np.float32)])
    if uv is not None:
        uv = np.concatenate([uv, (uv[foot] + along * (uv[head] - uv[foot])).astype(np.float32)])
    return (vertices, normals, uv), len(mesh.vertices) + number.reshape(one.shape)


def _first_near(points: np.ndarray) -> np.ndarray:
    """Return for each point (n, 3) the first one that a chain of points, each near the next, leads to, (n,)."""
    first = np.arange(len(points))
    pairs = cKDTree(points).query_pairs(_ONE_POINT, output_type="ndarray")
    for one, other in sorted(map(tuple, pairs.tolist())):
        first[first == max(first[one], first[other])] = min(first[one], first[other])
    return first


def _crossing(start: np.ndarray, end: np.ndarray, height: Height) -> np.ndarray:
    """Return where edges reach the surface, as fractions of their lengths from the lower end."""
    least, most = np.zeros(len(start)), np.ones(len(start))
    for _ in range(_HALVINGS):
        middle = 0.5 * (least + most)
        under = height(start + middle[:, None] * (end - start)) < 0.0
        least, most = np.where(under, middle, least), np.where(under, most, middle)
    return 0.5 * (least + most)


def _rings(vertices: np.ndarray, segments: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the closed lines that segments make, as positions; points that rounding made equal are one."""
    places = vertices[segments]
    keys = np.ascontiguousarray(places + np.float32(0.0)).view("V12")[..., 0]
    apart = keys[:, 0] != keys[:, 1]
    keys, places = keys[apart], places[apart]
    _, first, index = np.unique(keys.ravel(), return_index=True, return_inverse=True)
    points = places.reshape(-1, 3)[first]
    pairs = index.reshape(-1, 2)
    after = dict(zip(pairs[:, 0].tolist(), pairs[:, 1].tolist(), strict=True))
    if len(after) != len(pairs) or after.keys() != set(after.values()):
        raise ValueError("expected closed lines where a liquid's surface meets a body, found open ones")
    rings = []
    while after:
        start, place = after.popitem()
        ring = [start]
        while place != start:
            ring.append(place)
            place = after.pop(place)
        if len(ring) >= 3:
            rings.append(points[ring])
    return tuple(rings)


def _mesh(
    mesh: Mesh, columns: tuple[np.ndarray, np.ndarray | None, np.ndarray | None], faces: np.ndarray
) -> Mesh | None:
    """Return the faces with three different corners and the vertices that they use; None where there are none."""
    corners = columns[0][faces]
    proper = np.all([(corners[:, k] != corners[:, (k + 1) % 3]).any(1) for k in range(3)], axis=0)
    if not proper.any():
        return None
    used, numbers = np.unique(faces[proper], return_inverse=True)
    normals, uv = (None if column is None else column[used] for column in columns[1:])
    return Mesh(mesh.name, columns[0][used], numbers.reshape(-1, 3), normals, uv)
