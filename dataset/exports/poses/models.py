"""Models of objects in millimetres, with the symmetries of each, as BOP has them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.distance import pdist

from ....core.errors import InputError
from ....core.mesh import Mesh, as_trimesh, joined
from ....procedural.description.scene import Prop, SceneObject
from ...format.objects_file import ObjectRecord
from ..depth import MM

#: Models are numbered by scene and object: scene 12, object 3 is model 12003.
OBJECTS_PER_SCENE = 1000


def model_id(scene_id: int, object_id: int) -> int:
    """Return the number of an object's model; it does not depend on what else is exported."""
    if object_id >= OBJECTS_PER_SCENE:
        raise InputError(f"scene {scene_id}", f"objects numbered below {OBJECTS_PER_SCENE}", object_id)
    return scene_id * OBJECTS_PER_SCENE + object_id


def model_mesh(item: SceneObject) -> Mesh:
    """Return the surface of an object in its frame, with normals [m]: of a vessel the glass, without the liquid."""
    if isinstance(item, Prop):
        return _with_normals(item.mesh)
    return _with_normals(
        joined([part.mesh for part in item.interfaces if part.part in ("outside", "wet_wall")], item.name)
    )


def scaled_mesh(mesh: Mesh) -> Mesh:
    """Return a mesh in millimetres, without texture coordinates."""
    return Mesh(mesh.name, mesh.vertices.astype(np.float64) * MM, mesh.faces, mesh.normals)


def model_info(mesh: Mesh, record: ObjectRecord) -> dict[str, Any]:
    """Return the entry of ``models_info.json``: extent, diameter and symmetries [mm]."""
    low, high = mesh.bounds * MM
    info: dict[str, Any] = {"diameter": _diameter(mesh.vertices.astype(np.float64)) * MM}
    for axis, name in enumerate("xyz"):
        info |= {f"min_{name}": float(low[axis]), f"size_{name}": float(high[axis] - low[axis])}
    if record.symmetries_discrete:
        info["symmetries_discrete"] = [_in_mm(motion) for motion in record.symmetries_discrete]
    if record.symmetries_continuous:
        info["symmetries_continuous"] = [
            {"axis": list(turn.axis), "offset": [value * MM for value in turn.offset]}
            for turn in record.symmetries_continuous
        ]
    return info | {"name": record.name, "category": record.category}


def _in_mm(motion: Any) -> Sequence[float]:
    scaled = np.array(motion, np.float64)
    scaled[:3, 3] *= MM
    return scaled.ravel().tolist()


def _with_normals(mesh: Mesh) -> Mesh:
    if mesh.normals is not None:
        return mesh
    merged = as_trimesh(mesh)
    return Mesh(mesh.name, merged.vertices, merged.faces, merged.vertex_normals)


def _diameter(vertices: np.ndarray) -> float:
    """Return the largest distance between two vertices; both are corners of the convex hull."""
    try:
        vertices = vertices[ConvexHull(vertices).vertices]
    except QhullError:  # all in a plane
        vertices = np.unique(vertices, axis=0)
    return float(pdist(vertices).max())
