"""Make a closed solid of the triangles in a file, where that is safe; say what is wrong and where, where it is not.

Safe repairs: welding of points that are nearly equal, edges that others end on, faces without area and faces that are
there twice, faces that look the wrong way, small holes, and bodies that overlap or share a face, which become one.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ...core.errors import InputError
from ..cavities.columns import PITCH_PER_WIDTH, crossed_twice
from .bodies import bodies_of, oriented, parted, united
from .sheets import holes_filled, split_at_junctions, thickened

#: Points nearer than this fraction of the longest side are one where a surface is open without it [1]: what text files
#: with six digits round away.
_WELD = 1e-5


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles between distinct points, positions [m] exact in single precision."""

    vertices: np.ndarray
    faces: np.ndarray


def closed_solid(path: Path, vertices: np.ndarray, faces: np.ndarray, shell: float | None) -> Surface:
    """Return a closed solid, faces outwards, of which no part overlaps another.

    Parameters
    ----------
    path : Path
        The file, for the error line.
    vertices, faces : (n, 3) float64, (m, 3) int
        Triangles [m].
    shell : float, optional
        Thickness that open bodies get, inwards, where filling holes in their sides does not close them [m].

    Raises
    ------
    InputError
        With the reason and the place.
    """
    surface = _joined(path, vertices, faces)
    touching = bool((_edge_counts(surface.faces)[2] > 2).any())
    if touching:
        surface = Surface(*parted(surface.vertices, surface.faces))
        _check_edges(path, surface)
    surface = Surface(surface.vertices, _same_way(path, surface))
    if shell is None:
        return _apart(path, _filled(path, surface), touching)
    try:
        return _apart(path, _with_shell(path, surface, shell), touching)
    except InputError:
        # What is usable without a thickness stays usable with it.
        filled = holes_filled(surface.vertices, surface.faces)
        if len(_edges_with(filled, 1)) or not len(_edges_with(surface.faces, 1)):
            raise
        return _apart(path, Surface(surface.vertices, filled), touching)


def _joined(path: Path, vertices: np.ndarray, faces: np.ndarray) -> Surface:
    """Return the triangles with points and edges in common where they meet, as far as that closes the surface."""
    surface = _clean(vertices, faces)
    if not len(surface.faces):
        raise InputError(path, "a mesh with faces", "only faces without area")
    if not len(_edges_with(surface.faces, 2, other=True)):
        return surface
    # Between bodies that share a face, that face is there twice and looks both ways.
    without = _clean(vertices, faces, walls_between=False)
    if len(without.faces) and not len(_edges_with(without.faces, 2, other=True)):
        return without
    reach = _WELD * float(np.ptp(surface.vertices, axis=0).max())
    for repaired in (_welded, _split_at_junctions):
        if len(loose := _edges_with(surface.faces, 1)):
            closer = repaired(surface, reach)
            surface = closer if len(_edges_with(closer.faces, 1)) < len(loose) else surface
    return surface


def _split_at_junctions(surface: Surface, reach: float) -> Surface:
    return _proper(surface.vertices, split_at_junctions(surface.vertices, surface.faces, reach))


def _filled(path: Path, surface: Surface) -> Surface:
    """Return a surface without its small holes; InputError where it is open all the same."""
    faces = holes_filled(surface.vertices, surface.faces)
    loose = _edges_with(faces, 1)
    if len(loose):
        raise InputError(path, "a closed surface, or a thickness for it (--vessels.shell 2mm)", _open(surface, loose))
    return Surface(surface.vertices, faces)


def _with_shell(path: Path, surface: Surface, shell: float) -> Surface:
    """Return a surface whose open bodies have a thickness, after holes in their sides are filled; others stay."""
    vertices, faces = surface.vertices, surface.faces
    if len(_edges_with(faces, 1)):
        faces = holes_filled(vertices, faces, in_sides=True)
    if not len(_edges_with(faces, 1)):
        return Surface(vertices, faces)
    _, edge, count = _edge_counts(faces)
    body = bodies_of(faces)
    is_open = np.isin(body, body[(count[edge] == 1).reshape(-1, 3).any(1)])
    solid, sheets = _used(vertices, faces[~is_open]), _used(vertices, faces[is_open])
    walls = _clean(*thickened(path, sheets.vertices, sheets.faces, shell))
    start = len(solid.vertices)
    return Surface(np.concatenate([solid.vertices, walls.vertices]), np.concatenate([solid.faces, walls.faces + start]))


def _apart(path: Path, surface: Surface, touching: bool) -> Surface:
    """Return a solid whose bodies are united where they overlap or touch; InputError where one crosses itself."""
    surface = Surface(surface.vertices, oriented(surface.vertices, surface.faces))
    place, crosses = doubled_at(surface), True
    if place is None:
        if not touching:
            return surface
        points, times = np.unique(surface.vertices, axis=0, return_counts=True)
        place, crosses = points[times > 1].mean(0), False
    joined = united(surface.vertices, surface.faces)
    if joined is not None:
        surface = _clean(*joined)
        if not len(_edges_with(surface.faces, 2, other=True)) and doubled_at(surface) is None:
            return surface
    if crosses:
        raise InputError(path, "a surface that does not cross itself", f"one that does, {_at(place)}")
    raise InputError(path, "bodies that overlap, or are apart", f"some that touch along an edge, {_at(place)}")


def doubled_at(surface: Surface) -> np.ndarray | None:
    """Return a point that the solid holds twice, or that is inside out; found along z and along x."""
    for axes in ([0, 1, 2], [1, 2, 0]):
        turned = surface.vertices[:, axes]
        pitch = PITCH_PER_WIDTH * float(np.ptp(turned[:, :2], axis=0).max())
        place = crossed_twice(turned, surface.faces, pitch)
        if place is not None:
            return place[np.argsort(axes)]
    return None


def _clean(vertices: np.ndarray, faces: np.ndarray, walls_between: bool = True) -> Surface:
    """Return distinct points in single precision, and the faces with an area of their own, each once.

    Without `walls_between`, faces that are there in both directions are left out.
    """
    single = np.ascontiguousarray(vertices.astype(np.float32) + np.float32(0.0))
    _, first, index = np.unique(single.view("V12").ravel(), return_index=True, return_inverse=True)
    return _proper(single[first].astype(np.float64), index.reshape(-1)[faces].astype(np.int64), walls_between)


def _proper(vertices: np.ndarray, faces: np.ndarray, walls_between: bool = True) -> Surface:
    faces = faces[np.all([faces[:, k] != faces[:, (k + 1) % 3] for k in range(3)], axis=0)]
    _, first, group = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_inverse=True)
    if not walls_between:
        # A face is even where its corners rise in their order around it.
        even = (np.diff(faces, axis=1, append=faces[:, :1]) > 0).sum(1) == 2
        fraction = np.bincount(group.reshape(-1), even) / np.bincount(group.reshape(-1))
        first = first[(fraction == 0.0) | (fraction == 1.0)]
    return _used(vertices, faces[np.sort(first)])


def _used(vertices: np.ndarray, faces: np.ndarray) -> Surface:
    used, index = np.unique(faces, return_inverse=True)
    return Surface(vertices[used], index.reshape(-1, 3))


def _welded(surface: Surface, reach: float) -> Surface:
    pairs = cKDTree(surface.vertices).query_pairs(reach, output_type="ndarray")
    count = len(surface.vertices)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    _, first = np.unique(label, return_index=True)
    return _proper(surface.vertices[first], label[surface.faces].astype(np.int64))


def _edge_counts(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the edges (e, 2), the edge that begins at each corner (3m,), and the number of faces at each."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    keys, edge, count = np.unique(
        ends[:, 0] * (int(faces.max()) + 1) + ends[:, 1], return_inverse=True, return_counts=True
    )
    return np.stack(np.divmod(keys, int(faces.max()) + 1), axis=1), edge.reshape(-1), count


def _edges_with(faces: np.ndarray, number: int, other: bool = False) -> np.ndarray:
    """Return the edges with a number of faces, or with any other, (e, 2)."""
    ends, _, count = _edge_counts(faces)
    return ends[(count == number) != other]


def _check_edges(path: Path, surface: Surface) -> None:
    ends, _, count = _edge_counts(surface.faces)
    shared = count > 2
    if shared.any():
        middle = surface.vertices[ends[shared][0]].mean(0)
        found = f"{int(shared.sum())} edges that {int(count[shared][0])} or more share, the first {_at(middle)}"
        raise InputError(path, "each edge between two triangles", found)


def _same_way(path: Path, surface: Surface) -> np.ndarray:
    """Return the faces, turned so that neighbours look to the same side."""
    faces = surface.faces
    _, edge, count = _edge_counts(faces)
    order = np.argsort(edge, kind="stable")
    order = order[np.repeat(count, count) == 2].reshape(-1, 2)
    origin = faces.reshape(-1)[order]
    turned = origin[:, 0] == origin[:, 1]  # both go along the edge in the same direction
    if not turned.any():
        return faces
    a, b = (order // 3).T
    total = len(faces)
    # Each face twice, as it is and turned: what is connected looks to the same side.
    first = np.concatenate([a, a + total])
    second = np.concatenate([np.where(turned, b + total, b), np.where(turned, b, b + total)])
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(2 * total, 2 * total))
    _, label = connected_components(graph, directed=False)
    as_is, over = label[:total], label[total:]
    if (as_is == over).any():
        middle = surface.vertices[faces[as_is == over][0]].mean(0)
        raise InputError(path, "a surface with two sides", f"one with a single side, {_at(middle)}")
    flip = as_is > over
    return np.where(flip[:, None], faces[:, ::-1], faces)


def _open(surface: Surface, loose: np.ndarray) -> str:
    points = surface.vertices[loose]
    length, first = np.linalg.norm(points[:, 0] - points[:, 1], axis=1).sum(), points[0].mean(0)
    return f"an open one: {len(loose)} loose edges, {1e3 * length:.3g} mm long together, the first {_at(first)}"


def _at(place: np.ndarray) -> str:
    return f"at ({', '.join(f'{1e3 * x:.1f}' for x in place)}) mm"
