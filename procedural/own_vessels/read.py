"""Read a file as triangles, all its bodies together, in metres with z up, and the glass that it says."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ..mesh_files.layouts import Place
from ..mesh_files.model import Look, Source, content_of
from ..mesh_files.ply import ply_points
from ..mesh_files.read import read_parts
from ..vessels.settings import Unit, UpAxis

#: Longest side of a vessel [m]: from a vial to a demijohn. Other sizes are mistakes of the unit.
SIZES = (0.01, 0.7)
#: Metres in each unit.
UNITS: dict[Unit, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
#: A face in an OBJ file.
_FACE = re.compile(rb"^\s*fo?\s", re.MULTILINE)
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
    look : Look or None
        Its first transparent material.
    """

    vertices: np.ndarray
    faces: np.ndarray
    look: Look | None


def read_triangles(source: Source) -> Triangles:
    """Return the triangles of a file; InputError where it cannot be read, is too large, or is not finite."""
    points = _points_alone(source)
    if points is not None:
        if not np.isfinite(points).all():
            raise InputError(source.path, "finite points", "NaN or infinity")
        return Triangles(points, np.zeros((0, 3), np.int64), None)
    parts = read_parts(source)
    offsets = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    vertices = np.concatenate([part.vertices for part in parts])
    faces = np.concatenate([part.faces + offset for part, offset in zip(parts, offsets, strict=True)])
    look = next((part.look for part in parts if part.look.glass is not None), None)
    return Triangles(vertices, faces.astype(np.int64), look)


def _points_alone(source: Source) -> np.ndarray | None:
    """Return the points of an OBJ or PLY file without faces, (n, 3); None for any other file."""
    kind = source.path.suffix.lower()
    if kind == ".ply":
        return ply_points(source)
    content = content_of(source) if kind == ".obj" else b""
    return None if not content or _FACE.search(content) else _points(content)


def _points(content: bytes) -> np.ndarray | None:
    """Return the points of an OBJ file, (n, 3); None where a line is no point, or there is none."""
    lines = [line.split()[1:4] for line in content.splitlines() if line.startswith(b"v ")]
    try:
        return np.array(lines, dtype=np.float64).reshape(-1, 3) if lines else None
    except ValueError:
        return None


def metres_per_unit(path: Path, vertices: np.ndarray, unit: Unit | None, place: Place) -> float:
    """Return the length of a file's unit [m].

    Parameters
    ----------
    path : Path
        The file, for the error line.
    vertices : (n, 3) float64
        In the unit.
    unit : str or None
        The unit that the user states; without it, that of the layout; without that metres, where these give a size
        that a vessel has.
    place : Place
        What the file's place says.

    Raises
    ------
    InputError
        Where the size is not one of `SIZES`, with the units that would fit.
    """
    longest = float(np.ptp(vertices, axis=0).max())
    if longest == 0.0:
        raise InputError(path, "a mesh with faces, or points on a surface", "a single point")
    low, high = SIZES
    expected = f"a vessel whose longest side has {1e3 * low:g} mm to {high:g} m"
    if unit is None and place.unit == "none":
        found = f"{longest:.3g} units, as {place.layout} scales all models to one size (--vessels.unit states theirs)"
        raise InputError(path, expected, found)
    known = place.unit if unit is None and isinstance(place.unit, float) else None
    scale = known or UNITS[unit or "m"]
    if low <= longest * scale <= high:
        return scale
    fitting: list[Unit] = [name for name, factor in UNITS.items() if low <= longest * factor <= high]
    sizes = [f"{name} makes it {longest * UNITS[name]:.3g} m" for name in fitting]
    hint = f" (--vessels.unit {', '.join(sizes)})" if fitting else ""
    stated = f"in {unit}" if unit else f"by its layout, {place.layout}" if known else "in metres, as no unit is stated"
    raise InputError(path, expected, f"{longest * scale:.3g} m {stated}{hint}")


def turned_up(vertices: np.ndarray, up: UpAxis) -> np.ndarray:
    """Return vertices turned so that an axis of the file points up."""
    places, signs = UP[up]
    return vertices[:, places] * signs
