"""PLY files: colours, texture coordinates of vertices and of corners, named pictures, text and both byte orders."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from glassware.core.errors import InputError

ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
COLOURS = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [188, 188, 188]])
UV = np.array([[0, 0], [1, 0], [0, 1], [1, 1]], float)


def _ply(order: str, columns: str, rows: list, faces: list, of_faces: str = "", comment: str = "") -> bytes:
    """Return a PLY of four vertices; `columns` are pairs of name and NumPy type."""
    pairs = [pair.split(":") for pair in columns.split()]
    types = {"f4": "float", "u1": "uchar", "i4": "int"}
    lines = ["ply", f"format {order} 1.0", *([f"comment {comment}"] if comment else []), f"element vertex {len(rows)}"]
    lines += [f"property {types[kind]} {name}" for name, kind in pairs]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    lines += ["property list uchar float texcoord"] if of_faces == "texcoord" else []
    head = ("\n".join([*lines, "end_header"]) + "\n").encode()
    if order == "ascii":
        body = [" ".join(f"{value:g}" for value in row) for row in rows]
        body += [" ".join(f"{len(part)} " + " ".join(f"{v:g}" for v in part) for part in face) for face in faces]
        return head + "\n".join(body).encode() + b"\n"
    mark, packed = ORDERS[order], b""
    for row in rows:
        for value, (_, kind) in zip(row, pairs, strict=True):
            packed += struct.pack(mark + {"f4": "f", "u1": "B", "i4": "i"}[kind], value if kind == "f4" else int(value))
    for face in faces:
        for part, kind in zip(face, "if", strict=False):
            packed += struct.pack("B", len(part)) + struct.pack(f"{mark}{len(part)}{kind}", *part)
    return head + packed


XYZ = "x:f4 y:f4 z:f4"
PLAIN_FACES = [[[0, 2, 1]], [[0, 1, 3]], [[1, 2, 3]], [[2, 0, 3]]]


@pytest.mark.parametrize("order", ORDERS)
def test_colours_of_vertices_are_linear_ones_of_their_bytes(makers: ModuleType, tmp_path: Path, order: str) -> None:
    rows = np.concatenate([makers.POSITIONS, COLOURS, np.full((4, 1), 255)], axis=1).tolist()
    content = _ply(order, XYZ + " red:u1 green:u1 blue:u1 alpha:u1", rows, PLAIN_FACES)
    (part,), _ = makers.parts_of(makers.written(tmp_path, {"a.ply": content}) / "a.ply")
    assert part.look.texture.kind == "vertices"
    assert np.allclose(part.colours, [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5029] * 3], atol=1e-4)
    assert np.allclose(part.vertices, makers.POSITIONS)
    assert np.array_equal(part.faces, makers.TRIANGLES)


@pytest.mark.parametrize("names", ["s t", "texture_u texture_v", "u v"])
def test_a_named_picture_lies_by_the_coordinates_of_the_vertices(
    makers: ModuleType, tmp_path: Path, names: str
) -> None:
    u, v = names.split()
    rows = np.concatenate([makers.POSITIONS, UV], axis=1).tolist()
    content = _ply("ascii", f"{XYZ} {u}:f4 {v}:f4", rows, PLAIN_FACES, comment="TextureFile obj 2.png")
    (part,), notes = makers.parts_of(makers.written(tmp_path, {"a.ply": content, "obj 2.png": makers.png()}) / "a.ply")
    assert part.look.texture.kind == "picture"
    corners = np.concatenate([part.vertices, part.uv], axis=1)
    assert sorted(map(tuple, corners.tolist())) == sorted(map(tuple, rows))
    assert not notes.remarks


@pytest.mark.parametrize("order", ORDERS)
def test_coordinates_of_corners_and_polygons_of_any_size_are_read(
    makers: ModuleType, tmp_path: Path, order: str
) -> None:
    faces = [[[0, 2, 1], [0, 0, 0, 1, 1, 0]], [[0, 1, 3, 2], [0, 0, 1, 0, 1, 1, 0, 1]]]
    content = _ply(order, XYZ, makers.POSITIONS.tolist(), faces, "texcoord", "TextureFile gone.png")
    (part,), notes = makers.parts_of(makers.written(tmp_path, {"a.ply": content}) / "a.ply")
    assert len(part.faces) == 3
    assert np.allclose(part.uv[part.faces[0]], [[0, 0], [0, 1], [1, 0]])
    assert notes.remarks == [f"a.ply: expected its picture ('gone.png') inside {tmp_path.name}, found none"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda text: text[:-9], "damaged or cut short"),
        (lambda text: text.replace(b"vertex 4", b"vertex 99999999999"), "at most 6,000,000 vertices"),
        (lambda text: text.replace(b"face 4", b"face 10000000"), "at most 2,000,000 faces, found 10,000,000"),
        (lambda text: text.replace(b"face 4", b"face 2000000"), "damaged or cut short"),
        (lambda text: text.replace(b"format", b"formal"), "one without a format"),
        (lambda text: text.replace(b"property float z", b"property quad z"), "header line 'property quad z'"),
        (lambda text: text.replace(b"property float z\n", b""), "readable PLY mesh|with x, y and z|damaged"),
        (lambda text: text.replace(b"end_header", b"end_headr"), "one without a header"),
    ],
)
@pytest.mark.parametrize("order", ["ascii", "binary_little_endian"])
def test_a_damaged_file_is_one_line(
    makers: ModuleType, tmp_path: Path, order: str, change: Callable[[bytes], bytes], said: str
) -> None:
    content = change(_ply(order, XYZ, makers.POSITIONS.tolist(), PLAIN_FACES))
    with pytest.raises(InputError, match=said) as caught:
        makers.parts_of(makers.written(tmp_path, {"a.ply": content}) / "a.ply")
    assert "\n" not in str(caught.value)


def test_colours_of_two_bytes_and_points_alone(makers: ModuleType, tmp_path: Path) -> None:
    head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    colours = "".join(f"property ushort {name}\n" for name in ("red", "green", "blue"))
    rows = "".join("{} {} {} 65535 32768 0\n".format(*place) for place in makers.POSITIONS)
    faces = "".join("3 {} {} {}\n".format(*corners) for corners in makers.TRIANGLES)
    text = head + colours + "element face 4\nproperty list uchar int vertex_indices\nend_header\n" + rows + faces
    (part,), _ = makers.parts_of(makers.written(tmp_path, {"a.ply": text}) / "a.ply")
    assert np.allclose(part.colours, [1.0, 0.2140, 0.0], atol=1e-4)
    with pytest.raises(InputError, match="a mesh with faces, found 4 points alone"):
        makers.parts_of(makers.written(tmp_path, {"b.ply": head + colours + "end_header\n" + rows}) / "b.ply")
