"""A scene in three dimensions, as few bytes: meshes of at most so many triangles, and clouds of so many points."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...annotate.projection import pixel_rays, transformed
from ...core.mesh import Mesh
from ...procedural.description.camera import Camera
from ...procedural.description.scene import Prop, Scene, SceneObject
from ..format.objects_file import ObjectRecord
from ..reader import StoredView
from .packing import packed

#: Most triangles of one surface [1]: a glass of 6,000 has facets of some 3 degrees.
MOST_TRIANGLES = 12_000
#: Most points of a view's cloud [1].
MOST_POINTS = 40_000
#: Cells along the longest side of a mesh that vertices are merged in, at first [1], and by how much they grow.
_CELLS, _COARSER = 256, 0.75
#: Steps of a vertex along each side of its mesh's box [1].
_STEPS = 65535


def scene_bodies(scene: Scene, records: tuple[ObjectRecord, ...]) -> list[dict[str, Any]]:
    """Return the table and the objects with pose, box and surfaces, as JSON records."""
    table = {"id": 1, "name": "table", "pose": np.eye(4).ravel().tolist(), "size": None}
    found = [table | {"surfaces": [_surface(scene.table.mesh, "opaque")]}]
    for item, record in zip(scene.objects, records, strict=True):
        found.append(
            {
                "id": item.id,
                "name": item.name,
                "pose": np.asarray(item.world_T_object).ravel().tolist(),
                "size": list(record.size),
                "keypoints": [list(point) for point in record.keypoints],
                "surfaces": [_surface(mesh, part) for mesh, part in _meshes(item)],
            }
        )
    return found


def view_points(view: StoredView, camera: Camera) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the first surfaces that a view sees, of evenly spaced pixels.

    Returns
    -------
    points : (n, 3) float64
        World frame [m].
    colours : (n, 3) uint8
        sRGB of the left picture.
    ids : (n,) uint16
        Instance ids.
    """
    geometry, picture = view.geometry(), view.picture()
    rows, columns = np.nonzero(np.isfinite(geometry.Z))
    step = max(1, -(-len(rows) // MOST_POINTS))
    rows, columns = rows[::step], columns[::step]
    rays = pixel_rays(picture.shape[0], picture.shape[1], camera.K)[rows, columns]
    points = transformed(camera.world_T_camera, rays * geometry.Z[rows, columns, None].astype(np.float64))
    return points, picture[rows, columns], geometry.id[rows, columns]


def view_cloud(view: StoredView, camera: Camera) -> dict[str, Any]:
    """Return the points of `view_points` as a JSON record."""
    points, colours, ids = view_points(view, camera)
    arrays = {"points": points.astype(np.float32).T, "colours": colours.T, "ids": ids[None]}
    return {name: packed(values) for name, values in arrays.items()}


def _meshes(item: SceneObject) -> Iterator[tuple[Mesh, str]]:
    """Yield the surfaces of an object with the part that each is."""
    if isinstance(item, Prop):
        yield item.mesh, "opaque"
        return
    for interface in item.interfaces:
        yield interface.mesh, "opaque" if interface.opaque is not None else interface.part


def _surface(mesh: Mesh, part: str) -> dict[str, Any]:
    vertices, faces = simplified(mesh, MOST_TRIANGLES)
    low = vertices.min(axis=0)
    step = max(float((vertices.max(axis=0) - low).max()) / _STEPS, 1e-9)
    steps = np.rint((vertices - low) / step).astype(np.uint16)
    return {
        "part": part,
        "low": low.tolist(),
        "step": step,
        "vertices": packed(steps.T),
        "faces": packed(faces.astype(np.uint32).reshape(1, -1)),
    }


def simplified(mesh: Mesh, most: int) -> tuple[np.ndarray, np.ndarray]:
    """Return at most so many triangles of a mesh: vertices in the same cell of a grid become their mean.

    Cells grow until few enough triangles have three different corners (Rossignac and Borrel 1993, "Multi-resolution 3D
    approximations for rendering complex scenes").

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    most : int
        Most triangles.

    Returns
    -------
    vertices : (n, 3) float64
        Object frame [m].
    faces : (m, 3) int64
    """
    vertices, faces = mesh.vertices.astype(np.float64), mesh.faces.astype(np.int64)
    low, size = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max())
    cells = float(_CELLS)
    found = _used(vertices, faces)
    while len(found[1]) > most:
        cell = np.floor((vertices - low) / size * cells).astype(np.int64)
        _, index, counts = np.unique(cell, axis=0, return_inverse=True, return_counts=True)
        index = index.ravel()
        means = np.stack([np.bincount(index, vertices[:, axis]) for axis in range(3)], axis=1) / counts[:, None]
        merged = index[faces]
        kept = (merged != np.roll(merged, 1, axis=1)).all(axis=1)
        found = _used(means, merged[kept])
        cells *= _COARSER
    return found


def _used(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices that faces use, those in the same place once, and the faces with their new numbers."""
    used, index = np.unique(vertices[faces.ravel()], axis=0, return_inverse=True)
    return used, index.reshape(-1, 3)
