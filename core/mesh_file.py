"""Meshes as binary PLY files, read back bit for bit.

`trimesh` reads these files (a test proves it) but is not used to write or check them: it stores texture coordinates as
doubles, normalises normals again, and repairs damaged input silently.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .errors import InputError, cause_of
from .mesh import Mesh

#: Property names by field of a mesh; `s` and `t` are what MeshLab, Blender and Mitsuba take for texture coordinates.
_PROPERTIES = {
    "vertices": ("x", "y", "z"),
    "normals": ("nx", "ny", "nz"),
    "uv": ("s", "t"),
    "colours": ("red", "green", "blue"),
}
_FACE = np.dtype([("count", "u1"), ("index", "<i4", (3,))])
_FIRST_LINES = ["ply", "format binary_little_endian 1.0"]
_FACE_LINE = "property list uchar int vertex_indices"
#: Longest header [bytes]; the search for its end stops here in other files.
_LONGEST_HEADER = 1024
_END = b"end_header\n"


def write_mesh(mesh: Mesh, path: Path) -> None:
    """Write positions, faces, and (if present) normals, texture coordinates and colours, as float32 and int32."""
    fields = [field for field in _PROPERTIES if getattr(mesh, field) is not None]
    table = np.concatenate([getattr(mesh, field) for field in fields], axis=1).astype("<f4")
    faces = np.zeros(len(mesh.faces), _FACE)
    faces["count"], faces["index"] = 3, mesh.faces
    header = "\n".join(_header(fields, len(table), len(faces))).encode() + b"\n"
    path.write_bytes(header + table.tobytes() + faces.tobytes())


def read_mesh(path: Path, name: str) -> Mesh:
    """Read a file that `write_mesh` wrote; InputError for anything else, cut short or with faces out of range."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(path, "a readable mesh file", cause_of(error)) from error
    end = data.find(_END, 0, _LONGEST_HEADER)
    lines = data[: max(end, 0)].decode("ascii", "replace").split("\n")
    fields, n_vertices, n_faces = _parsed(lines, path)
    width = sum(len(_PROPERTIES[field]) for field in fields)
    body = data[end + len(_END) :]
    expected = 4 * width * n_vertices + _FACE.itemsize * n_faces
    if len(body) != expected:
        raise InputError(path, f"{expected} bytes of vertices and faces", len(body))
    table = np.frombuffer(body, "<f4", width * n_vertices).reshape(n_vertices, width)
    faces = np.frombuffer(body, _FACE, n_faces, offset=table.nbytes)
    _check_body(table, faces, path)
    parts = np.split(table, np.cumsum([len(_PROPERTIES[field]) for field in fields])[:-1], axis=1)
    return Mesh(name, faces=faces["index"], **dict(zip(fields, parts, strict=True)))


def _header(fields: list[str], n_vertices: int, n_faces: int) -> list[str]:
    names = [name for field in fields for name in _PROPERTIES[field]]
    properties = [f"property float {name}" for name in names]
    elements = [f"element vertex {n_vertices}", *properties, f"element face {n_faces}", _FACE_LINE]
    return [*_FIRST_LINES, *elements, _END.decode().strip()]


def _parsed(lines: list[str], path: Path) -> tuple[list[str], int, int]:
    counts = [line.split()[-1] for line in lines if line.startswith(("element vertex ", "element face "))]
    names = {line.split()[-1] for line in lines if line.startswith("property float ")}
    fields = [field for field, properties in _PROPERTIES.items() if names.issuperset(properties)]
    if len(counts) == 2 and all(count.isdecimal() for count in counts):
        n_vertices, n_faces = (int(count) for count in counts)
        # The header that follows from the parsed fields must be the one in the file.
        if "vertices" in fields and [*lines[:-1], _END.decode().strip()] == _header(fields, n_vertices, n_faces):
            return fields, n_vertices, n_faces
    raise InputError(path, "a binary PLY header as scene files have it", "something else")


def _check_body(table: np.ndarray, faces: np.ndarray, path: Path) -> None:
    if not np.isfinite(table).all():
        raise InputError(path, "finite vertices", "NaN or infinity")
    index = faces["index"]
    if (faces["count"] != 3).any() or (index < 0).any() or (index >= len(table)).any():
        raise InputError(path, f"triangles of vertices 0 to {len(table) - 1}", "other faces")
