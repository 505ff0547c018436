"""glTF 2.0 files: their JSON, their buffers, and the arrays in these (specification, sections 3.6 and 4)."""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote

import numpy as np

from ...core.errors import InputError
from .model import LARGEST_FILE, MOST_FACES, MOST_VERTICES, Source, content_of
from .records import licence_named
from .references import named_file

#: Chunk types of the GLB container (section 4.4).
_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942
_COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
#: What is raised where a file's structure is not that of the standard.
BROKEN = (LookupError, TypeError, AttributeError, ValueError, RecursionError, OverflowError, struct.error)
#: Extensions that change nothing here, or that are read: a file may require them.
KNOWN_EXTENSIONS = {
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_materials_ior",
    "KHR_materials_emissive_strength",
    "KHR_materials_unlit",
    "KHR_materials_specular",
    "KHR_materials_clearcoat",
    "KHR_materials_sheen",
    "KHR_materials_variants",
    "KHR_lights_punctual",
    "KHR_animation_pointer",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "EXT_texture_webp",
    "EXT_mesh_gpu_instancing",
}
#: What reads files with other extensions.
_HINTS = {
    "KHR_draco_mesh_compression": "gltf-transform or Blender writes it without Draco",
    "EXT_meshopt_compression": "gltf-transform or Blender writes it without meshopt",
    "KHR_texture_basisu": "gltf-transform or toktx writes its pictures as PNG",
}


@dataclass(frozen=True, eq=False)
class Gltf:
    """A file's JSON and how to get its buffers."""

    source: Source
    document: dict[str, Any]
    buffer: Callable[[int], bytes]  #: content of a buffer by its number


def read_gltf(source: Source) -> Gltf:
    """Return a GLB or glTF file's structure.

    Raises
    ------
    InputError
        Where the file is broken, of version 1, or requires an extension that is not known here.
    """
    content = content_of(source)
    kind = source.path.suffix.lower()[1:].upper()
    try:
        if content[:8] == b"glTF\1\0\0\0":
            raise InputError(source.path, "glTF 2.0", "version 1")
        _check_whole(source, content, kind)
        document, binary = _chunks(content) if content.startswith(b"glTF") else (json.loads(content), b"")
        if not isinstance(document, dict):
            raise ValueError("no object")
        version = str(document.get("asset", {}).get("version", "none"))
        required = [str(name) for name in document.get("extensionsRequired", [])]
    except InputError:
        raise
    except BROKEN as error:
        raise InputError(source.path, f"a readable {kind} mesh", unreadable(error)) from error
    if not version.startswith("2"):
        raise InputError(source.path, "glTF 2.0", f"version {version[:20]}")
    source.notes.facts["licence"] = _licence(document.get("asset", {}))
    unknown = [name for name in required if name not in KNOWN_EXTENSIONS]
    if unknown:
        hint = _HINTS.get(unknown[0], "")
        listed = ", ".join(unknown)[:200]
        raise InputError(source.path, "no required extension but known ones", f"{listed}{hint and f' ({hint})'}")
    buffers: dict[int, bytes] = {}

    def buffer(number: int) -> bytes:
        if number not in buffers:
            buffers[number] = _buffer(source, document["buffers"][number], binary if number == 0 else b"")
        return buffers[number]

    return Gltf(source, document, buffer)


def _check_whole(source: Source, content: bytes, kind: str) -> None:
    """Refuse what is no glTF file, and one that is cut short."""
    if content.startswith(b"glTF"):
        stated = struct.unpack_from("<I", content, 8)[0] if len(content) >= 12 else 12
        if stated > len(content):
            found = f"one that is cut short ({len(content):,} of {stated:,} bytes)"
            raise InputError(source.path, f"a readable {kind} mesh", found)
    elif not content.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        raise InputError(source.path, f"a readable {kind} mesh", f"a file that begins with {content[:12]!r}")


def unreadable(error: Exception) -> str:
    """Return what is wrong with a file whose structure is not that of the standard, as far as the error says it."""
    text = " ".join(str(error).split())[:120]
    if isinstance(error, KeyError):
        text = f"no entry {text}"
    elif isinstance(error, IndexError):
        text = "an index beyond its list"
    return f"one that cannot be read ({text or type(error).__name__})"


def _licence(asset: Any) -> str:
    """Return the licence that a file states of itself; Sketchfab writes it beside the author."""
    extras = asset.get("extras") if isinstance(asset, dict) else None
    stated = extras.get("license") if isinstance(extras, dict) else None
    stated = stated or (asset.get("copyright") if isinstance(asset, dict) else None)
    return (licence_named(stated) or "unknown") if isinstance(stated, str) else "unknown"


def _chunks(content: bytes) -> tuple[Any, bytes]:
    document, binary, start = None, b"", 12
    while start + 8 <= len(content):
        length, kind = struct.unpack_from("<II", content, start)
        chunk = content[start + 8 : start + 8 + length]
        if kind == _JSON_CHUNK and document is None:
            document = json.loads(chunk)
        elif kind == _BINARY_CHUNK and not binary:
            binary = chunk
        start += 8 + length
    if document is None:
        raise ValueError("no JSON chunk")
    return document, binary


def _buffer(source: Source, record: dict[str, Any], binary: bytes) -> bytes:
    if "uri" not in record:
        return binary
    return uri_content(source, record["uri"], "a buffer")


def uri_content(source: Source, uri: str, what: str) -> bytes:
    """Return the content of a data URI, or of a file inside the user's folder; InputError where there is none."""
    if uri.startswith("data:"):
        try:
            return base64.b64decode(uri.partition(",")[2], validate=True)
        except binascii.Error as error:
            raise InputError(source.path, f"{what} in base 64", "a damaged one") from error
    path = named_file(source, source.path, unquote(uri), what)
    if path is None:
        raise InputError(source.path, f"{what} ({uri[:60]!a}) inside the folder", "none")
    if path.stat().st_size > LARGEST_FILE:
        raise InputError(path, f"at most {LARGEST_FILE // 2**20} MiB", f"{path.stat().st_size // 2**20} MiB")
    return path.read_bytes()


def view_content(gltf: Gltf, number: int) -> tuple[bytes, int]:
    """Return the bytes of a buffer view, and its stride [bytes] (0: none); ValueError where the buffer is shorter."""
    view = _at(gltf.document["bufferViews"], number)
    start, length = int(view.get("byteOffset", 0)), int(view["byteLength"])
    buffer = gltf.buffer(int(view["buffer"]))
    if start < 0 or length < 0 or start + length > len(buffer):
        raise ValueError(f"expected {length} bytes from {start} in a buffer of {len(buffer)}")
    return buffer[start : start + length], int(view.get("byteStride", 0))


def accessor(gltf: Gltf, number: int) -> np.ndarray:
    """Return the array of an accessor, (n, width); normalised integers as numbers up to 1, others as they are.

    Raises
    ------
    ValueError
        Where the file has fewer bytes than the accessor claims.
    """
    record = _at(gltf.document["accessors"], number)
    count, width = int(record["count"]), _WIDTHS[record["type"]]
    kind = np.dtype(_COMPONENTS[record["componentType"]])
    if not 0 <= count <= max(MOST_VERTICES, 3 * MOST_FACES):
        raise ValueError(f"expected at most {MOST_VERTICES} elements, found {count}")
    if "bufferView" in record:
        values = _strided(gltf, record["bufferView"], int(record.get("byteOffset", 0)), count, width, kind)
    else:
        values = np.zeros((count, width), kind)
    if "sparse" in record:
        values = _with_sparse(gltf, record["sparse"], values)
    if record.get("normalized") and kind.kind in "iu":
        # Section 3.11: -128 and -127 both stand for -1.
        return np.maximum(values.astype(np.float64) / np.iinfo(kind).max, -1.0)
    return values


def _strided(gltf: Gltf, view: int, offset: int, count: int, width: int, kind: np.dtype) -> np.ndarray:
    content, stride = view_content(gltf, view)
    size = kind.itemsize * width
    stride = stride or size
    if offset < 0 or stride < size or (count and offset + stride * (count - 1) + size > len(content)):
        raise ValueError(f"expected {count} elements in {len(content)} bytes")
    if not count:
        return np.zeros((0, width), kind)
    bytes_ = np.frombuffer(content, np.uint8)
    rows = np.lib.stride_tricks.as_strided(bytes_[offset:], (count, size), (stride, 1), writeable=False)
    return np.ascontiguousarray(rows).view(kind).reshape(count, width)


def _with_sparse(gltf: Gltf, sparse: dict[str, Any], values: np.ndarray) -> np.ndarray:
    count, width = int(sparse["count"]), values.shape[1]
    places, changed = sparse["indices"], sparse["values"]
    kind = np.dtype(_COMPONENTS[places["componentType"]])
    index = _strided(gltf, places["bufferView"], int(places.get("byteOffset", 0)), count, 1, kind)[:, 0]
    rows = _strided(gltf, changed["bufferView"], int(changed.get("byteOffset", 0)), count, width, values.dtype)
    values = values.copy()
    values[index] = rows
    return values


def _at(records: list, number: int) -> dict[str, Any]:
    """Return an element; a negative number is an error, and not an element from the end."""
    if not isinstance(number, int) or number < 0:
        raise ValueError(f"expected an index, found {number}")
    return records[number]
