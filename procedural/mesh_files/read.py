"""From any mesh file to its parts, in one way for all formats."""

from __future__ import annotations

import io
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
#: Bytes of a binary STL file before its triangles, and of one triangle.
_STL_HEAD, _STL_TRIANGLE = 84, 50


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
    """Return the part without texture coordinates or normals that are not finite."""
    uv = part.uv if part.uv is not None and np.isfinite(part.uv).all() else None
    normals = part.normals if part.normals is not None and np.isfinite(part.normals).all() else None
    return replace(part, uv=uv, normals=normals)


def _in_plain_colour(source: Source, part: FilePart) -> FilePart:
    """Return a part with a picture but no texture coordinates in its plain colour, or in the picture's mean colour."""
    texture = part.look.texture
    if part.uv is not None or not isinstance(texture, PictureTexture):
        return part
    source.notes.say(f"material {part.look.name!r} has a picture, but its faces have no texture coordinates")
    red, green, blue = part.look.plain or np.clip(bake(texture).mean((0, 1)), 0.0, 1.0).tolist()
    look = replace(part.look, texture=UniformTexture(colour=(red, green, blue)), maps={}, cutout=None)
    return replace(part, look=look)


def _read_stl(source: Source) -> list[FilePart]:
    """Return an STL file's surface, binary or text."""
    content = content_of(source)
    count = struct.unpack_from("<I", content, 80)[0] if len(content) >= _STL_HEAD else 0
    binary = len(content) == _STL_HEAD + _STL_TRIANGLE * count
    check_counts(source.path, count if binary else content.count(b"facet normal"))
    try:
        # From memory and without a resolver: no other file is opened here.
        import trimesh  # here, as it takes half a second to load

        mesh = trimesh.load_mesh(io.BytesIO(content), file_type="stl", process=False)
        vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    except Exception as error:  # the reader raises exceptions of many types for malformed files
        raise InputError(source.path, "a readable STL mesh", "one that cannot be read") from error
    if not len(faces):
        raise InputError(source.path, "a mesh with faces", "none")
    return [FilePart(vertices, faces)]


_READERS = {
    ".glb": read_gltf_parts,
    ".gltf": read_gltf_parts,
    ".obj": read_obj,
    ".ply": read_ply,
    ".stl": _read_stl,
}
