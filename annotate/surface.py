"""Points of an object: vertices for keypoints and amodal boxes, and a uniform sample of its surface."""

from __future__ import annotations

import itertools

import numpy as np

from ..procedural.description.scene import MeshVessel, Prop, SceneObject, Vessel, glass_solid


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


def surface_points(item: SceneObject, count: int, rng: np.random.Generator) -> np.ndarray:
    """Return points on an object's surface, object frame, (count, 3) float64 [m], uniform by area.

    Of a glass body they are on the glass, inside and outside, whatever is in it.

    Parameters
    ----------
    item : GlassBody or Prop
        The object.
    count : int
        Number of points.
    rng : numpy.random.Generator
        Source of randomness.
    """
    mesh = item.mesh if isinstance(item, Prop) else glass_solid(item)
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1)
    chosen = corners[rng.choice(len(corners), count, p=area / area.sum())]
    # Turk, "Generating Random Points in Triangles", Graphics Gems, 1990: sqrt makes them uniform.
    root, along = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
    return (1.0 - root) * chosen[:, 0] + root * (1.0 - along) * chosen[:, 1] + root * along * chosen[:, 2]


def _distance(points: np.ndarray, profile: np.ndarray) -> np.ndarray:
    """Return the distance of points, (n, 2), from a polyline, (m, 2): (n,) float64."""
    nearest = np.full(len(points), np.inf)
    for start, end in itertools.pairwise(profile):
        along = end - start
        length2 = float(along @ along)
        t = np.clip((points - start) @ along / length2, 0.0, 1.0) if length2 > 0.0 else np.zeros(len(points))
        nearest = np.minimum(nearest, np.linalg.norm(points - start - t[:, None] * along, axis=1))
    return nearest
