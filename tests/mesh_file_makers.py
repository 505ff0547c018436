"""Small mesh files, written by hand after the formats' specifications."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import cv2
import numpy as np

from glassware.procedural.mesh_files.model import FilePart, Notes, Source
from glassware.procedural.mesh_files.read import read_parts

CORNERS = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\n"
FACES = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
MAPPED = CORNERS + "vt 0 0\nvt 1 0\nvt 0 1\nmtllib look.mtl\nusemtl skin\nf 1/1 3/2 2/3\nf 1/1 2/2 4/3\nf 2/1 3/2 4/3\n"
POSITIONS = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def png(colour: tuple[int, ...] = (255, 0, 0), suffix: str = ".png") -> bytes:
    """Return a picture of 4 x 4 pixels of one colour, red, green, blue and perhaps opacity."""
    order = [2, 1, 0, 3][: len(colour)]
    return cv2.imencode(suffix, np.full((4, 4, len(colour)), [colour[k] for k in order], np.uint8))[1].tobytes()


def written(folder: Path, files: dict[str, str | bytes]) -> Path:
    """Write files below a folder and return it."""
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return folder


def parts_of(path: Path, root: Path | None = None) -> tuple[list[FilePart], Notes]:
    """Return the parts of a file, and the notes on it."""
    source = Source(path, root or path.parent, path.parent / "kept")
    return read_parts(source), source.notes


def glb(
    materials: list[dict] | None = None,
    picture: bytes = b"",
    columns: dict[str, np.ndarray] | None = None,
    **changes: object,
) -> bytes:
    """Return a GLB of a tetrahedron for each material, side by side.

    Parameters
    ----------
    materials : list of dict, optional
        glTF materials; texture 0 is the picture.
    picture : bytes
        Picture in the file.
    columns : dict, optional
        Further attributes of the vertices, four rows of float32 each.
    **changes
        Of the JSON document.
    """
    materials = [{}] if materials is None else materials
    uv = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
    arrays = {"POSITION": POSITIONS, "TEXCOORD_0": uv, **(columns or {})}
    blobs = [np.asarray(values, "<f4").tobytes() for values in arrays.values()]
    blobs += [np.asarray(TRIANGLES, "<u4").tobytes()] + ([picture] if picture else [])
    views, start = [], 0
    for blob in blobs:
        views.append({"buffer": 0, "byteOffset": start, "byteLength": len(blob)})
        start += len(blob)
    kinds = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
    accessors = [
        {"bufferView": i, "componentType": 5126, "count": 4, "type": kinds[np.shape(values)[1]]}
        for i, values in enumerate(arrays.values())
    ]
    index = len(accessors)
    accessors.append({"bufferView": index, "componentType": 5125, "count": 12, "type": "SCALAR"})
    attributes = {name: i for i, name in enumerate(arrays)}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(materials)))}],
        "nodes": [{"mesh": i, "translation": [0.2 * i, 0, 0]} for i in range(len(materials))],
        "meshes": [
            {"primitives": [{"attributes": attributes, "indices": index, "material": i}]} for i in range(len(materials))
        ],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": start}],
        "materials": materials,
    }
    if picture:
        document |= {"textures": [{"source": 0}], "images": [{"bufferView": index + 1, "mimeType": "image/png"}]}
    return glb_of(document | changes, b"".join(blobs))


def glb_of(document: dict, binary: bytes) -> bytes:
    """Return a GLB of a JSON document and a buffer."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def surface(**fields: object) -> dict:
    """Return a glTF material of metallic-roughness fields."""
    return {"pbrMetallicRoughness": fields}
