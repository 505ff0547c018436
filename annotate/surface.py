"""The vertices of an object from which its keypoints and amodal boxes are computed."""

from __future__ import annotations

import itertools

import numpy as np

from ..procedural.description.scene import MeshVessel, Prop, SceneObject, Vessel


def hull_vertices(item: SceneObject) -> np.ndarray:
    """Return vertices with the convex hull of the object, object frame, (n, 3) float64 [m]."""
    if isinstance(item, Prop):
        return item.mesh.vertices.astype(np.float64)
    if isinstance(item, MeshVessel):
        return item.solid.vertices.astype(np.float64)
    return np.concatenate([i.mesh.vertices for i in item.interfaces if i.part == "outside"]).astype(np.float64)


def outside_vertices(item: SceneObject) -> np.ndarray:
    """Return the distinct vertices of an object's outside, object frame, (n, 3) float64 [m], sorted.

    The outside of a vessel is the outside of its glass: the vertices of its air|glass surface that are nearer to the
    outer profile than to the inner one. (The inside of an empty vessel is air|glass as well.) Of other glass bodies it
    is the whole air|glass surface, of a vessel from a file that of the glass without its liquid.
    """
    if isinstance(item, Prop):
        return np.unique(item.mesh.vertices, axis=0).astype(np.float64)
    vertices = np.unique(hull_vertices(item), axis=0)
    if not isinstance(item, Vessel):
        return vertices
    section = np.stack([np.hypot(vertices[:, 0], vertices[:, 1]), vertices[:, 2]], axis=1)
    outer, inner = (_distance(section, np.asarray(profile, np.float64)) for profile in (item.outer, item.inner))
    return vertices[outer < inner]


def _distance(points: np.ndarray, profile: np.ndarray) -> np.ndarray:
    """Return the distance of points, (n, 2), from a polyline, (m, 2): (n,) float64."""
    nearest = np.full(len(points), np.inf)
    for start, end in itertools.pairwise(profile):
        along = end - start
        length2 = float(along @ along)
        t = np.clip((points - start) @ along / length2, 0.0, 1.0) if length2 > 0.0 else np.zeros(len(points))
        nearest = np.minimum(nearest, np.linalg.norm(points - start - t[:, None] * along, axis=1))
    return nearest
