"""Ground truth of a reference view: instance ids, depth, objects with poses, keypoints."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...annotate.labels import ObjectLabel
from ...annotate.surface import surface_points
from ...annotate.symmetries import Symmetry
from ...core.errors import InputError
from ...core.randomness import stream
from ...dataset.format import layout
from ...dataset.format.exr import read_channel
from ...dataset.format.objects_file import ObjectRecord, ObjectsFile
from ...dataset.format.pictures import read_png
from ...dataset.reader import StoredView
from ...procedural.description.scene import TABLE_ID, Scene
from ...procedural.description.surroundings import FIRST_ROOM_ID
from ..targets.objects import ViewObject, canonical_pose
from .views import check_rigid

#: Greatest depth and longest side of a label [m]: larger values are not in metres.
MAX_LENGTH = 1000.0
#: Points of an object's surface for ADD and ADD-S: means over them are within 1 % of those over many more.
SURFACE_POINTS = 2000
#: Id of pixels without a surface.
_BACKGROUND_ID = 0
#: Axes of revolution of an object: z, and another one for a ball.
_AXES = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """The labels of a view."""

    instances: np.ndarray  #: (H, W) uint16, instance ids of the first surface
    Z: np.ndarray  #: (H, W) float32 [m]; +inf for none
    objects: tuple[ViewObject, ...]
    keypoints: dict[int, np.ndarray]  #: by object id, (k, 3) float64 in the object frame [m]
    surface: dict[int, np.ndarray] = field(default_factory=dict)  #: points of the surface likewise, where asked for


def read_ground_truth(view: StoredView, objects: ObjectsFile, size: tuple[int, int]) -> GroundTruth:
    """Return the labels of a view; InputError with file and field where one is missing or wrong.

    Parameters
    ----------
    view : StoredView
        The view.
    objects : ObjectsFile
        The objects of its scene.
    size : (int, int)
        Height and width of its images [px].
    """
    path = view.folder / layout.GEOMETRY
    Z = read_channel(path, "Z")
    instances = read_png(view.folder / layout.INSTANCES)
    for name, values in ((layout.GEOMETRY, Z), (layout.INSTANCES, instances)):
        if values.shape != size:
            raise InputError(view.folder / name, f"{size[0]} x {size[1]} px", values.shape)
    wrong = ~(Z > 0.0) | ((Z > MAX_LENGTH) & ~np.isposinf(Z))  # NaN as well
    if wrong.any():
        found = f"{Z[wrong][0]:g} in {int(wrong.sum())} pixels"
        raise InputError(f"{path}: Z", f"depths above 0 and up to {MAX_LENGTH:g} m, or +inf for none", found)
    records = {record.id: record for record in objects.objects}
    labels = view.labels().objects
    numbers = [label.id for label in labels]
    if len(set(numbers)) < len(numbers):
        raise InputError(view.folder / layout.LABELS, "each object once", sorted(numbers))
    for label in labels:
        if label.id not in records:
            where = view.folder.parent / layout.OBJECTS
            raise InputError(where, f"an object {label.id}, which {layout.LABELS} has", f"{sorted(records)}")
    # A room is surroundings to a network, whether it is a map at infinity or has walls with a depth.
    surroundings = instances >= FIRST_ROOM_ID
    if surroundings.any():
        instances, Z = np.where(surroundings, _BACKGROUND_ID, instances), np.where(surroundings, np.inf, Z)
    counts = np.bincount(instances.ravel(), minlength=1 << 16)
    found = tuple(_object(records[label.id], label, int(counts[label.id]), view) for label in labels)
    known = {_BACKGROUND_ID, TABLE_ID, *(item.id for item in found)}
    unknown = sorted(set(np.flatnonzero(counts).tolist()) - known)
    if unknown:
        raise InputError(view.folder / layout.LABELS, f"an object {unknown[0]}, which {layout.INSTANCES} has", "none")
    keypoints = {record.id: np.array(record.keypoints, np.float64).reshape(-1, 3) for record in objects.objects}
    return GroundTruth(instances, Z, found, keypoints)


def scene_surface_points(scene: Scene) -> dict[int, np.ndarray]:
    """Return points of the surface of each object of a scene, by id, (`SURFACE_POINTS`, 3) in its frame [m]."""
    rng = stream(scene.seed, scene.scene_id, "learn/surface-points")
    return {item.id: surface_points(item, SURFACE_POINTS, rng) for item in scene.objects}


def _object(record: ObjectRecord, label: ObjectLabel, visible: int, view: StoredView) -> ViewObject:
    symmetry = _symmetry(record, view.folder.parent / layout.OBJECTS)
    pose = np.array(label.camera_T_object)
    check_rigid(pose, f"{view.folder / layout.LABELS}: object {label.id} camera_T_object")
    if not all(0.0 < side < MAX_LENGTH for side in record.size):
        where = f"{view.folder.parent / layout.OBJECTS}: object {record.id} size"
        raise InputError(where, f"sides above 0 and up to {MAX_LENGTH:g} m", record.size)
    return ViewObject(
        id=record.id,
        category=record.category,
        transparent=record.material.kind == "glass",
        symmetry=symmetry,
        fill=None if record.liquid is None else record.liquid.fill,
        camera_T_object=canonical_pose(pose, symmetry),
        size=np.array(record.size),
        visible=visible,
    )


def _symmetry(record: ObjectRecord, path: Path) -> Symmetry:
    """Return the symmetry of an object's record: revolution about z, of a ball, and single motions."""
    where = f"{path}: object {record.id} symmetries"
    axes = [(axis.axis, axis.offset) for axis in record.symmetries_continuous]
    for axis, offset in axes:
        if tuple(map(abs, axis)) not in _AXES or any(o for a, o in zip(axis, offset, strict=True) if not a):
            raise InputError(
                f"{where}_continuous", "the z axis of the object, or x and z of a ball", f"{axis}, {offset}"
            )
    known = {tuple(map(abs, axis)) for axis, _ in axes}
    if known and _AXES[0] not in known:
        raise InputError(f"{where}_continuous", "the z axis of the object", axes[0])
    motions = [np.eye(4), *(np.array(motion) for motion in record.symmetries_discrete)]
    for motion in motions:
        check_rigid(motion, f"{where}_discrete")
    return Symmetry(turns=bool(known), ball=len(known) > 1, motions=np.stack(motions))
