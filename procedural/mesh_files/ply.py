"""PLY files of any kind: shape, normals, colours, texture coordinates of vertices or corners, and named pictures.

The format is that of G. Turk, "The PLY Polygon File Format" (1994). Colours of vertices are sRGB bytes, as BOP's models
and scanners have them; ``comment TextureFile`` names the picture, as MeshLab and BOP's YCB-V have it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ...core.errors import InputError
from ..description.material import VertexColours
from ..materials.picture_files import srgb_to_linear
from .model import FilePart, Look, Source, check_counts, content_of
from .polygons import triangulated
from .references import named_file, picture

_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ORDERS = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}
_UV_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"), ("tx", "ty"))
#: Longest header [bytes]: some scanners write long comments.
_LONGEST_HEADER = 65_536


@dataclass(frozen=True)
class _Property:
    name: str
    kind: str  #: NumPy's name of the type, without byte order
    count: str | None = None  #: of a list, the type of its length


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: tuple[_Property, ...]

    @property
    def lists(self) -> tuple[_Property, ...]:
        return tuple(item for item in self.properties if item.count is not None)


@dataclass(frozen=True)
class _Header:
    order: str | None  #: NumPy's byte order, None for text
    elements: tuple[_Element, ...]
    pictures: tuple[str, ...]
    end: int  #: where the body starts [bytes]


#: Columns of an element: numbers (n,), or for lists (lengths (n,), values (sum,)).
_Columns = dict[str, np.ndarray | tuple[np.ndarray, np.ndarray]]


def read_ply(source: Source) -> list[FilePart]:
    """Return the surface of a PLY file as one part.

    Raises
    ------
    InputError
        Where the file cannot be read, is cut short, or has no faces.
    """
    header, columns = _read(source)
    vertex, face = columns.get("vertex", {}), columns.get("face", {})
    corners = next((face[name] for name in ("vertex_indices", "vertex_index") if name in face), None)
    if not all(axis in vertex for axis in "xyz"):
        raise InputError(source.path, "vertices with x, y and z", "none")
    if not isinstance(corners, tuple):
        points = f"{len(np.asarray(vertex['x'])):,} points alone"
        what = "strips of triangles" if "tristrips" in columns else points
        raise InputError(source.path, "a mesh with faces", what)
    return [_part(source, header, vertex, face, corners)]


def ply_points(source: Source) -> np.ndarray | None:
    """Return the vertices of a PLY file without faces, (n, 3) float64; None for one with faces or strips of them."""
    header, columns = _read(source)
    if any(element.count for element in header.elements if element.name in ("face", "tristrips")):
        return None
    vertex = columns.get("vertex", {})
    return _together(vertex, ("x", "y", "z")) if all(axis in vertex for axis in "xyz") else None


def _read(source: Source) -> tuple[_Header, dict[str, _Columns]]:
    """Return the header of a PLY file and the columns of its elements."""
    content = content_of(source)
    header = _header(source, content)
    for element in header.elements:
        faces = element.count if element.name == "face" else 0
        check_counts(source.path, faces, element.count - faces)
    try:
        columns = (_text if header.order is None else _binary)(content, header)
    except (ValueError, IndexError, OverflowError, TypeError) as error:
        raise InputError(source.path, "a readable PLY mesh", "one that is damaged or cut short") from error
    return header, columns


def _part(
    source: Source, header: _Header, vertex: _Columns, face: _Columns, corners: tuple[np.ndarray, np.ndarray]
) -> FilePart:
    places = _together(vertex, ("x", "y", "z"))
    counts, index = corners[0].astype(np.int64), corners[1].astype(np.int64)
    if len(index) and (index.min() < 0 or index.max() >= len(places)):
        found = f"indices {index.min()} to {index.max()}"
        raise InputError(source.path, f"faces over {len(places)} vertices", found)
    triangles, owner = triangulated(index, counts, places)
    if not len(triangles):
        raise InputError(source.path, "a mesh with faces", "none")
    normals = _together(vertex, ("nx", "ny", "nz")) if "nx" in vertex and "nz" in vertex else None
    colours = _colours(vertex, header, "vertex")
    of_faces = _colours(face, header, "face") if colours is None else None
    wedges = face.get("texcoord")
    uv = next((_together(vertex, names) for names in _UV_NAMES if names[0] in vertex and names[1] in vertex), None)
    if isinstance(wedges, tuple) and (wedges[0] == 2 * counts).all():
        corner_uv = wedges[1].reshape(-1, 2).astype(np.float64)[triangles]
    else:
        corner_uv = None if uv is None else uv[index[triangles]]
    if corner_uv is None and of_faces is None:
        vertices, faces, rows = places, index[triangles], np.arange(len(places))
        kept = colours
    else:
        # Corners of their own, welded again where all is equal.
        columns = [index[triangles].reshape(-1, 1).astype(np.float64)]
        columns += [] if corner_uv is None else [corner_uv.reshape(-1, 2)]
        columns += [] if of_faces is None else [np.repeat(of_faces[owner], 3, axis=0)]
        table, inverse = np.unique(np.concatenate(columns, axis=1), axis=0, return_inverse=True)
        rows, faces = table[:, 0].astype(np.int64), inverse.reshape(-1, 3)
        vertices, kept = places[rows], table[:, -3:] if of_faces is not None else None
        kept = colours[rows] if colours is not None else kept
        uv = table[:, 1:3] if corner_uv is not None else None
    look = _look(source, header, uv is not None, kept is not None)
    return FilePart(vertices, faces, look, None if normals is None else normals[rows], uv, kept)


def _look(source: Source, header: _Header, has_uv: bool, has_colours: bool) -> Look:
    texture = None
    if has_uv and header.pictures:
        if len(header.pictures) > 1:
            source.notes.say(f"of its {len(header.pictures)} pictures only the first is used")
        path = named_file(source, source.path, next(iter(header.pictures)), "its picture")
        texture = picture(source, path, "its picture")
    if texture is None and has_colours:
        texture = VertexColours()
    return Look(texture=texture)


def _header(source: Source, content: bytes) -> _Header:
    expected = "a readable PLY mesh"
    match = re.match(rb"ply\s", content)
    end = re.search(rb"(?:^|\n|\r)end_header[ \t]*(\r\n|\n|\r)", content[:_LONGEST_HEADER])
    if match is None or end is None:
        raise InputError(source.path, expected, "one without a header")
    order: str | None = "none"
    elements: list[_Element] = []
    pictures: list[str] = []
    for line in re.split(r"[\r\n]+", content[: end.start()].decode("utf-8", "replace")):
        words = line.split()
        match words:
            case ["format", name, *_] if name in _ORDERS:
                order = _ORDERS[name]
            case ["comment", key, *name] if key.lower() == "texturefile" and name:
                pictures.append(line.split(maxsplit=2)[2].strip())
            case ["element", name, count] if count.isdecimal() and len(count) < 12:
                elements.append(_Element(name, int(count), ()))
            case ["property", *kind, name] if elements and (item := _property(kind, name)) is not None:
                elements[-1] = _Element(elements[-1].name, elements[-1].count, (*elements[-1].properties, item))
            case ["element" | "property", *_]:
                raise InputError(source.path, expected, f"the header line {line[:60]!a}")
    if order == "none":
        raise InputError(source.path, expected, "one without a format")
    return _Header(order, tuple(elements), tuple(pictures), end.end())


def _property(words: list[str], name: str) -> _Property | None:
    """Return a property of a header line, a list or a number; None where the types are unknown."""
    match words:
        case ["list", count, kind] if {count, kind} <= _TYPES.keys():
            return _Property(name, _TYPES[kind], _TYPES[count])
        case [kind] if kind in _TYPES:
            return _Property(name, _TYPES[kind])
    return None


def _binary(content: bytes, header: _Header) -> dict[str, _Columns]:
    found, place = {}, header.end
    for element in header.elements:
        read = _records if not element.lists else _lists
        found[element.name], place = read(content, place, element, str(header.order))
    return found


def _records(content: bytes, place: int, element: _Element, order: str) -> tuple[_Columns, int]:
    kind = np.dtype([(item.name, order + item.kind) for item in element.properties])
    if place + element.count * kind.itemsize > len(content):
        raise ValueError("expected more bytes")
    table = np.frombuffer(content, kind, element.count, place)
    return {item.name: table[item.name] for item in element.properties}, place + element.count * kind.itemsize


def _lists(content: bytes, place: int, element: _Element, order: str) -> tuple[_Columns, int]:
    """Read rows with lists: all at once where their lengths are those of the first row, else row by row."""
    if element.count and 0 < element.count * 2 <= len(content):
        lengths = _row_lengths(content, place, element, order)
        fields = []
        for item in element.properties:
            if item.count is not None:
                fields.append((f"{item.name} length", order + item.count))
            shape = (lengths[item.name],) if item.count is not None else ()
            fields.append((item.name, order + item.kind, shape))
        kind = np.dtype(fields)
        if place + element.count * kind.itemsize <= len(content):
            table = np.frombuffer(content, kind, element.count, place)
            if all((table[f"{item.name} length"] == lengths[item.name]).all() for item in element.lists):
                return _regular(table, element), place + element.count * kind.itemsize
    return _row_by_row(content, place, element, order)


def _regular(table: np.ndarray, element: _Element) -> _Columns:
    columns: _Columns = {}
    for item in element.properties:
        values = table[item.name]
        columns[item.name] = values if item.count is None else (table[f"{item.name} length"], values.ravel())
    return columns


def _row_lengths(content: bytes, place: int, element: _Element, order: str) -> dict[str, int]:
    lengths = {}
    for item in element.properties:
        if item.count is not None:
            lengths[item.name] = int(np.frombuffer(content, order + item.count, 1, place)[0])
            if lengths[item.name] < 0:
                raise ValueError("expected a length")
            place += np.dtype(item.count).itemsize
        place += np.dtype(item.kind).itemsize * lengths.get(item.name, 1)
    return lengths


def _row_by_row(content: bytes, place: int, element: _Element, order: str) -> tuple[_Columns, int]:
    values: dict[str, list[np.ndarray]] = {item.name: [] for item in element.properties}
    for _ in range(element.count):
        lengths = _row_lengths(content, place, element, order)
        for item in element.properties:
            place += 0 if item.count is None else np.dtype(item.count).itemsize
            count = lengths.get(item.name, 1)
            values[item.name].append(np.frombuffer(content, order + item.kind, count, place))
            place += np.dtype(item.kind).itemsize * count
    return _joined(element, values), place


def _text(content: bytes, header: _Header) -> dict[str, _Columns]:
    words = content[header.end :].split()
    found, place = {}, 0
    for element in header.elements:
        width = len(element.properties)
        if not element.lists:
            end = place + element.count * width
            if end > len(words):
                raise ValueError("expected more numbers")
            table = np.array(words[place:end], dtype=object).astype(np.float64).reshape(element.count, width)
            found[element.name] = {item.name: table[:, i] for i, item in enumerate(element.properties)}
            place = end
            continue
        values: dict[str, list[np.ndarray]] = {item.name: [] for item in element.properties}
        for _ in range(element.count):
            for item in element.properties:
                count = 1
                if item.count is not None:
                    count, place = int(words[place]), place + 1
                if count < 0 or place + count > len(words):
                    raise ValueError("expected more numbers")
                values[item.name].append(np.array(words[place : place + count], dtype=object).astype(np.float64))
                place += count
        found[element.name] = _joined(element, values)
    return found


def _joined(element: _Element, values: dict[str, list[np.ndarray]]) -> _Columns:
    columns: _Columns = {}
    for item in element.properties:
        rows = values[item.name]
        whole = np.concatenate(rows) if rows else np.zeros(0)
        columns[item.name] = whole if item.count is None else (np.array([len(row) for row in rows], np.int64), whole)
    return columns


def _together(columns: _Columns, names: tuple[str, ...]) -> np.ndarray:
    return np.stack([np.asarray(columns[name], np.float64) for name in names], axis=1)


def _colours(columns: _Columns, header: _Header, element: str) -> np.ndarray | None:
    """Return linear colours (n, 3) of sRGB integers, or of numbers from 0 to 1; None where there are none."""
    kinds = {item.name: item.kind for each in header.elements if each.name == element for item in each.properties}
    for prefix in ("", "diffuse_"):
        names = tuple(prefix + name for name in ("red", "green", "blue"))
        if not all(isinstance(columns.get(name), np.ndarray) for name in names):
            continue
        values = _together(columns, names)
        if not np.isfinite(values).all():
            return None
        kind = np.dtype(kinds[names[0]])
        scale = float(np.iinfo(kind).max) if kind.kind == "u" and kind.itemsize < 4 else 255.0
        if kind.kind == "f" and values.max(initial=0.0) <= 1.0:
            scale = 1.0
        return srgb_to_linear(np.clip(values / scale, 0.0, 1.0))
    return None
