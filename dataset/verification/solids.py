"""Surfaces of objects as triangles, and how far points are from them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.mesh import Mesh
from ...procedural.description.scene import Prop, SceneObject

#: Solids of revolution and their mouths are true circles, and meshes polygons inside them [of the diagonal].
CHORD = 2e-3


def meshes_of(item: SceneObject) -> list[Mesh]:
    """Return all surfaces of an object."""
    return [item.mesh] if isinstance(item, Prop) else [part.mesh for part in item.interfaces]


def solid_meshes(item: SceneObject) -> list[Mesh]:
    """Return what closes an object's solid: without the surfaces of liquids and of what is in them."""
    if isinstance(item, Prop):
        return [item.mesh]
    return [part.mesh for part in item.interfaces if part.part in ("outside", "wet_wall")]


def triangles_of_meshes(meshes: Sequence[Mesh]) -> np.ndarray:
    """Return the corners of all triangles, (m, 3, 3) float64 [m]."""
    return np.concatenate([mesh.vertices.astype(np.float64)[mesh.faces] for mesh in meshes])


def diagonal(triangles: np.ndarray) -> float:
    """Return the diagonal of the box around triangles [m]."""
    return float(np.linalg.norm(np.ptp(triangles.reshape(-1, 3), axis=0)))


def worst_distance(triangles: np.ndarray, points: np.ndarray, within: float) -> float:
    """Return the largest distance of points, (n, 3), from triangles, (m, 3, 3); one above `within` is of one of them.

    Of a point that is near enough to a triangle, the triangle's box, widened by `within`, holds the point: distances
    to all triangles take seconds.
    """
    low, high = triangles.min(axis=1) - within, triangles.max(axis=1) + within
    boxed = np.ones((len(points), len(triangles)), bool)
    for axis in range(3):
        place = points[:, axis, None]
        boxed &= (place >= low[:, axis]) & (place <= high[:, axis])
    point, triangle = np.nonzero(boxed)
    away = np.full(len(points), np.inf)
    if len(point):
        np.minimum.at(away, point, _distances_in_pairs(triangles[triangle], points[point]))
    worst = int(np.argmax(away))
    if away[worst] <= within:
        return float(away[worst])
    return float(_distances_in_pairs(triangles, np.broadcast_to(points[worst], (len(triangles), 3))).min())


def _distances_in_pairs(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the distance of each point, (n, 3), from its triangle, (n, 3, 3): from the nearest edge, or the plane.

    Edges are segments, also where a triangle is so narrow that its plane is lost in rounding.
    """
    a, b, c = np.moveaxis(triangles, 1, 0)
    nearest = np.minimum.reduce([_from_segment(points, *ends) for ends in ((a, b), (b, c), (c, a))])
    normal = np.cross(b - a, c - a)
    over = np.ones(len(points), bool)
    for start, end in ((a, b), (b, c), (c, a)):
        over &= np.einsum("ki,ki->k", np.cross(end - start, points - start), normal) >= 0.0
    area = np.linalg.norm(normal, axis=1)
    over &= area > 0.0
    above = np.abs(np.einsum("ki,ki->k", points - a, normal)) / np.where(over, area, 1.0)
    return np.where(over, np.minimum(above, nearest), nearest)


def _from_segment(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    along = end - start
    length2 = np.einsum("ki,ki->k", along, along)
    part = np.einsum("ki,ki->k", points - start, along) / np.where(length2 > 0.0, length2, 1.0)
    return np.linalg.norm(points - start - np.clip(part, 0.0, 1.0)[:, None] * along, axis=1)
