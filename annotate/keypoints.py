"""Keypoints of objects, and their visibility from a camera.

Keypoints are chosen by farthest-point sampling of the surface (Peng et al., "PVNet: Pixel-wise Voting Network for 6DoF
Pose Estimation", CVPR 2019, section 3.1), which spreads them over the object and keeps them on it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import trimesh

from ..procedural.description.scene import Prop, Scene, SceneObject, Vessel, glass_solid
from .projection import inside_picture, transformed
from .surface import outside_vertices

#: PVNet's choice after its ablation over 4, 8 and 12 points (table 3 there).
KEYPOINT_COUNT = 8
#: A surface nearer than a keypoint by less than this is the keypoint's own [m]. Positions are float32: at 2 m the error
#: of a ray's length is below 1e-6 m, and some tens of times larger at grazing angles. The thinnest wall of a vessel is
#: several times this, so the two sides of a wall are never confused.
SURFACE_TOLERANCE = 1e-4

KeypointState = Literal["visible", "through_glass", "occluded", "outside"]


@dataclass(frozen=True, eq=False)
class SceneKeypoints:
    """Keypoints of all objects of a scene; row ``i`` belongs to ``scene.objects[i]``."""

    local: np.ndarray  #: (n, k, 3) float64, object frames [m]
    world: np.ndarray  #: (n, k, 3) float64, world frame [m]


def keypoints(item: SceneObject, count: int = KEYPOINT_COUNT) -> np.ndarray:
    """Return farthest-point keypoints on an object's outside.

    The first is the vertex farthest from the frame's origin (the centre of the bounding box); each further one is the
    vertex farthest from all before. Ties go to the first in the order of coordinates, so the choice depends only on the
    surface and not on the order of its vertices.

    Parameters
    ----------
    item : GlassBody or Prop
        The object; of a glass body, the outside of the glass.
    count : int
        Number of keypoints.

    Returns
    -------
    (count, 3) float64
        Points in the object frame [m]: vertices of the mesh and, where it has fewer than ``count``, midpoints of its
        edges.
    """
    candidates = _candidates(item, count)
    chosen = [int(np.argmax(np.linalg.norm(candidates, axis=1)))]
    nearest = np.full(len(candidates), np.inf)
    while len(chosen) < count:
        nearest = np.minimum(nearest, np.linalg.norm(candidates - candidates[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(nearest)))
    return candidates[chosen]


def _candidates(item: SceneObject, count: int) -> np.ndarray:
    candidates = outside_vertices(item)
    if len(candidates) >= count or isinstance(item, Vessel):
        return candidates
    mesh = item.mesh if isinstance(item, Prop) else glass_solid(item)
    vertices, faces = mesh.vertices.astype(np.float64), mesh.faces
    while len(candidates) < count:
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)[:2]
        candidates = np.unique(vertices, axis=0)
    return candidates


def scene_keypoints(scene: Scene, count: int = KEYPOINT_COUNT) -> SceneKeypoints:
    """Return the keypoints of every object of a scene; all views share them."""
    local = [keypoints(item, count) for item in scene.objects]
    world = [transformed(item.world_T_object, points) for item, points in zip(scene.objects, local, strict=True)]
    shape = (len(local), count, 3)
    return SceneKeypoints(np.reshape(local, shape), np.reshape(world, shape))


def keypoint_states(
    pixels: np.ndarray,
    distance: np.ndarray,
    first_distance: np.ndarray,
    opaque_distance: np.ndarray,
    size: tuple[int, int],
) -> list[KeypointState]:
    """Return the visibility of points on surfaces from a camera.

    Parameters
    ----------
    pixels : (n, 2) float
        Image coordinates [px]; NaN behind the camera.
    distance : (n,) float
        Distance of each point from the camera [m].
    first_distance, opaque_distance : (n,) float
        Distance along the straight ray to the first surface, and to the first opaque one [m]; +inf for none. The
        point's own surface counts.
    size : (int, int)
        Width and height of the picture [px].

    Returns
    -------
    list of str
        ``outside`` the picture or behind the camera; else ``visible`` where no surface is in front of the point;
        ``through_glass`` where only transparent surfaces are; else ``occluded``.
    """
    inside = inside_picture(pixels, *size)
    first = first_distance >= distance - SURFACE_TOLERANCE
    through = opaque_distance >= distance - SURFACE_TOLERANCE
    rows = zip(inside, first, through, strict=True)
    return [_state(*row) for row in rows]


def _state(inside: bool, first: bool, through: bool) -> KeypointState:
    if not inside:
        return "outside"
    if first:
        return "visible"
    return "through_glass" if through else "occluded"
