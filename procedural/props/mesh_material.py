"""Materials of mesh files: MTL beside OBJ, and the materials inside GLB.

A prop has one material: that of most of the faces in the file. PLY and STL have none.
"""

from __future__ import annotations

import base64
import hashlib
import json
import math
import struct
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.assets import asset
from ...core.cache_folder import cache_folder
from ...core.errors import InputError, cause_of
from ...core.user_text import usable_path, usable_text
from ..description.material import PictureTexture, UniformTexture
from ..materials.picture_files import read_picture

#: Chunk types of the GLB container (glTF 2.0 specification, section 4.4).
_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942
#: First bytes of the two picture formats that GLB allows, with their suffixes.
_PICTURE_MAGIC = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg"}


@dataclass(frozen=True)
class MeshMaterial:
    """The material in a mesh file; fields that the file does not define are None.

    Parameters
    ----------
    texture : PictureTexture or UniformTexture, optional
        Base colour.
    roughness : float, optional
        Principled roughness.
    metallic : float, optional
        0 dielectric, 1 metal.
    """

    texture: PictureTexture | UniformTexture | None = None
    roughness: float | None = None
    metallic: float | None = None


def default_picture_folder() -> Path:
    """Return the folder in the user's cache for pictures that are inside mesh files."""
    return cache_folder() / "pictures"


def obj_material(path: Path, root: Path, content: bytes) -> MeshMaterial:
    """Return the material of an OBJ file from its MTL file.

    ``map_Kd`` is used unscaled. ``Kd`` is used, as linear reflectance, only without it: exporters write a default of
    0.8 beside pictures. ``Ns`` is a Phong exponent: GGX alpha is sqrt(2 / (Ns + 2)) (Walter et al. 2007, section 5),
    and roughness its square root. Without the MTL file the material is empty.

    Raises
    ------
    InputError
        If the MTL file or its picture is outside `root`, or the picture cannot be read.
    """
    library, used = None, Counter()
    current = None
    for words in _statements(content):
        match words[0]:
            case "mtllib" if library is None:
                library = words[1]
            case "usemtl":
                current = words[1]
            case "f":
                used[current] += 1
    material = used.most_common(1)[0][0] if used else None
    if library is None or material is None:
        return MeshMaterial()
    file = _inside(path, root, library)
    if not file.is_file():
        return MeshMaterial()
    entries = _mtl_entries(file.read_bytes()).get(material, {})
    return MeshMaterial(texture=_mtl_texture(file, root, entries), roughness=_mtl_roughness(file, entries))


def glb_material(path: Path, root: Path, content: bytes, pictures: Path) -> MeshMaterial:
    """Return the material of a GLB file (glTF 2.0, section 3.9: factors are linear, and 1 by default).

    A picture inside the file is written to `pictures`, with its digest as its name. A base colour factor beside a
    picture is ignored. Pictures of roughness and metalness are ignored as well, with the factors that scale them.

    Raises
    ------
    InputError
        If the file's structure is broken, or a picture cannot be read or is outside `root`.
    """
    try:
        document, binary = _glb_chunks(content)
        material = _dominant_material(document)
        if material is None:
            return MeshMaterial()
        surface = material.get("pbrMetallicRoughness", {})
        picture = _glb_picture(document, binary, surface)
    except (LookupError, TypeError, AttributeError, ValueError, RecursionError, struct.error) as error:
        raise InputError(path, "a GLB file with valid materials", "materials that cannot be read") from error
    if isinstance(picture, str):
        texture = _picture(_inside(path, root, picture))
    elif picture is not None:
        texture = _write_picture(path, picture, pictures)
    else:
        texture = UniformTexture(colour=_reflectance(path, surface.get("baseColorFactor", [1.0, 1.0, 1.0])))
    if "metallicRoughnessTexture" in surface:
        return MeshMaterial(texture=texture)
    factors = [surface.get(field, 1.0) for field in ("roughnessFactor", "metallicFactor")]
    roughness, metallic = _factors(path, factors)
    return MeshMaterial(texture, float(roughness), float(metallic))


def _statements(content: bytes) -> list[list[str]]:
    """Return the lines of an OBJ or MTL file as [keyword, rest]."""
    lines = (line.strip().split(maxsplit=1) for line in content.decode("utf-8", "replace").splitlines())
    return [words for words in lines if len(words) == 2]


def _mtl_entries(content: bytes) -> dict[str, dict[str, str]]:
    materials: dict[str, dict[str, str]] = {}
    entries: dict[str, str] = {}
    for keyword, value in _statements(content):
        if keyword == "newmtl":
            entries = materials.setdefault(value, {})
        else:
            entries[keyword] = value
    return materials


def _mtl_texture(file: Path, root: Path, entries: dict[str, str]) -> PictureTexture | UniformTexture | None:
    if "map_Kd" in entries:
        value = entries["map_Kd"]
        # Options such as "-s 1 1 1" come before the name.
        return _picture(_inside(file, root, value.split()[-1] if value.startswith("-") else value))
    if "Kd" in entries:
        return UniformTexture(colour=_reflectance(file, entries["Kd"].split()))
    return None


def _mtl_roughness(file: Path, entries: dict[str, str]) -> float | None:
    if "Ns" not in entries:
        return None
    try:
        exponent = float(entries["Ns"])
    except ValueError as error:
        raise InputError(file, "a number for Ns", entries["Ns"]) from error
    if not math.isfinite(exponent):
        raise InputError(file, "a finite number for Ns", entries["Ns"])
    exponent = max(0.0, exponent)
    return float((2.0 / (exponent + 2.0)) ** 0.25)


def _reflectance(file: Path, values: list) -> tuple[float, float, float]:
    try:
        colour = np.array(values[:3], float)
    except (ValueError, TypeError) as error:
        raise InputError(file, "a colour of three numbers", values) from error
    if colour.shape != (3,) or not np.isfinite(colour).all():
        raise InputError(file, "a colour of three numbers", values)
    red, green, blue = np.clip(colour, 0.0, 1.0)
    return float(red), float(green), float(blue)


def _factors(file: Path, values: list) -> tuple[float, float]:
    """Return roughness and metalness in [0, 1]."""
    if not all(isinstance(value, int | float) and math.isfinite(value) for value in values):
        raise InputError(file, "finite numbers for roughnessFactor and metallicFactor", values)
    roughness, metallic = (float(min(max(value, 0.0), 1.0)) for value in values)
    return roughness, metallic


def _inside(file: Path, root: Path, name: str) -> Path:
    """Return the path of a name in a file, after a check that it is inside the user's folder."""
    try:
        path = usable_path((file.parent / usable_text(name.strip()).replace("\\", "/")).resolve())
        path.is_file()  # raises where the file system cannot hold such a name
    except (ValueError, OSError, RuntimeError) as error:  # NUL, letters that are not UTF-8, too long, links in a loop
        raise InputError(file, "names that a file can have", ascii(name[:80])) from error
    if not path.is_relative_to(root.resolve()):
        raise InputError(file, f"names of files inside {root}", name)
    return path


def _picture(path: Path) -> PictureTexture:
    read_picture(path)  # refuses an unreadable picture before anything is rendered
    return PictureTexture(asset=asset(path))


def _glb_chunks(content: bytes) -> tuple[dict, bytes]:
    document, binary, start = None, b"", 12
    while start + 8 <= len(content):
        length, kind = struct.unpack_from("<II", content, start)
        chunk = content[start + 8 : start + 8 + length]
        if kind == _JSON_CHUNK and document is None:
            document = json.loads(chunk)
        elif kind == _BINARY_CHUNK and not binary:
            binary = chunk
        start += 8 + length
    if not isinstance(document, dict):
        raise ValueError("no JSON chunk")
    return document, binary


def _dominant_material(document: dict) -> dict | None:
    """Return the material with most indices (without indices: with most vertices)."""
    used = Counter()
    for mesh in document.get("meshes", []):
        for primitive in mesh["primitives"]:
            accessor = primitive.get("indices", primitive["attributes"]["POSITION"])
            used[primitive.get("material")] += document["accessors"][accessor]["count"]
    index = used.most_common(1)[0][0] if used else None
    return None if index is None else document["materials"][index]


def _glb_picture(document: dict, binary: bytes, surface: dict) -> bytes | str | None:
    """Return the base colour picture: its bytes, or the name of its file."""
    reference = surface.get("baseColorTexture")
    if reference is None:
        return None
    image = document["images"][document["textures"][reference["index"]]["source"]]
    if "bufferView" in image:
        view = document["bufferViews"][image["bufferView"]]
        start = view.get("byteOffset", 0)
        return binary[start : start + view["byteLength"]]
    uri = image["uri"]
    return base64.b64decode(uri.split(",", 1)[1], validate=True) if uri.startswith("data:") else uri


def _write_picture(path: Path, picture: bytes, folder: Path) -> PictureTexture:
    """Write a picture from inside a mesh file to a folder, atomically."""
    suffix = next((suffix for magic, suffix in _PICTURE_MAGIC.items() if picture.startswith(magic)), None)
    if suffix is None:
        raise InputError(path, "a PNG or JPEG picture inside", "something else")
    target = folder / f"{hashlib.sha256(picture).hexdigest()}{suffix}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not target.is_file() or target.read_bytes() != picture:
            with tempfile.NamedTemporaryFile(dir=folder, suffix=suffix, delete=False) as file:
                file.write(picture)
            Path(file.name).replace(target)
    except OSError as error:
        raise InputError(folder, "a folder that can be written", cause_of(error)) from error
    try:
        return _picture(target)
    except InputError as error:
        raise InputError(path, "a readable picture inside", "a broken one") from error
