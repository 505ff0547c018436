"""The labels of a view, as ``labels.json`` holds them."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from ..core.arguments import check_type, whole_number
from ..core.errors import InputError
from ..core.model import Matrix4, Model, Vector3
from ..core.user_text import counted
from ..procedural.description.camera import Camera
from ..procedural.description.scene import Scene, SceneObject
from ..render.frame import Frame, Geometry, LineOfSight, PictureNoise
from ..render.renderer import Renderer
from .boxes import Box, amodal_box, box_corners, clipped_box, modal_box
from .keypoints import KeypointState, SceneKeypoints, keypoint_states, scene_keypoints
from .masks import Fractions, Pixels, count_pixels, encode_mask, fractions, instance_mask
from .order import Occlusion, occlusion_order
from .projection import inverse_pose, project_camera, transformed
from .surface import hull_vertices

LABELS_SCHEMA = "glassware/labels/1"

Pixel = tuple[float, float]


class Box2d(Model):
    """Boxes ``(left, top, right, bottom)`` [px]; a pixel extends half a pixel to each side of its coordinates."""

    modal: Box | None = Field(description="Around the visible pixels; null where none is visible")
    amodal: Box | None = Field(description="Around the projection of the whole object, also outside the picture")
    amodal_clipped: Box | None = Field(description="The amodal box clipped to the picture")


class Rle(Model):
    """A mask in COCO's compressed run-length encoding."""

    size: tuple[int, int] = Field(description="Height and width [px]")
    counts: str = Field(description="COCO's compressed counts, ASCII")


class Keypoint(Model):
    """A point on the object's surface, in the order of ``objects.json``."""

    pixel: Pixel | None = Field(description="Image coordinates (u, v) [px]; null behind the camera")
    Z: float = Field(description="Planar depth [m]")
    state: KeypointState


class Centroid(Model):
    """The centre of the object's bounding box, which is the origin of its frame."""

    point: Vector3 = Field(description="Camera frame [m]")
    pixel: Pixel | None = Field(description="Image coordinates (u, v) [px]; null behind the camera")


class ObjectLabel(Model):
    """One object in one view (the left camera's)."""

    id: int
    name: str
    category: str
    part_of: str | None = Field(
        default=None, exclude_if=lambda name: name is None, description="Name of the vessel that it goes with"
    )
    camera_T_object: Matrix4
    box2d: Box2d
    box3d: tuple[Vector3, ...] = Field(
        min_length=8, max_length=8, description="Corners, camera frame [m]; bits 0, 1, 2 of a corner's number: +x +y +z"
    )
    mask_amodal: Rle = Field(description="The whole silhouette in the frame")
    mask_seen: Rle = Field(description="The part that no opaque surface hides: visible or seen through glass")
    pixels: Pixels
    fractions: Fractions | None = Field(description="null where the silhouette is empty")
    keypoints: tuple[Keypoint, ...]
    centroid: Centroid


class Labels(Model):
    """All objects of a scene in one view, in the order of their ids."""

    schema_version: Literal["glassware/labels/1"] = LABELS_SCHEMA
    objects: tuple[ObjectLabel, ...]
    occlusion: tuple[Occlusion, ...] | None = Field(
        default=None, description="Which object is in front of which; null in data sets of earlier versions"
    )
    left: PictureNoise | None = Field(default=None, description="Of the left picture; null where none was rendered")
    right: PictureNoise | None = Field(default=None, description="Of the right picture")

    def __repr__(self) -> str:
        """Return one line: how many objects, and how many of them can be seen."""
        visible = sum(label.box2d.modal is not None for label in self.objects)
        return f"Labels({counted(len(self.objects), 'object')}, {visible} visible)"

    __str__ = __repr__


def label(scene: Scene, frame: Frame, renderer: Renderer, points: SceneKeypoints | None = None) -> Labels:
    """Return the labels of a rendered view's left camera.

    Parameters
    ----------
    scene : Scene
        The scene that the renderer was made of.
    frame : Frame
        A view that the renderer rendered.
    renderer : Renderer
        It traces the lines of sight to the keypoints.
    points : SceneKeypoints, optional
        From `keypoints.scene_keypoints`, which are the same in all views; they are computed where they are not given.

    Raises
    ------
    InputError
        Where the renderer was made of another scene, or the frame shows another one: picture and label would disagree.
    """
    check_type("label: scene", scene, Scene, "a Scene; the order is label(scene, frame, renderer)")
    check_type("label: frame", frame, Frame, "a Frame; the order is label(scene, frame, renderer)")
    check_type("label: renderer", renderer, Renderer, "a Renderer; the order is label(scene, frame, renderer)")
    if scene is not renderer.scene:
        raise InputError("label", f"the renderer's own scene, {renderer.scene!r}", f"another one, {scene!r}")
    if points is not None:
        check_type("label: points", points, SceneKeypoints, "keypoints, from scene_keypoints(scene)")
    _check_frame(scene, frame)
    points = points or scene_keypoints(scene)
    sight = renderer.line_of_sight(frame.view, points.world.reshape(-1, 3))
    return with_noise(annotate(scene, scene.cameras[frame.view], frame.geometry, points, sight), frame.sampling)


def _check_frame(scene: Scene, frame: Frame) -> None:
    """Refuse a frame that does not show a view of the scene."""
    if frame.scene is not None and frame.scene is not scene:
        raise InputError("label: frame", f"a frame of {scene!r}", f"one of another scene, {frame.scene!r}")
    view = whole_number("label: frame, view", frame.view, 0, len(scene.cameras) - 1)
    camera = scene.cameras[view]
    shape, count = (camera.height, camera.width), len(scene.objects)
    for name, found, expected in (
        ("pictures", frame.left.shape, (*shape, 3)),
        ("geometry", frame.geometry.id.shape, shape),
        ("silhouettes", frame.geometry.crossed.shape, (count, *shape)),
    ):
        if found != expected:
            raise InputError("label: frame", f"{name} of shape {expected}, as view {view} has them", found)


def with_noise(labels: Labels, sampling: tuple[PictureNoise, PictureNoise] | None) -> Labels:
    """Return the labels with what is known of the pictures' noise."""
    if sampling is None:
        return labels
    left, right = sampling
    return labels.model_copy(update={"left": left, "right": right})


def annotate(
    scene: Scene, camera: Camera, geometry: Geometry, points: SceneKeypoints, line_of_sight: LineOfSight
) -> Labels:
    """Return the ground-truth labels of one camera's view.

    Parameters
    ----------
    scene : Scene
        The scene.
    camera : Camera
        One of its cameras, or the right eye of one (`stereo.eye_camera`).
    geometry : Geometry
        Geometry along the rays through its pixel centres.
    points : SceneKeypoints
        From `keypoints.scene_keypoints`; all views share them.
    line_of_sight : LineOfSight
        Along the rays from the camera through ``points.world.reshape(-1, 3)``.
    """
    count = points.world.shape[1]
    expected = (len(scene.objects) * count,)
    first, opaque = (np.asarray(a) for a in (line_of_sight.first_distance, line_of_sight.opaque_distance))
    if first.shape != expected or opaque.shape != expected:
        raise ValueError(f"line of sight: expected shape {expected}, got {first.shape} and {opaque.shape}")
    camera_T_world = inverse_pose(camera.world_T_camera)
    labels = []
    for index, item in enumerate(scene.objects):
        rows = slice(index * count, (index + 1) * count)
        seen = transformed(camera_T_world, points.world[index])
        found = _keypoints(seen, first[rows], opaque[rows], camera)
        labels.append(_object_label(item, index, camera_T_world @ item.world_T_object, camera, geometry, found))
    return Labels(objects=tuple(labels), occlusion=occlusion_order(geometry, [item.id for item in scene.objects]))


def _object_label(
    item: SceneObject,
    index: int,
    camera_T_object: np.ndarray,
    camera: Camera,
    geometry: Geometry,
    found: tuple[Keypoint, ...],
) -> ObjectLabel:
    pixels = count_pixels(geometry, index, item.id)
    amodal = amodal_box(transformed(camera_T_object, hull_vertices(item)), camera.K)
    corners = transformed(camera_T_object, box_corners(item.size))
    return ObjectLabel(
        id=item.id,
        name=item.name,
        category=item.category,
        part_of=item.part_of,
        camera_T_object=camera_T_object,
        box2d=Box2d(
            modal=modal_box(instance_mask(geometry, item.id)),
            amodal=amodal,
            amodal_clipped=clipped_box(amodal, camera.width, camera.height),
        ),
        box3d=tuple(tuple(corner) for corner in corners.tolist()),
        mask_amodal=_rle(geometry.crossed[index]),
        mask_seen=_rle(geometry.reached[index]),
        pixels=pixels,
        fractions=fractions(pixels),
        keypoints=found,
        centroid=_centroid(camera_T_object[:3, 3], camera.K),
    )


def _keypoints(seen: np.ndarray, first: np.ndarray, opaque: np.ndarray, camera: Camera) -> tuple[Keypoint, ...]:
    pixels, Z = project_camera(seen, camera.K)
    states = keypoint_states(pixels, np.linalg.norm(seen, axis=1), first, opaque, (camera.width, camera.height))
    rows = zip(pixels, Z.tolist(), states, strict=True)
    return tuple(Keypoint(pixel=_pixel(pixel), Z=depth, state=state) for pixel, depth, state in rows)


def _centroid(point: np.ndarray, K: np.ndarray) -> Centroid:
    x, y, z = point.tolist()
    return Centroid(point=(x, y, z), pixel=_pixel(project_camera(point[None], K)[0][0]))


def _pixel(pixel: np.ndarray) -> Pixel | None:
    u, v = pixel.tolist()
    return None if np.isnan(u) else (u, v)


def _rle(mask: np.ndarray) -> Rle:
    height, width = mask.shape
    return Rle(size=(height, width), counts=encode_mask(mask))
