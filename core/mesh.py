"""Triangle meshes as frozen data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .errors import InputError

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh in the frame of its object.

    Vertices are duplicated at a crease or a seam (two normals, two texture coordinates), with bit-identical positions.
    Counter-clockwise faces look along the outward normal.

    Parameters
    ----------
    name : str
        File stem of the mesh inside a scene's folder, unique in the scene: letters, digits, ``-`` and ``_``.
    vertices : (n, 3) float32
        Positions [m].
    faces : (m, 3) int32
        Indices into ``vertices``.
    normals : (n, 3) float32, optional
        Unit shading normals; None means flat shading.
    uv : (n, 2) float32, optional
        Texture coordinates.
    colours : (n, 3) float32, optional
        Reflectances, linear Rec.709.
    """

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray | None = None
    uv: np.ndarray | None = None
    colours: np.ndarray | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _frozen(self.vertices, np.float32, 3, f"vertices of mesh {self.name}"))
        object.__setattr__(self, "faces", _frozen(self.faces, np.int32, 3, f"faces of mesh {self.name}"))
        for field, width in (("normals", 3), ("uv", 2), ("colours", 3)):
            value = getattr(self, field)
            if value is not None:
                value = _frozen(value, np.float32, width, f"{field} of mesh {self.name}")
                if len(value) != len(self.vertices):
                    raise ValueError(
                        f"{field} of mesh {self.name}: expected {len(self.vertices)} rows, got {len(value)}"
                    )
                object.__setattr__(self, field, value)

    def __repr__(self) -> str:
        """Return name and counts, never the arrays."""
        return f"Mesh({self.name!r}: {len(self.vertices)} vertices, {len(self.faces)} faces)"

    @property
    def bounds(self) -> np.ndarray:
        """Smallest and largest coordinates, (2, 3) float64 [m]."""
        return np.stack([self.vertices.min(0), self.vertices.max(0)]).astype(np.float64)


def some_faces(mesh: Mesh, faces: slice, name: str) -> Mesh:
    """Return the mesh of some faces, in their order, with the vertices that they use."""
    used, index = np.unique(mesh.faces[faces], return_inverse=True)
    normals, uv, colours = (None if x is None else x[used] for x in (mesh.normals, mesh.uv, mesh.colours))
    return Mesh(name, mesh.vertices[used], index.reshape(-1, 3), normals, uv, colours)


def on_border(mesh: Mesh) -> np.ndarray:
    """Return which vertices lie on an edge of one triangle, (n,) bool; vertices at one position count as one."""
    _, index = np.unique(mesh.vertices, axis=0, return_inverse=True)
    index = index.reshape(-1)
    corners = index[mesh.faces]
    edges = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    ends, count = np.unique(edges, axis=0, return_counts=True)
    return np.isin(index, ends[count == 1])


def check_closed(where: str, mesh: Mesh) -> None:
    """Refuse a mesh that does not enclose a volume.

    Raises
    ------
    InputError
        An edge that is not passed once in each direction, or faces that look inwards.
    """
    # As bytes: rows of plain memory sort much faster than rows of numbers. Adding 0 makes -0 the same as 0.
    _, index = np.unique(np.ascontiguousarray(mesh.vertices + np.float32(0.0)).view("V12").ravel(), return_inverse=True)
    faces = index.reshape(-1)[mesh.faces].astype(np.int64)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    count = int(index.max()) + 1
    forth, back = np.sort(start * count + end), np.sort(end * count + start)
    if (forth[1:] == forth[:-1]).any() or not np.array_equal(forth, back):
        found = _edge_faults(mesh, start, end, index)
        raise InputError(where, "a closed surface, each edge between two triangles", found)
    volume = volume_of(mesh)
    if volume <= 0.0:
        raise InputError(where, "normals that point out of the body", f"a volume of {volume:.3e} m^3")


def _edge_faults(mesh: Mesh, start: np.ndarray, end: np.ndarray, index: np.ndarray) -> str:
    """Return what is wrong with the edges of a surface, and where the first fault is.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    start, end : (3 m,) int64
        Ends of the faces' edges, as numbers of positions.
    index : (n,) int64
        Number of each vertex's position.
    """
    pairs = np.stack([np.minimum(start, end), np.maximum(start, end)], axis=1)
    edges, which, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    forth = np.bincount(which.reshape(-1), start < end, len(edges))
    faults = {
        "with one triangle (holes)": count == 1,
        "that more than two triangles share": count > 2,
        "between triangles of opposite turn": (count == 2) & (forth != 1),
    }
    faults = {what: where for what, where in faults.items() if where.any()}
    if not faults:  # triangles with two corners at one place
        return "triangles without area"
    text = ", ".join(f"{int(where.sum())} edges {what}" for what, where in faults.items())
    first = edges[np.flatnonzero(next(iter(faults.values())))[0]]
    middle = mesh.vertices[[np.flatnonzero(index.reshape(-1) == one)[0] for one in first]].mean(axis=0)
    return f"{text}, the first at ({', '.join(f'{x:.4g}' for x in middle)}) m"


def volume_of(mesh: Mesh) -> float:
    """Return the volume of a closed mesh [m^3]: the sum of its triangles' tetrahedra with the origin."""
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6.0


def joined(meshes: tuple[Mesh, ...] | list[Mesh], name: str) -> Mesh:
    """Return one mesh with the faces of all, positions and faces only."""
    offsets = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    faces = np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=True)])
    return Mesh(name, vertices, faces)


def turned(mesh: Mesh, name: str | None = None) -> Mesh:
    """Return the mesh with its faces and normals reversed."""
    normals = None if mesh.normals is None else -mesh.normals
    return Mesh(name or mesh.name, mesh.vertices, mesh.faces[:, ::-1], normals, mesh.uv, mesh.colours)


def as_trimesh(mesh: Mesh, transform: np.ndarray | None = None) -> trimesh.Trimesh:
    """Return a `trimesh.Trimesh` of the positions, with duplicate vertices merged.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    transform : (4, 4) float, optional
        ``a_T_b`` applied to the positions, e.g. ``world_T_object``.
    """
    import trimesh  # here, as it takes half a second, and every module of settings imports this one

    welded, index = np.unique(mesh.vertices, axis=0, return_inverse=True)
    solid = trimesh.Trimesh(welded.astype(np.float64), index.reshape(-1)[mesh.faces], process=False)
    return solid if transform is None else solid.apply_transform(transform)


def _frozen(values: np.ndarray, dtype: type, width: int, what: str) -> np.ndarray:
    array = np.array(values, dtype=dtype, order="C")
    if array.ndim != 2 or array.shape[1] != width:
        raise ValueError(f"{what}: expected shape (n, {width}), got {array.shape}")
    array.setflags(write=False)
    return array
