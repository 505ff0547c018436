"""A scene as one glTF 2.0 file: meshes, poses, glass and liquids with their optical constants, and all cameras.

glTF's world is y up, so one node turns ours. Nodes of objects hold meshes in object frames, and the pose as a matrix.
Glass and liquids are closed bodies of their own, with the extensions for transmission, index and absorption
(KHR_materials_transmission, _ior, _volume). Opaque materials are their mean colour, roughness and metalness.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ....core.atomic_io import atomic_file
from ....core.mesh import Mesh
from ....procedural.description.camera import Camera
from ....procedural.description.material import OpaqueMaterial
from ....procedural.description.scene import Prop, Scene, SceneObject, glass_solid, liquid_solid
from ....procedural.optics.medium import Medium
from ...format import layout
from ...format.objects_file import ObjectRecord
from ..files import compact_json
from .folders import scene_files
from .looks import opaque_look

#: glTF 2.0, binary: magic number, version, types of chunks.
_MAGIC, _VERSION, _JSON, _BIN = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
#: Types of numbers and targets of buffers (OpenGL's).
_FLOAT, _UNSIGNED, _VERTICES, _INDICES = 5126, 5125, 34962, 34963
#: Length for which the attenuation of a medium is stated [m]: about a glass.
_ATTENUATION = 0.1
#: From our world, z up, to glTF's, y up: a turn of -90 degrees about x, as glTF lists matrices, column by column.
_Y_UP = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
#: From glTF's camera axes to OpenCV's.
_FLIP = np.diag([1.0, -1.0, -1.0, 1.0])


class _File:
    """The lists of a glTF file, and its binary buffer."""

    def __init__(self) -> None:
        self.lists: dict[str, list[Any]] = {}
        self.buffer = bytearray()

    def add(self, name: str, entry: dict[str, Any]) -> int:
        """Append an entry to a list; return its number."""
        self.lists.setdefault(name, []).append(entry)
        return len(self.lists[name]) - 1

    def accessor(self, values: np.ndarray, target: int) -> int:
        """Store an array of float32 or uint32; return the number of its accessor."""
        kind = {1: "SCALAR", 3: "VEC3"}[1 if values.ndim == 1 else values.shape[1]]
        data = np.ascontiguousarray(values).tobytes()
        view = {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data), "target": target}
        self.buffer += data  # both types have 4 bytes, so all offsets are aligned
        entry: dict[str, Any] = {"bufferView": self.add("bufferViews", view), "count": len(values), "type": kind}
        entry["componentType"] = _FLOAT if values.dtype == np.float32 else _UNSIGNED
        if target == _VERTICES:
            entry |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return self.add("accessors", entry)

    def primitive(self, mesh: Mesh, material: int) -> dict[str, Any]:
        """Store a mesh; return a primitive."""
        attributes = {"POSITION": self.accessor(mesh.vertices, _VERTICES)}
        if mesh.normals is not None:
            attributes["NORMAL"] = self.accessor(mesh.normals, _VERTICES)
        indices = self.accessor(mesh.faces.ravel().astype(np.uint32), _INDICES)
        return {"attributes": attributes, "indices": indices, "material": material}

    def write(self, path: Path, roots: Sequence[int]) -> None:
        """Write the file; it appears whole or not at all."""
        extensions = sorted({name for item in self.lists.get("materials", []) for name in item.get("extensions", {})})
        head: dict[str, Any] = {"asset": {"version": "2.0", "generator": "glassware"}, "scene": 0}
        head |= {"scenes": [{"nodes": [*roots]}], "buffers": [{"byteLength": len(self.buffer)}]}
        head |= self.lists | ({"extensionsUsed": extensions} if extensions else {})
        text = compact_json(head).encode()
        text += b" " * (-len(text) % 4)
        size = 12 + 8 + len(text) + 8 + len(self.buffer)
        with atomic_file(path) as partial, partial.open("wb") as file:
            file.write(struct.pack("<III", _MAGIC, _VERSION, size))
            file.write(struct.pack("<II", len(text), _JSON) + text)
            file.write(struct.pack("<II", len(self.buffer), _BIN) + self.buffer)


def write_gltf(path: Path, scene: Scene, records: Sequence[ObjectRecord], ids: Sequence[int]) -> None:
    """Write a scene with some of its objects.

    Parameters
    ----------
    path : Path
        The file, ``.glb``.
    scene : Scene
        The scene.
    records : sequence of ObjectRecord
        ``objects.json``.
    ids : sequence of int
        The objects; the table is there in any case.
    """
    file = _File()
    table = file.add(
        "meshes",
        {"primitives": [file.primitive(scene.table.mesh, _opaque(file, scene.table.material, scene.table.mesh))]},
    )
    nodes = [file.add("nodes", {"name": "table", "mesh": table, "extras": {"id": 1}})]
    for item, record in zip(scene.objects, records, strict=True):
        if item.id in ids:
            nodes.append(_object(file, item, record))
    nodes += [_camera(file, camera, number) for number, camera in enumerate(scene.cameras)]
    root = file.add("nodes", {"name": "world", "matrix": _Y_UP, "children": nodes})
    file.write(path, [root])


def _object(file: _File, item: SceneObject, record: ObjectRecord) -> int:
    if isinstance(item, Prop):
        primitives, start = [], 0
        for piece in item.pieces:
            faces = item.mesh.faces[start : start + piece.faces]
            part = Mesh(item.mesh.name, item.mesh.vertices, faces, item.mesh.normals, colours=item.mesh.colours)
            primitives.append(file.primitive(part, _opaque(file, piece.material, part)))
            start += piece.faces
    else:
        primitives = [file.primitive(glass_solid(item), _medium(file, item.glass, item.roughness))]
        if item.liquid is not None:
            primitives.append(file.primitive(liquid_solid(item), _medium(file, item.liquid.medium, 0.0)))
    extras: dict[str, Any] = {"id": item.id, "category": item.category}
    if record.volumes is not None:
        extras["volumes"] = record.volumes.model_dump(mode="json")
    mesh = file.add("meshes", {"name": item.name, "primitives": primitives})
    matrix = np.asarray(item.world_T_object).T.ravel().tolist()
    return file.add("nodes", {"name": item.name, "mesh": mesh, "matrix": matrix, "extras": extras})


def _camera(file: _File, camera: Camera, number: int) -> int:
    """Add a left camera; glTF has no principal point, so the middle of the picture is taken."""
    name = f"view-{layout.view_name(number)}"
    lens = {
        "aspectRatio": camera.width * camera.fy / (camera.height * camera.fx),
        "yfov": 2.0 * float(np.arctan(0.5 * camera.height / camera.fy)),
        "znear": 0.01,
    }
    matrix = (np.asarray(camera.world_T_camera) @ _FLIP).T.ravel().tolist()
    entry = file.add("cameras", {"name": name, "type": "perspective", "perspective": lens})
    extras = {"K": camera.K.tolist(), "width": camera.width, "height": camera.height, "baseline": camera.baseline}
    return file.add("nodes", {"name": name, "camera": entry, "matrix": matrix, "extras": extras})


def _opaque(file: _File, material: OpaqueMaterial, mesh: Mesh) -> int:
    look = opaque_look(material, mesh)
    factors = {
        "baseColorFactor": [*look.colour, 1.0],
        "roughnessFactor": look.roughness,
        "metallicFactor": look.metallic,
    }
    return file.add("materials", {"name": look.name, "pbrMetallicRoughness": factors, "doubleSided": True})


def _medium(file: _File, medium: Medium, roughness: float) -> int:
    """Add a transparent material: alpha of GGX is the square of glTF's roughness."""
    passed = np.exp(-np.array(medium.sigma_a) * _ATTENUATION).tolist()
    extensions = {
        "KHR_materials_transmission": {"transmissionFactor": 1.0},
        "KHR_materials_ior": {"ior": medium.eta},
        "KHR_materials_volume": {
            "thicknessFactor": 1.0,
            "attenuationDistance": _ATTENUATION,
            "attenuationColor": passed,
        },
    }
    factors = {"baseColorFactor": [1.0, 1.0, 1.0, 1.0], "roughnessFactor": roughness**0.5, "metallicFactor": 0.0}
    return file.add("materials", {"name": medium.name, "pbrMetallicRoughness": factors, "extensions": extensions})


EXPORTER = scene_files("scenes: Blender, viewers", ".glb", write_gltf)
