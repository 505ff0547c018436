"""Wavefront OBJ files: shape, texture coordinates, normals, colours of vertices, and which faces have which material.

The format is that of "Object Files (.obj)", Alias/Wavefront, Appendix B1 of the Advanced Visualizer manual (1995), and
vertices followed by colours as MeshLab and others write them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ...core.errors import InputError
from ..description.material import VertexColours
from ..materials.picture_files import srgb_to_linear
from .model import FilePart, Look, Source, check_counts, content_of, text_of
from .mtl import looks_of
from .polygons import triangulated

#: Keywords of what has no surface, and is left out.
_NO_SURFACE = {"p": "points", "l": "lines", "curv": "curves", "surf": "free-form surfaces"}
#: Largest index that is kept [1]: above what any file holds, and half of what an array of int64 does.
_FARTHEST = 2**62


@dataclass
class _Statements:
    """The statements of a file that matter, in their order."""

    v: list[list[str]] = field(default_factory=list)
    vt: list[list[str]] = field(default_factory=list)
    vn: list[list[str]] = field(default_factory=list)
    corners: list[str] = field(default_factory=list)
    #: Of each face: number of corners, material, and the counts of v, vt and vn before it, for relative indices.
    faces: list[tuple[int, int, int, int, int]] = field(default_factory=list)
    materials: dict[str | None, int] = field(default_factory=lambda: {None: 0})
    libraries: list[str] = field(default_factory=list)


def read_obj(source: Source) -> list[FilePart]:
    """Return the parts of an OBJ file, one for each material.

    Raises
    ------
    InputError
        Where the file cannot be read, has no faces, or a face names a vertex that is not there.
    """
    content = content_of(source)
    check_counts(source.path, content.count(b"\nf "), content.count(b"\nv "))
    found = _statements(source, content)
    if not found.faces:
        raise InputError(source.path, "a mesh with faces", " ".join(["none", *source.notes.remarks]))
    places, colours = _places(source, found.v)
    uv = _numbers(source, found.vt, 2, "vt")
    normals = _numbers(source, found.vn, 3, "vn")
    index = _corner_indices(source, found, (len(places), len(uv), len(normals)))
    counts = np.array([face[0] for face in found.faces])
    triangles, owner = triangulated(index[:, 0], counts, places)
    if not len(triangles):
        raise InputError(source.path, "a mesh with faces", "none with three corners")
    check_counts(source.path, len(triangles))
    looks = looks_of(source, found.libraries, list(found.materials))
    material = np.array([face[1] for face in found.faces])[owner]
    parts = []
    for name, number in found.materials.items():
        chosen = index[triangles[material == number]]
        if len(chosen):
            part = _part(chosen, places, uv, normals, colours)
            look = looks.get(name, Look(name or ""))
            # Exporters write a default colour of the material beside colours of vertices.
            if part.colours is not None and not (part.colours == 1.0).all() and not _has_picture(look):
                look = replace(look, texture=VertexColours())
            *scale, first, second = look.placement
            placed = part.uv if part.uv is None else part.uv * scale + [first, second]
            parts.append(replace(part, look=look, uv=placed))
    return parts


def _has_picture(look: Look) -> bool:
    return look.texture is not None and look.texture.kind == "picture"


def _statements(source: Source, content: bytes) -> _Statements:
    text = text_of(content).replace("\\\r\n", " ").replace("\\\n", " ")
    found, left_out, material = _Statements(), set(), 0
    v, vt, vn, corners, faces = found.v, found.vt, found.vn, found.corners, found.faces
    tables = {"v": v, "vt": vt, "vn": vn}
    for line in text.splitlines():
        named = "#" not in line or line.lstrip().startswith(("usemtl", "mtllib"))
        words = (line if named else line.partition("#")[0]).split() or [""]
        match words[0]:
            case "v" | "vt" | "vn":
                tables[words[0]].append(words[1:])
            case "f" | "fo":
                corners.extend(words[1:])
                faces.append((len(words) - 1, material, len(v), len(vt), len(vn)))
            case "usemtl":
                name = line.split(maxsplit=1)[1].strip() if len(words) > 1 else ""
                material = found.materials.setdefault(name, len(found.materials))
            case "mtllib":
                found.libraries.append(line.split(maxsplit=1)[1].strip() if len(words) > 1 else "")
            case word if word in _NO_SURFACE:
                left_out.add(_NO_SURFACE[word])
    if left_out:
        source.notes.say(f"its {' and '.join(sorted(left_out))} have no surface and are left out")
    return found


def _numbers(source: Source, rows: list[list[str]], width: int, keyword: str) -> np.ndarray:
    """Return the first numbers of each statement, (n, width); what is missing is 0."""
    if not rows:
        return np.zeros((0, width))
    short = any(len(row) < width for row in rows)
    rows = [(row + ["0"] * width)[:width] for row in rows] if short else [row[:width] for row in rows]
    try:
        return np.array(rows, dtype=object).astype(np.float64)
    except ValueError as error:
        raise InputError(source.path, f"numbers after {keyword}", str(error).rpartition(":")[2].strip()[:40]) from error


def _places(source: Source, rows: list[list[str]]) -> tuple[np.ndarray, np.ndarray | None]:
    """Return positions (n, 3), and the colours (n, 3) of vertices if all have them: ``v x y z [w] red green blue``."""
    places = _numbers(source, rows, 3, "v")
    widths = {len(row) for row in rows}
    if not widths or min(widths) < 6:
        return places, None
    colours = _numbers(source, [row[-3:] if len(row) in (6, 7) else row[3:6] for row in rows], 3, "v")
    if not np.isfinite(colours).all():
        return places, None
    # Most files have 0 to 1; some have bytes.
    scale = 255.0 if colours.max(initial=0.0) > 1.0 else 1.0
    return places, srgb_to_linear(np.clip(colours / scale, 0.0, 1.0))


def _index(text: str) -> int:
    """Return an index, or one that no file has where it is beyond what arrays hold."""
    return min(max(int(text), -_FARTHEST), _FARTHEST)


def _corner_indices(source: Source, found: _Statements, counts: tuple[int, int, int]) -> np.ndarray:
    """Return the indices of vertex, texture coordinate and normal of each corner, (c, 3), -1 where there is none."""
    known: dict[str, tuple[int, int, int]] = {}
    rows = []
    for word in found.corners:
        triple = known.get(word)
        if triple is None:
            try:
                parts = [_index(part) if part else 0 for part in word.split("/")[:3]]
            except ValueError as error:
                raise InputError(source.path, "faces of indices such as 3/1/2", ascii(word[:40])) from error
            triple = known[word] = tuple([*parts, 0, 0][:3])  # pyright: ignore[reportArgumentType]
        rows.append(triple)
    index = np.array(rows, np.int64).reshape(-1, 3)
    seen = np.repeat(np.array([face[2:] for face in found.faces]), [face[0] for face in found.faces], axis=0)
    index = np.where(index < 0, seen + index, index - 1)
    # Zero and missing become -1; a relative index before the first is out of range as well.
    for column, (count, what) in enumerate(zip(counts, ("vertices", "texture coordinates", "normals"), strict=True)):
        wrong = (index[:, column] >= count) | (index[:, column] < (0 if column == 0 else -1))
        if not wrong.any():
            continue
        if column == 0:
            place = int(index[wrong, column][0]) + 1
            raise InputError(source.path, f"faces over {count} vertices", f"one with index {place}")
        source.notes.say(f"faces with {what} that are not in the file go without")
        index[wrong, column] = -1
    return index


def _part(
    chosen: np.ndarray, places: np.ndarray, uv: np.ndarray, normals: np.ndarray, colours: np.ndarray | None
) -> FilePart:
    """Return the triangles (m, 3 corners, 3 indices) as a part with one vertex for each combination of indices."""
    corners, inverse = np.unique(chosen.reshape(-1, 3), axis=0, return_inverse=True)
    v, t, n = corners.T
    return FilePart(
        vertices=places[v],
        faces=inverse.reshape(-1, 3),
        normals=normals[n] if len(normals) and (n >= 0).all() else None,
        uv=np.where((t >= 0)[:, None], uv[np.maximum(t, 0)], 0.0) if len(uv) and (t >= 0).any() else None,
        colours=None if colours is None else colours[v],
    )
