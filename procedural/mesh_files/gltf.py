"""glTF 2.0 as meshes: the nodes of the scene with their transforms, and one part for each primitive."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from ...core.errors import InputError
from ..description.material import UniformTexture, VertexColours
from .gltf_file import BROKEN, Gltf, accessor, read_gltf, unreadable
from .gltf_material import look_of
from .model import FilePart, Source, check_counts

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_MODES = {0: "points", 1: "lines", 2: "lines", 3: "lines"}
#: Deepest nesting of nodes, and most nodes with meshes [1]: more is a mistake, or meant to exhaust memory.
_DEEPEST, _MOST_NODES = 256, 20_000


def read_gltf_parts(source: Source) -> list[FilePart]:
    """Return the parts of a GLB or glTF file, y up.

    Raises
    ------
    InputError
        Where the file cannot be read, requires an unknown extension, or has no triangles.
    """
    gltf = read_gltf(source)
    kind = source.path.suffix.lower()[1:].upper()
    try:
        placed = list(_placed_meshes(gltf))
        shapes = {number: _primitives(gltf, number) for number in dict.fromkeys(number for number, _ in placed)}
        faces = sum(len(part.faces) for number, _ in placed for part in shapes[number])
        check_counts(source.path, faces)
        parts = [part.moved(pose) for number, pose in placed for part in shapes[number]]
    except InputError:
        raise
    except BROKEN as error:
        raise InputError(source.path, f"a readable {kind} mesh", unreadable(error)) from error
    if not parts:
        raise InputError(source.path, "a mesh with faces", " ".join(["none", *source.notes.remarks]))
    return parts


def _placed_meshes(gltf: Gltf) -> Iterator[tuple[int, np.ndarray]]:
    """Yield the number of each mesh of the scene with its pose; one without a scene has all nodes without parents."""
    document = gltf.document
    nodes, scenes = document.get("nodes", []), document.get("scenes", [])
    if scenes:
        number = document.get("scene", 0)
        if not 0 <= number < len(scenes):
            raise ValueError(f"expected one of {len(scenes)} scenes, found number {number}")
        roots = scenes[number].get("nodes", [])
    else:
        children = {child for node in nodes for child in node.get("children", [])}
        roots = [number for number in range(len(nodes)) if number not in children]
    waiting, count, seen = [(number, np.eye(4), 0) for number in reversed(roots)], 0, set()
    while waiting:
        number, pose, depth = waiting.pop()
        if number in seen or depth > _DEEPEST or not 0 <= number < len(nodes):
            raise ValueError("expected a tree of nodes, found another graph")
        seen.add(number)
        node = nodes[number]
        pose = pose @ _transform(node)
        if "mesh" in node:
            count += 1
            if count > _MOST_NODES:
                raise ValueError(f"expected at most {_MOST_NODES} nodes with meshes")
            yield from ((node["mesh"], pose @ instance) for instance in _instances(gltf, node))
        waiting += [(child, pose, depth + 1) for child in reversed(node.get("children", []))]


def _transform(node: dict[str, Any]) -> np.ndarray:
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    return _pose(node.get("translation", (0, 0, 0)), node.get("rotation", (0, 0, 0, 1)), node.get("scale", (1, 1, 1)))


def _pose(translation: Any, rotation: Any, scale: Any) -> np.ndarray:
    """Return the transform of a translation, a quaternion (x, y, z, w) and a scale."""
    x, y, z, w = np.array(rotation, np.float64) / max(float(np.linalg.norm(rotation)), 1e-12)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, :3] *= np.array(scale, np.float64).reshape(1, 3)
    pose[:3, 3] = np.array(translation, np.float64).reshape(3)
    return pose


def _instances(gltf: Gltf, node: dict[str, Any]) -> list[np.ndarray]:
    """Return the poses of EXT_mesh_gpu_instancing; the node's own alone without it."""
    attributes = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes")
    if not attributes:
        return [np.eye(4)]
    columns = {name: accessor(gltf, number) for name, number in attributes.items()}
    count = min(len(values) for values in columns.values())
    if count > _MOST_NODES:
        raise ValueError(f"expected at most {_MOST_NODES} instances")
    still = {"TRANSLATION": (0, 0, 0), "ROTATION": (0, 0, 0, 1), "SCALE": (1, 1, 1)}
    return [
        _pose(*(columns[name][i] if name in columns else value for name, value in still.items())) for i in range(count)
    ]


def _primitives(gltf: Gltf, number: int) -> list[FilePart]:
    parts = []
    for primitive in gltf.document["meshes"][number]["primitives"]:
        mode = primitive.get("mode", _TRIANGLES)
        if mode in _MODES:
            gltf.source.notes.say(f"its {_MODES[mode]} have no surface and are left out")
        elif "POSITION" in primitive["attributes"]:
            part = _part(gltf, primitive, mode)
            parts += [part] if len(part.faces) else []
    return parts


def _part(gltf: Gltf, primitive: dict[str, Any], mode: int) -> FilePart:
    attributes = primitive["attributes"]
    places = accessor(gltf, attributes["POSITION"]).astype(np.float64)
    if "indices" in primitive:
        corners = accessor(gltf, primitive["indices"])[:, 0].astype(np.int64)
    else:
        corners = np.arange(len(places))
    if len(corners) and corners.max() >= len(places):
        raise InputError(gltf.source.path, f"faces over {len(places)} vertices", f"one with index {corners.max()}")
    look, uv_set, uv_T_uv = look_of(gltf, primitive.get("material"))
    uv = None
    if f"TEXCOORD_{uv_set}" in attributes:
        stored = accessor(gltf, attributes[f"TEXCOORD_{uv_set}"]).astype(np.float64)
        moved = stored @ uv_T_uv[:2, :2].T + uv_T_uv[:2, 2]
        uv = np.stack([moved[:, 0], 1.0 - moved[:, 1]], 1)  # v points down in glTF
    normals = accessor(gltf, attributes["NORMAL"]).astype(np.float64) if "NORMAL" in attributes else None
    part = FilePart(places, _faces(corners, mode), look, normals, uv)
    if "COLOR_0" in attributes:
        part = _coloured(gltf, part, accessor(gltf, attributes["COLOR_0"]))
    return part


def _faces(corners: np.ndarray, mode: int) -> np.ndarray:
    if mode == _TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if len(corners) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == _STRIP:
        faces = np.stack([corners[:-2], corners[1:-1], corners[2:]], 1)
        faces[1::2] = faces[1::2, [1, 0, 2]]
        return faces
    if mode == _FAN:
        return np.stack([np.full(len(corners) - 2, corners[0]), corners[1:-1], corners[2:]], 1)
    raise ValueError(f"expected a mode of 0 to 6, found {mode}")


def _coloured(gltf: Gltf, part: FilePart, stored: np.ndarray) -> FilePart:
    """Return the part with the colours of its vertices, times the factor of its material."""
    colours = np.clip(stored[:, :3].astype(np.float64), 0.0, 1.0)
    texture = part.look.texture
    fits = len(colours) == len(part.vertices) and np.isfinite(colours).all()
    if not fits or (colours == 1.0).all() or part.look.glass is not None:
        return part
    if texture is not None and not isinstance(texture, UniformTexture):
        gltf.source.notes.say("colours of vertices beside a picture are not used")
        return part
    factor = (1.0, 1.0, 1.0) if texture is None else texture.colour
    return replace(part, colours=colours * np.array(factor), look=replace(part.look, texture=VertexColours()))
