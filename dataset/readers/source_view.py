"""A view of another project's data set: what it has, and None for what it lacks.

Lengths are metres, camera axes OpenCV's (x right, y down, z forward), pixel (0, 0) has its centre at (0, 0): readers
bring every data set to these, whatever its files have.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...annotate.boxes import Box
from ...annotate.symmetries import Symmetry
from ...core.errors import InputError
from ..format.conversion import LABEL_KINDS, LabelKind, PoseSource

#: Id of the table, where a data set labels it, and of the first object.
TABLE, FIRST_OBJECT = 1, 2


@dataclass(frozen=True, eq=False)
class SourceCamera:
    """The left camera, and where the right one stands."""

    K: np.ndarray | None = None  #: (3, 3) float64 [px]; None: uncalibrated
    world_T_camera: np.ndarray | None = None  #: (4, 4) float64; None: unknown
    baseline: float | None = None  #: of a rectified pair, along the left camera's x [m]; None: no pair


@dataclass(frozen=True, eq=False)
class SourceKeypoints:
    """Keypoints of an object in a view, in the order of its data set."""

    pixels: np.ndarray  #: (k, 2) float64 [px]
    Z: np.ndarray  #: (k,) float64 [m]
    visible: np.ndarray  #: (k,) bool, as the data set states it


@dataclass(frozen=True, eq=False)
class SourceObject:
    """An object in a view."""

    id: int  #: as in `SourceView.instances`, from `FIRST_OBJECT`
    name: str
    category: str
    transparent: bool | None = None  #: None: not stated
    camera_T_object: np.ndarray | None = None  #: (4, 4) float64; with a `size` the origin is the centre of its box
    pose_from: PoseSource | None = None  #: where the pose comes from
    size: np.ndarray | None = None  #: (3,) float64, sides of its box [m]
    box: Box | None = None  #: around its visible pixels, where the data set states it
    keypoints: SourceKeypoints | None = None
    symmetry: Symmetry | None = None  #: None: not stated


@dataclass(frozen=True, eq=False)
class SourceView:
    """One picture, or a stereo pair, with its labels."""

    picture: np.ndarray  #: (H, W, 3) uint8, sRGB
    right: np.ndarray | None = None  #: likewise, of the right camera
    camera: SourceCamera = SourceCamera()
    Z: np.ndarray | None = None  #: (H, W) float32, true planar depth of the first surface [m]; NaN: unknown
    sensor_Z: np.ndarray | None = None  #: likewise, what a depth camera measured; NaN: nothing
    normals: np.ndarray | None = None  #: (H, W, 3) float32, unit normals facing the camera; NaN: unknown
    instances: np.ndarray | None = None  #: (H, W) uint16, ids; 0 is what no label names
    classes: np.ndarray | None = None  #: (H, W) uint16, classes of the pixels, which `Collection.classes` names
    objects: tuple[SourceObject, ...] | None = None  #: by ascending id


@dataclass(frozen=True, eq=False)
class Entry:
    """A view that has not been read yet."""

    name: str  #: in its data set, such as ``bottle_0/texture_5_pose_0/000001``
    scene: str  #: views with the same world frame and the same objects in it share it
    read: Callable[[], SourceView]  #: InputError where a file is damaged
    split: str | None = None  #: train, val or test, where the data set or its protocol says so


@dataclass(frozen=True)
class LeftOut:
    """A view or a file of a data set that cannot be used."""

    name: str
    reason: str


@dataclass(frozen=True, eq=False)
class Collection:
    """All views of a data set, found by the names of its files."""

    entries: tuple[Entry, ...]
    left_out: tuple[LeftOut, ...] = ()
    classes: tuple[str, ...] = ()  #: names of the values of `SourceView.classes`
    notes: tuple[str, ...] = ()  #: what is worth knowing, one line each


def kinds_of(view: SourceView) -> tuple[LabelKind, ...]:
    """Return what a view has, in the order of `LABEL_KINDS`."""
    camera, objects = view.camera, view.objects or ()
    found: dict[LabelKind, bool] = {
        "stereo": view.right is not None and camera.baseline is not None,
        "intrinsics": camera.K is not None,
        "camera-poses": camera.world_T_camera is not None,
        "depth": view.Z is not None,
        "sensor-depth": view.sensor_Z is not None,
        "normals": view.normals is not None,
        "instances": view.instances is not None,
        "classes": view.classes is not None,
        "objects": view.objects is not None,
        "poses": bool(objects) and all(item.camera_T_object is not None for item in objects),
        "sizes": bool(objects) and all(item.size is not None for item in objects),
        "keypoints": bool(objects) and all(item.keypoints is not None for item in objects),
        "symmetries": bool(objects) and all(item.symmetry is not None for item in objects),
    }
    return tuple(kind for kind in LABEL_KINDS if found[kind])


def check_view(view: SourceView, where: object) -> SourceView:
    """Return a view whose maps have the size of its picture; InputError where one has another."""
    size = view.picture.shape[:2]
    if view.right is not None and view.right.shape != view.picture.shape:
        expected = f"two eyes of one size, {size[1]} x {size[0]} px as the left one"
        raise InputError(where, expected, f"{view.right.shape[1]} x {view.right.shape[0]} px in the right one")
    for name in ("Z", "sensor_Z", "normals", "instances", "classes"):
        values = getattr(view, name)
        if values is not None and values.shape[:2] != size:
            found = f"{values.shape[1]} x {values.shape[0]} px"
            raise InputError(f"{where}: {name}", f"{size[1]} x {size[0]} px, as its picture has", found)
    return view
