"""Labels of the right camera, and what each camera of a pair sees of the points that the other one sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..procedural.description.camera import Camera
from ..procedural.description.scene import Scene
from ..render.frame import Eye, Frame, Geometry
from ..render.renderer import Renderer
from .keypoints import SURFACE_TOLERANCE, SceneKeypoints
from .labels import Labels, annotate
from .projection import disparity, transformed

#: How the other camera sees a point of this one, by its code: it sees it as well, a surface is in front of it, it is
#: outside of its picture, or there is no point.
BOTH, HIDDEN, OUTSIDE, NOTHING = range(4)


@dataclass(frozen=True, eq=False)
class PairVisibility:
    """How the other camera of a pair sees what is in each pixel of one: `BOTH`, `HIDDEN`, `OUTSIDE` or `NOTHING`."""

    first: np.ndarray  #: (H, W) uint8, the first surface: hidden where any surface is in front of it, glass included
    background: np.ndarray  #: (H, W) uint8, the first opaque surface: hidden where an opaque surface is in front of it


@dataclass(frozen=True, eq=False)
class StereoLabels:
    """What the right camera of a pair adds to a view's labels."""

    geometry: Geometry  #: of the right camera
    labels: Labels  #: of the right camera, in its own frame
    left: PairVisibility  #: of the left camera's pixels from the right camera
    right: PairVisibility  #: of the right camera's pixels from the left camera


def eye_camera(camera: Camera, eye: Eye) -> Camera:
    """Return the camera whose ``world_T_camera`` is the pose of one eye of a pair."""
    return camera if eye == "left" else camera.model_copy(update={"world_T_camera": camera.world_T_right})


def stereo_labels(scene: Scene, frame: Frame, renderer: Renderer, points: SceneKeypoints) -> StereoLabels:
    """Return the labels of a view's right camera, and the visibility of each camera's points from the other one.

    Parameters
    ----------
    scene : Scene
        The scene that the renderer was made of.
    frame : Frame
        A view that the renderer rendered.
    renderer : Renderer
        It traces the right camera's rays.
    points : SceneKeypoints
        From `keypoints.scene_keypoints`.
    """
    camera, geometry = scene.cameras[frame.view], renderer.geometry(frame.view, "right")
    sight = renderer.line_of_sight(frame.view, points.world.reshape(-1, 3), "right")
    return StereoLabels(
        geometry=geometry,
        labels=annotate(scene, eye_camera(camera, "right"), geometry, points, sight),
        left=_visibility(renderer, frame.view, frame.geometry, "left"),
        right=_visibility(renderer, frame.view, geometry, "right"),
    )


def _visibility(renderer: Renderer, view: int, geometry: Geometry, eye: Eye) -> PairVisibility:
    """Trace rays from the other eye to every point that this one sees, and that is in the other one's picture."""
    first, background = (
        np.where(np.isfinite(depth), OUTSIDE, NOTHING).astype(np.uint8) for depth in (geometry.Z, geometry.background_Z)
    )
    # The first surface of nine pixels of ten is opaque, so it is the background as well, and one ray tells both.
    same = np.equal(geometry.Z, geometry.background_Z)
    for depth, wanted in ((geometry.Z, first == OUTSIDE), (geometry.background_Z, (background == OUTSIDE) & ~same)):
        place, nothing_before, no_opaque_before = _sight(renderer, view, eye, depth, wanted)
        if depth is geometry.Z:
            first.ravel()[place] = np.where(nothing_before, BOTH, HIDDEN)
            place, no_opaque_before = place[same.ravel()[place]], no_opaque_before[same.ravel()[place]]
        background.ravel()[place] = np.where(no_opaque_before, BOTH, HIDDEN)
    return PairVisibility(first, background)


def _sight(
    renderer: Renderer, view: int, eye: Eye, depth: np.ndarray, wanted: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return which wanted pixels of an eye show a point that is in the other eye's picture, and what hides it there.

    Returns
    -------
    place : (n,) int
        The pixels, by their number in the picture.
    nothing_before, no_opaque_before : (n,) bool
        Whether no surface, and whether no opaque one, is between the point and the other eye.
    """
    camera = renderer.scene.cameras[view]
    other, towards = ("right", -1.0) if eye == "left" else ("left", 1.0)
    here, there = eye_camera(camera, eye), eye_camera(camera, other)
    place = np.flatnonzero(wanted)
    Z = depth.ravel()[place].astype(np.float64)
    row, column = np.divmod(place, camera.width)
    landing = column + towards * disparity(Z, camera.fx, camera.baseline)  # the row is the same
    inside = (landing >= -0.5) & (landing < camera.width - 0.5)
    place, Z = place[inside], Z[inside]
    (cx, cy), u, v = camera.centre, column[inside], row[inside]
    world = transformed(here.world_T_camera, np.stack([(u - cx) / camera.fx * Z, (v - cy) / camera.fy * Z, Z], axis=1))
    distance = np.linalg.norm(world - there.world_T_camera[:3, 3], axis=1) - SURFACE_TOLERANCE
    sight = renderer.line_of_sight(view, world, other)
    return place, sight.first_distance >= distance, sight.opaque_distance >= distance
