"""From any mesh file to its parts, in one way for all formats."""

from __future__ import annotations

import re
import struct
from dataclasses import replace

import numpy as np

from ...core.errors import InputError
from ..description.material import PictureTexture, UniformTexture
from ..materials.textures import bake
from .cutouts import cut
from .gltf import read_gltf_parts
from .model import FilePart, Source, check_counts, content_of
from .obj import read_obj
from .ply import read_ply

#: Formats that are read.
MESH_SUFFIXES = (".glb", ".gltf", ".obj", ".ply", ".stl")
#: Bytes of a binary STL file before its triangles, and one triangle: normal, corners and two bytes that mean nothing.
_STL_HEAD = 84
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])


def read_parts(source: Source) -> list[FilePart]:
    """Return the parts of a mesh file, in its axes and unit, without what pictures of opacity cut away.

    Raises
    ------
    InputError
        Where the file cannot be read, has no faces, or has coordinates that are not finite.
    """
    parts = _READERS[source.path.suffix.lower()](source)
    for part in parts:
        used = part.vertices[np.unique(part.faces)]
        if not np.isfinite(used).all():
            raise InputError(source.path, "finite vertices", "NaN or infinity")
    parts = [cut(_in_plain_colour(source, _with_usable(part))) for part in parts]
    parts = [part for part in parts if len(part.faces)]
    if not parts:
        raise InputError(source.path, "a mesh with faces", "none that its opacity leaves")
    return parts


def _with_usable(part: FilePart) -> FilePart:
    """Return the part without texture coordinates or normals that are not finite, or not one for each vertex."""

    def usable(values: np.ndarray | None) -> np.ndarray | None:
        fits = values is not None and len(values) == len(part.vertices) and np.isfinite(values).all()
        return values if fits else None

    return replace(part, uv=usable(part.uv), normals=usable(part.normals))


def _in_plain_colour(source: Source, part: FilePart) -> FilePart:
    """Return a part with a picture but no texture coordinates in its plain colour, or in the picture's mean colour."""
    texture, glow = part.look.texture, part.look.glow
    if glow is not None and isinstance(glow.texture, PictureTexture) and (part.uv is None or part.colours is not None):
        # Colours of vertices are rendered as a picture with coordinates of its own.
        glow = replace(glow, texture=_mean_colour(glow.texture))
        part = replace(part, look=replace(part.look, glow=glow))
    if part.uv is not None or not (isinstance(texture, PictureTexture) or part.look.maps):
        return part
    if not isinstance(texture, PictureTexture):
        source.notes.say(f"material {part.look.name!r} has maps, but its faces have no texture coordinates")
        return replace(part, look=replace(part.look, maps={}))
    source.notes.say(f"material {part.look.name!r} has a picture, but its faces have no texture coordinates")
    plain = _mean_colour(texture) if part.look.plain is None else UniformTexture(colour=part.look.plain)
    return replace(part, look=replace(part.look, texture=plain, maps={}, cutout=None))


def _mean_colour(texture: PictureTexture) -> UniformTexture:
    red, green, blue = np.clip(bake(texture).mean((0, 1)), 0.0, 1.0).tolist()
    return UniformTexture(colour=(red, green, blue))


def _read_stl(source: Source) -> list[FilePart]:
    """Return an STL file's surface, binary or text (M. Burns, "Automated Fabrication", 1993, section 6.5)."""
    content = content_of(source)
    count = struct.unpack_from("<I", content, _STL_HEAD - 4)[0] if len(content) >= _STL_HEAD else 0
    # Text begins with "solid" and has no zero bytes; some binary files begin so too.
    start = content[:1000].lstrip().lower()
    fits = count > 0 and len(content) >= _STL_HEAD + _STL_TRIANGLE.itemsize * count
    if start.startswith(b"solid") and b"\0" not in start and (b"facet" in start or not fits):
        corners = _stl_text(source, content)
    elif fits:
        check_counts(source.path, count)
        corners = np.frombuffer(content, _STL_TRIANGLE, count, _STL_HEAD)["corners"].reshape(-1, 3)
    else:
        found = "none" if len(content) >= _STL_HEAD and not count else f"a file that is too short for {count:,}"
        raise InputError(source.path, "a mesh with faces", found)
    if not len(corners):
        raise InputError(source.path, "a mesh with faces", "none")
    return [FilePart(corners.astype(np.float64), np.arange(len(corners)).reshape(-1, 3))]


def _stl_text(source: Source, content: bytes) -> np.ndarray:
    """Return the corners of an STL file in text, (3 m, 3); keywords may be capitals."""
    facets = len(re.findall(rb"facet\s+normal", content, re.IGNORECASE))
    check_counts(source.path, facets)
    rows = re.findall(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", content, re.IGNORECASE)
    if len(rows) != 3 * facets:
        found = f"{len(rows):,} corners, as of a file that is cut short"
        raise InputError(source.path, f"three corners for each of {facets:,} facets", found)
    try:
        return np.array(rows, dtype=object).astype(np.float64).reshape(-1, 3)
    except ValueError as error:
        raise InputError(source.path, "a readable STL mesh", "one with letters for numbers") from error


_READERS = {
    ".glb": read_gltf_parts,
    ".gltf": read_gltf_parts,
    ".obj": read_obj,
    ".ply": read_ply,
    ".stl": _read_stl,
}
