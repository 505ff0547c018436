"""Cut the surface of a solid along the levels of liquids in it: what is wet, what is dry, and the liquids' surfaces.

Cut points lie on edges of the mesh. Each is computed once from the edge's ends, so that all three surfaces have it bit
for bit, and together they close glass and liquid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ...core.mesh import Mesh
from .columns import Columns
from .domes import Dome, domed
from .find import Hollow
from .polygon import triangulated

#: A level keeps this distance from the vertices, where there is room [m]; it is sought within `_REACH` of the wanted
#: level [m]. Single precision has steps of 7e-9 m at 0.1 m.
_CLEAR, _REACH = 2e-6, 4e-5


@dataclass(frozen=True, eq=False)
class Filling:
    """A liquid in a cavity.

    Parameters
    ----------
    hollow : Hollow
        The cavity.
    level : float
        Height of the line where its surface meets the wall [m], below the brim (`clear_level`).
    dome : Dome, optional
        Its surface, which ends at that height; flat without it.
    """

    hollow: Hollow
    level: float
    dome: Dome | None = None


@dataclass(frozen=True, eq=False)
class Parts:
    """The surface of a solid, cut along the levels of liquids.

    Parameters
    ----------
    outside : Mesh
        What is in air.
    wet_wall : Mesh
        What is in a liquid; normals out of the solid as well.
    liquid_surface : Mesh
        The surfaces of the liquids, normals up; their edges are those of the wet wall.
    """

    outside: Mesh
    wet_wall: Mesh
    liquid_surface: Mesh


def welded(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Return the distinct positions of a mesh, (n, 3) float64, and the number of each vertex's position."""
    keys = np.ascontiguousarray(mesh.vertices + np.float32(0.0)).view("V12").ravel()
    _, first, index = np.unique(keys, return_index=True, return_inverse=True)
    return mesh.vertices[first].astype(np.float64), index.reshape(-1)


def clear_level(heights: np.ndarray, level: float) -> float:
    """Return the level near a wanted one that is farthest from the vertices' heights [m], as single precision."""
    near = np.sort(heights[np.abs(heights - level) <= _REACH + _CLEAR])
    if not len(near) or np.abs(near - level).min() > _CLEAR:
        return float(np.float32(level))
    ends = np.concatenate([[level - _REACH], near[np.abs(near - level) <= _REACH], [level + _REACH]])
    widest = int(np.diff(ends).argmax())
    return float(np.float32(0.5 * (ends[widest] + ends[widest + 1])))


def cut(mesh: Mesh, columns: Columns, fillings: Sequence[Filling], names: tuple[str, str, str]) -> Parts:
    """Return a solid's surface cut along the levels of liquids.

    Parameters
    ----------
    mesh : Mesh
        The closed surface of the solid, each edge between two faces.
    columns : Columns
        Its free space, of the welded mesh.
    fillings : sequence of Filling
        Of its cavities.
    names : (str, str, str)
        Of the three meshes.

    Raises
    ------
    ValueError
        Where a level does not lie in its cavity, or is not a closed line on its wall.
    """
    places, index = welded(mesh)
    links = links_of(index[mesh.faces])
    number = np.full(len(mesh.faces), -1)  # of the liquid that a face touches
    for k, filling in enumerate(fillings):
        touched = _touched(links, places[:, 2] < filling.level, columns, filling.hollow, filling.level)
        if not touched.any():
            raise ValueError("expected a wall below the level, found none")
        number[touched] = k
    return _cut_faces(mesh, links, number, [(filling.level, filling.dome) for filling in fillings], names)


def cut_known(mesh: Mesh, inner: np.ndarray, height: float, names: tuple[str, str, str]) -> Parts:
    """Return a solid's surface cut along the level of the liquid in a cavity of which the faces are known.

    Parameters
    ----------
    mesh : Mesh
        The closed surface of the solid, each edge between two faces.
    inner : (m,) bool
        The faces around the cavity: below its brim, no other face shares an edge with them.
    height : float
        The level [m], below the brim (`clear_level`).
    names : (str, str, str)
        Of the three meshes.

    Raises
    ------
    ValueError
        Where the level is not a closed line on the wall.
    """
    _, index = welded(mesh)
    number = np.where(inner & (mesh.vertices[mesh.faces, 2].min(1) < height), 0, -1)
    return _cut_faces(mesh, links_of(index[mesh.faces]), number, [(height, None)], names)


def _cut_faces(
    mesh: Mesh,
    links: Links,
    number: np.ndarray,
    tops: Sequence[tuple[float, Dome | None]],
    names: tuple[str, str, str],
) -> Parts:
    """Return a surface cut along the level of the liquid that each face touches, whose number it has; -1 is none.

    Each liquid has its level [m], and a dome where its surface is not flat.
    """
    level = np.append([height for height, _ in tops], np.nan)[number]
    below = mesh.vertices[mesh.faces, 2] < level[:, None]
    split = np.flatnonzero(below.any(1) & ~below.all(1))
    vertices, normals, pieces = _split(mesh, links, below[split], split, level[split])
    wet = np.concatenate([mesh.faces[below.all(1)], *pieces.low])
    dry = np.concatenate([mesh.faces[~below.any(1)], *pieces.high])
    owner = dict(zip(pieces.segments[:, 0].tolist(), number[split].tolist(), strict=True))
    rings = _rings(pieces.segments, pieces.vertex_of_edge, owner, len(tops))
    return Parts(
        _mesh(names[0], vertices, dry, normals),
        _mesh(names[1], vertices, wet, normals),
        _mesh(names[2], *_surfaces(vertices, rings, [dome for _, dome in tops])),
    )


def _surfaces(
    vertices: np.ndarray, rings: Sequence[Sequence[np.ndarray]], domes: Sequence[Dome | None]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the vertices, faces and normals of the liquids' surfaces; the vertices begin with the given ones."""
    normals = np.zeros_like(vertices)
    normals[:, 2] = 1.0
    faces = [np.zeros((0, 3), np.int64)]
    for lines, dome in zip(rings, domes, strict=True):
        some = _distinct(vertices, lines)
        if dome is None:
            faces.append(triangulated(vertices[:, :2].astype(np.float64), some))
            continue
        if len(some) != 1:
            raise ValueError(f"expected one closed line where the level meets the wall, found {len(some)}")
        vertices, normals, made = domed(vertices, normals, some[0], dome)
        faces.append(made)
    return vertices, np.concatenate(faces), normals


def touched_faces(
    faces: np.ndarray, heights: np.ndarray, columns: Columns, hollow: Hollow, height: float
) -> np.ndarray:
    """Return which faces of a welded mesh, (m,) bool, a liquid in a cavity would touch up to a height [m]."""
    return _touched(links_of(faces), heights < height, columns, hollow, height)


@dataclass(frozen=True, eq=False)
class Links:
    """The edges of a closed mesh."""

    edge: np.ndarray  #: (m, 3) number of the edge that begins at each corner
    ends: np.ndarray  #: (e, 2) its positions, the smaller number first
    sides: np.ndarray  #: (e, 2) its faces


@dataclass(frozen=True, eq=False)
class _Pieces:
    """What becomes of faces that a level crosses."""

    low: tuple[np.ndarray, ...]
    high: tuple[np.ndarray, ...]
    segments: np.ndarray  #: (k, 2) numbers of the edges that a level crosses, in the order of the lower pieces
    vertex_of_edge: dict[int, int]


def links_of(faces: np.ndarray) -> Links:
    """Return the edges of closed faces, (m, 3); ValueError where an edge has not two of them."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1).astype(np.int64)
    keys = ends[:, 0] * (int(faces.max()) + 1) + ends[:, 1]
    _, first, edge = np.unique(keys, return_index=True, return_inverse=True)
    edge = edge.reshape(-1)
    order = np.argsort(edge, kind="stable")
    if len(order) != 2 * len(first) or (np.diff(edge[order].reshape(-1, 2), axis=1) != 0).any():
        raise ValueError("expected two faces at every edge, found other counts")
    return Links(edge.reshape(-1, 3), ends[first], order.reshape(-1, 2) // 3)


def _touched(links: Links, low: np.ndarray, columns: Columns, hollow: Hollow, height: float) -> np.ndarray:
    """Return the faces that the liquid in a cavity touches, by connected pieces of the surface below its level."""
    a, b = links.sides[low[links.ends].any(1)].T
    count = len(links.edge)
    _, piece = connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(count, count)), directed=False)
    some = np.zeros(count, dtype=bool)
    some[a] = some[b] = True
    # The free space beside a piece is connected below the level, so all lines through it tell the same, but for
    # rounding at edges.
    under = columns.crossing_height < height
    inside = np.isin(columns.crossing_interval[under], hollow.intervals)
    votes = np.bincount(piece[columns.crossing_face[under]], np.where(inside, 1.0, -1.0), piece.max() + 1)
    return some & (votes[piece] > 0)


def _split(
    mesh: Mesh, links: Links, below: np.ndarray, split: np.ndarray, level: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None, _Pieces]:
    """Return all vertices, with those on the edges of the faces that a level crosses, and the pieces of these faces."""
    alone_low = below.sum(1) == 1
    alone = np.where(alone_low, below.argmax(1), (~below).argmax(1))
    turn = (alone[:, None] + np.arange(3)) % 3
    p, q, r = np.take_along_axis(mesh.faces[split].astype(np.int64), turn, 1).T
    edges = np.take_along_axis(links.edge[split], turn, 1)[:, [0, 2]]  # from p, and to p
    vertices, normals, number = _cut_points(mesh, np.stack([p, p]), np.stack([q, r]), np.stack([level, level]))
    a, b = number
    tip = np.stack([p, a, b], 1)
    rest = np.concatenate([np.stack([a, q, r], 1), np.stack([a, r, b], 1)])
    twice = np.concatenate([alone_low, alone_low])
    segments = np.where(alone_low[:, None], edges, edges[:, ::-1])
    vertex_of_edge = dict(zip(edges.T.ravel().tolist(), number.ravel().tolist(), strict=True))
    low, high = (tip[alone_low], rest[~twice]), (tip[~alone_low], rest[twice])
    return vertices, normals, _Pieces(low, high, segments, vertex_of_edge)


def _cut_points(
    mesh: Mesh, start: np.ndarray, end: np.ndarray, level: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
    """Return all vertices with new ones where edges reach their level, and the numbers of these."""
    swap = start > end
    keys = np.where(swap, end, start) * len(mesh.vertices) + np.where(swap, start, end)
    unique, first, number = np.unique(keys, return_index=True, return_inverse=True)
    heights = level.ravel()[first].astype(np.float64)
    one, other = np.divmod(unique, len(mesh.vertices))
    # From the lower end up, so that an edge between two pairs of vertices has one and the same point.
    flip = mesh.vertices[one, 2] > mesh.vertices[other, 2]
    one, other = np.where(flip, other, one), np.where(flip, one, other)
    foot, head = (mesh.vertices[ends].astype(np.float64) for ends in (one, other))
    along = ((heights - foot[:, 2]) / (head[:, 2] - foot[:, 2]))[:, None]
    points = foot + along * (head - foot)
    points[:, 2] = heights
    vertices = np.concatenate([mesh.vertices, points.astype(np.float32)])
    normals = mesh.normals
    if normals is not None:
        mixed = normals[one] + along * (normals[other] - normals[one])
        mixed /= np.maximum(np.linalg.norm(mixed, axis=1, keepdims=True), 1e-12)
        normals = np.concatenate([normals, mixed.astype(np.float32)])
    return vertices, normals, len(mesh.vertices) + number.reshape(start.shape)


def _rings(
    segments: np.ndarray, vertex_of_edge: dict[int, int], owner: dict[int, int], owners: int
) -> list[list[np.ndarray]]:
    """Return the closed lines that segments make, as vertices, for each of the owners of their first edges."""
    after = dict(segments.tolist())
    if len(after) != len(segments) or after.keys() != set(after.values()):
        raise ValueError("expected closed lines where the level meets the wall, found open ones")
    rings: list[list[np.ndarray]] = [[] for _ in range(owners)]
    while after:
        start, place = after.popitem()
        ring = [start]
        while place != start:
            ring.append(place)
            place = after.pop(place)
        rings[owner[start]].append(np.array([vertex_of_edge[edge] for edge in ring]))
    return rings


def _distinct(vertices: np.ndarray, rings: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return rings without points that rounding made equal, and without those of no size."""
    kept = [ring[(vertices[ring] != vertices[np.roll(ring, 1)]).any(1)] for ring in rings]
    return [ring for ring in kept if len(ring) >= 3]


def _mesh(name: str, vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray | None) -> Mesh:
    """Return the faces with three different corners, and the vertices that they use."""
    corners = vertices[faces]
    proper = np.all([(corners[:, k] != corners[:, (k + 1) % 3]).any(1) for k in range(3)], axis=0)
    used, numbers = np.unique(faces[proper], return_inverse=True)
    return Mesh(name, vertices[used], numbers.reshape(-1, 3), None if normals is None else normals[used])
