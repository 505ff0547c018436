"""Read a file as triangles, all its bodies together, in metres with z up, and the glass that it says."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...core.errors import InputError, cause_of
from ..optics.medium import Medium
from ..vessels.settings import Unit, UpAxis
from .gltf_glass import gltf_glass

#: Longest side of a vessel [m]: from a vial to a demijohn. Other sizes are mistakes of the unit.
SIZES = (0.01, 0.7)
#: Metres in each unit.
UNITS: dict[Unit, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
#: Most triangles of a file [1]: ten times what is understood in seconds.
MOST_FACES = 2_000_000
#: Largest file [bytes]: `MOST_FACES` as text have about 100 bytes each.
MOST_BYTES = 400_000_000
#: Turns of coordinates that bring an axis up: places of x, y and z, and their signs. All are rotations.
UP: dict[UpAxis, tuple[list[int], list[float]]] = {
    "z": ([0, 1, 2], [1.0, 1.0, 1.0]),
    "-z": ([0, 1, 2], [1.0, -1.0, -1.0]),
    "y": ([0, 2, 1], [1.0, -1.0, 1.0]),
    "-y": ([0, 2, 1], [1.0, 1.0, -1.0]),
    "x": ([2, 1, 0], [-1.0, 1.0, 1.0]),
    "-x": ([2, 1, 0], [1.0, 1.0, -1.0]),
}


@dataclass(frozen=True, eq=False)
class Triangles:
    """What a file holds.

    Parameters
    ----------
    vertices : (n, 3) float64
        Positions in the file's unit, its own axes.
    faces : (m, 3) int64
        Triangles; none in a file of points alone.
    glass : Medium or None
        What a glTF material with transmission says.
    """

    vertices: np.ndarray
    faces: np.ndarray
    glass: Medium | None


def read_triangles(path: Path) -> Triangles:
    """Return the triangles of a file; InputError where it cannot be read, is too large, or is not finite."""
    try:
        size = path.stat().st_size
        content = path.read_bytes() if size <= MOST_BYTES else b""
    except OSError as error:
        raise InputError(path, "a readable mesh", cause_of(error)) from error
    if size > MOST_BYTES:
        raise InputError(path, f"at most {MOST_BYTES / 1e6:.0f} MB", f"{size / 1e6:.0f} MB")
    kind = path.suffix.lower()[1:]
    options: dict[str, Any] = {"skip_materials": True} if kind == "obj" else {}
    try:
        import trimesh

        # From memory and without a resolver: no other file is opened here.
        scene = trimesh.load_scene(io.BytesIO(content), file_type=kind, process=False, **options)
        nodes = [(scene.graph[node]) for node in sorted(scene.graph.nodes_geometry)]
        parts = [_placed(scene.geometry[name], pose) for pose, name in nodes]
    except Exception as error:  # the readers raise exceptions of many types for malformed files
        raise InputError(path, f"a readable {kind.upper()} mesh", "one that cannot be read") from error
    solid = [part for part in parts if len(part[1])]
    if not solid:
        points = _points(content) if kind == "obj" else np.concatenate([np.zeros((0, 3)), *(some for some, _ in parts)])
        _check_points(path, points)
        return Triangles(points, np.zeros((0, 3), np.int64), None)
    offsets = np.cumsum([0] + [len(points) for points, _ in solid[:-1]])
    vertices = np.concatenate([points for points, _ in solid])
    faces = np.concatenate([some + offset for (_, some), offset in zip(solid, offsets, strict=True)]).astype(np.int64)
    _check(path, vertices, faces)
    return Triangles(vertices, faces, gltf_glass(path, content) if kind == "glb" else None)


def _points(content: bytes) -> np.ndarray:
    """Return the points of an OBJ file, (n, 3); none where a line is no point."""
    lines = [line.split()[1:4] for line in content.splitlines() if line.startswith(b"v ")]
    try:
        return np.array(lines, dtype=np.float64).reshape(-1, 3)
    except ValueError:
        return np.zeros((0, 3))


def _check_points(path: Path, points: np.ndarray) -> None:
    if not len(points):
        raise InputError(path, "a mesh with faces, or points on a surface", "neither")
    if not np.isfinite(points).all():
        raise InputError(path, "finite points", "NaN or infinity")


def _placed(part: object, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the points and faces of a body in the file's frame."""
    import trimesh

    points = np.asarray(getattr(part, "vertices", np.zeros((0, 3))), np.float64).reshape(-1, 3)
    faces = np.asarray(part.faces) if isinstance(part, trimesh.Trimesh) else np.zeros((0, 3), np.int64)
    mirrored = np.linalg.det(pose[:3, :3]) < 0.0
    return trimesh.transform_points(points, pose), faces[:, ::-1] if mirrored else faces


def _check(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    if len(faces) > MOST_FACES:
        raise InputError(path, f"at most {MOST_FACES:,} triangles", f"{len(faces):,}")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(path, f"faces over {len(vertices)} vertices", f"indices {faces.min()} to {faces.max()}")
    if not np.isfinite(vertices[faces]).all():
        raise InputError(path, "finite vertices", "NaN or infinity")


def in_metres(path: Path, vertices: np.ndarray, unit: Unit | None) -> np.ndarray:
    """Return vertices in metres.

    Parameters
    ----------
    path : Path
        The file, for the error line.
    vertices : (n, 3) float64
        In the unit.
    unit : str or None
        The unit; None is metres, where these give a size that a vessel has.

    Raises
    ------
    InputError
        Where the size is not one of `SIZES`, with the units that would fit.
    """
    longest = float(np.ptp(vertices, axis=0).max())
    scale = UNITS[unit or "m"]
    low, high = SIZES
    if low <= longest * scale <= high:
        return vertices * scale
    fitting: list[Unit] = [name for name, factor in UNITS.items() if low <= longest * factor <= high]
    hint = f" (--vessels.unit {fitting[-1]} makes it {longest * UNITS[fitting[-1]]:.3g} m)" if fitting else ""
    stated = f"in {unit}" if unit else "in metres, as no unit is stated"
    expected = f"a vessel whose longest side has {1e3 * low:g} mm to {high:g} m"
    raise InputError(path, expected, f"{longest * scale:.3g} m {stated}{hint}")


def turned_up(vertices: np.ndarray, up: UpAxis) -> np.ndarray:
    """Return vertices turned so that an axis of the file points up."""
    places, signs = UP[up]
    return vertices[:, places] * signs


def default_up(path: Path) -> UpAxis:
    """Return the axis that is up in a format: y by glTF's standard; other formats do not say, and z is taken."""
    return "y" if path.suffix.lower() == ".glb" else "z"
