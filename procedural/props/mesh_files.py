"""Meshes from a user's folder: listing them, and reading one as the surface of a prop."""

from __future__ import annotations

import io
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.errors import InputError, cause_of
from ...core.folders import files_in
from ...core.mesh import Mesh
from .mesh_material import MeshMaterial, default_picture_folder, glb_material, obj_material
from .normals import creased

if TYPE_CHECKING:
    import trimesh

#: Formats that are read.
MESH_SUFFIXES = (".glb", ".obj", ".ply", ".stl")
#: A file whose longest side is in this range is taken to be in metres and keeps its size [m]: objects on tables. Any
#: other file has another unit or none, and gets a drawn size.
TRUE_SIZES = (0.02, 0.40)
#: Least ratio of the shortest to the longest side [1]. A prop thinner than a thousandth (0.1 mm at 10 cm) cannot be
#: distinguished from the table under it.
LEAST_THICKNESS = 1e-3
#: Fraction of corners whose stored normal may point into their face, as at slivers; above it all normals are computed.
STRAY_NORMALS = 0.01


@dataclass(frozen=True)
class MeshFile:
    """A mesh file in the user's folder.

    Parameters
    ----------
    path : Path
        The file.
    root : Path
        The user's folder; all files that the mesh file refers to must be inside.
    pictures : Path
        Folder to which pictures inside the file are written.
    """

    path: Path
    root: Path
    pictures: Path

    @property
    def name(self) -> str:
        """The path below the root, with forward slashes."""
        return self.path.relative_to(self.root).as_posix()


@dataclass(frozen=True)
class FileMesh:
    """A mesh from a file, and the file's material.

    Parameters
    ----------
    mesh : Mesh
        Centred on its bounding box, with normals; with `uv` if the file has them.
    material : MeshMaterial
        The material in the file.
    """

    mesh: Mesh
    material: MeshMaterial


def mesh_files(folder: Path, pictures: Path | None = None) -> tuple[MeshFile, ...]:
    """Return the meshes under a folder, ordered by their relative paths; InputError if there are none.

    Parameters
    ----------
    folder : Path
        Searched with its subfolders for `MESH_SUFFIXES`.
    pictures : Path, optional
        Folder for pictures inside GLB files; by default in the user's cache.
    """
    kept = pictures or default_picture_folder()
    return tuple(MeshFile(path, folder, kept) for path in files_in(folder, "meshes", MESH_SUFFIXES, below=True))


def read_mesh(file: MeshFile, name: str, longest: float) -> FileMesh:
    """Return a file's surface, all its parts as one.

    The surface may be open and may have several parts. The y axis of a GLB points up by its standard and is turned to
    z; other formats do not define it and keep their axes. Usable normals of the file are kept; otherwise they are
    computed, with creases at `normals.CREASE`.

    Parameters
    ----------
    file : MeshFile
        The file.
    name : str
        Name of the mesh.
    longest : float
        Longest side that a file without a plausible size of its own (`TRUE_SIZES`) is scaled to [m].

    Raises
    ------
    InputError
        If the file cannot be read, has no faces, has coordinates that are not finite, or is flat.
    """
    content = _content(file.path)
    vertices, faces, normals, uv = _surface(file, content)
    if file.path.suffix.lower() == ".glb":
        vertices, normals = _z_up(vertices), None if normals is None else _z_up(normals)
    vertices = _centred(file, vertices, faces, longest)
    # The precision of the mesh: welding and the search for slivers use these positions.
    vertices = vertices.astype(np.float32).astype(np.float64)
    faces = _proper(file, vertices, faces)
    if normals is None or not _agree(vertices, faces, normals):
        vertices, faces, normals, uv = creased(vertices, faces, uv)
    else:
        used, faces = np.unique(faces, return_inverse=True)
        faces = faces.reshape(-1, 3)
        vertices, normals, uv = vertices[used], normals[used], None if uv is None else uv[used]
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return FileMesh(Mesh(name, vertices, faces, normals, uv), _material(file, content))


def check_meshes(files: Iterable[MeshFile]) -> None:
    """Read every file once, to refuse a bad one before any scene is drawn; InputError names the file."""
    for file in files:
        read_mesh(file, "check", 1.0)


def box_mapped(mesh: Mesh) -> Mesh:
    """Return a mesh with box-mapped texture coordinates, by the dominant axis of each face, over its longest side."""
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(1)
    pairs, index = np.unique(np.stack([mesh.faces.reshape(-1), np.repeat(axis, 3)], 1), axis=0, return_inverse=True)
    vertices = mesh.vertices[pairs[:, 0]]
    # The two axes beside the dominant one, z as v on upright sides.
    first, second = np.array([1, 0, 0])[pairs[:, 1]], np.array([2, 2, 1])[pairs[:, 1]]
    rows = np.arange(len(pairs))
    uv = np.stack([vertices[rows, first], vertices[rows, second]], 1) / np.ptp(mesh.bounds, axis=0).max()
    normals = None if mesh.normals is None else mesh.normals[pairs[:, 0]]
    return Mesh(mesh.name, vertices, index.reshape(-1, 3), normals, uv)


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, "a readable mesh", cause_of(error)) from error


def _surface(file: MeshFile, content: bytes) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray | None]:
    """Return vertices, faces, normals if all parts have them, and texture coordinates if any part has them."""
    import trimesh

    parts = _parts(file, content)
    offsets = np.cumsum([0] + [len(part.vertices) for part, _ in parts[:-1]])
    vertices = np.concatenate([trimesh.transform_points(part.vertices, pose) for part, pose in parts])
    faces = np.concatenate([part.faces + offset for (part, _), offset in zip(parts, offsets, strict=True)])
    if not len(faces):
        raise InputError(file.path, "a mesh with faces", "none")
    if not np.isfinite(vertices).all():
        raise InputError(file.path, "finite vertices", "NaN or infinity")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(file.path, f"faces over {len(vertices)} vertices", f"indices {faces.min()} to {faces.max()}")
    stored = [_stored_normals(part, pose) for part, pose in parts]
    normals = [one for one in stored if one is not None]
    uv = [_stored_uv(part) for part, _ in parts]
    blank = [
        np.zeros((len(part.vertices), 2)) if one is None else one for (part, _), one in zip(parts, uv, strict=True)
    ]
    return (
        vertices,
        faces,
        np.concatenate(normals) if len(normals) == len(parts) else None,
        None if all(one is None for one in uv) else np.concatenate(blank),
    )


def _parts(file: MeshFile, content: bytes) -> list[tuple[trimesh.Trimesh, np.ndarray]]:
    """Return a file's parts that have faces, each with ``file_T_part``."""
    import trimesh

    kind = file.path.suffix.lower()[1:]
    # MTL is read by `mesh_material`, which checks the paths in it. (A GLB would lose its texture coordinates.)
    options: dict[str, Any] = {"skip_materials": True} if kind == "obj" else {}
    try:
        # From memory and without a resolver: no other file is opened here.
        scene = trimesh.load_scene(io.BytesIO(content), file_type=kind, process=False, **options)
        nodes = [scene.graph[node] for node in sorted(scene.graph.nodes_geometry)]
    except Exception as error:  # the readers raise exceptions of many types for malformed files
        raise InputError(file.path, f"a readable {kind.upper()} mesh", "one that cannot be read") from error
    parts = [(scene.geometry[name], pose) for pose, name in nodes]
    parts = [(part, pose) for part, pose in parts if isinstance(part, trimesh.Trimesh) and len(part.faces)]
    if not parts:
        raise InputError(file.path, "a mesh with faces", "none")
    return parts


def _stored_normals(part: trimesh.Trimesh, pose: np.ndarray) -> np.ndarray | None:
    """Return the normals in the file, turned by the pose, or None (trimesh would compute smooth ones)."""
    if "vertex_normals" not in part._cache.cache:
        return None
    # Normals transform by the inverse transpose, which differs from the pose under anisotropic scaling.
    return part.vertex_normals @ np.linalg.inv(pose[:3, :3])


def _stored_uv(part: trimesh.Trimesh) -> np.ndarray | None:
    uv = getattr(part.visual, "uv", None)
    usable = uv is not None and len(uv) == len(part.vertices) and np.isfinite(uv).all()
    return np.asarray(uv)[:, :2] if usable else None


def _z_up(vectors: np.ndarray) -> np.ndarray:
    return vectors[:, [0, 2, 1]] * [1.0, -1.0, 1.0]


def _centred(file: MeshFile, vertices: np.ndarray, faces: np.ndarray, longest: float) -> np.ndarray:
    """Return the vertices in metres about the centre of the surface's bounding box."""
    used = vertices[np.unique(faces)]
    low, high = used.min(0), used.max(0)
    with np.errstate(over="ignore"):
        extent = high - low
    if not np.isfinite(extent).all() or extent.min() <= LEAST_THICKNESS * extent.max():
        raise InputError(file.path, "a body with three extents", " x ".join(f"{side:g}" for side in extent))
    scale = 1.0 if TRUE_SIZES[0] <= extent.max() <= TRUE_SIZES[1] else longest / extent.max()
    return (vertices - (low + extent / 2)) * scale


def _proper(file: MeshFile, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the faces whose corners are three different positions."""
    corners = vertices[faces]
    same = np.any([np.all(corners[:, i] == corners[:, (i + 1) % 3], axis=1) for i in range(3)], axis=0)
    if same.all():
        raise InputError(file.path, "a mesh with faces", "only faces without area")
    return faces[~same]


def _agree(vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray) -> bool:
    """Return whether stored normals are usable vectors that point out of their faces."""
    if not np.isfinite(normals).all() or np.linalg.norm(normals, axis=1)[np.unique(faces)].min() < 0.5:
        return False
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.mean(np.einsum("fi,fci->fc", cross, normals[faces]) <= 0)) <= STRAY_NORMALS


def _material(file: MeshFile, content: bytes) -> MeshMaterial:
    match file.path.suffix.lower():
        case ".obj":
            return obj_material(file.path, file.root, content)
        case ".glb":
            return glb_material(file.path, file.root, content, file.pictures)
        case _:
            return MeshMaterial()
