"""Ground truth of a converted view: what another project labels, as networks learn it.

Pixels without a label count as background, the table too where a data set does not label it. Unknown depths have no
target.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...annotate.boxes import box_corners
from ...annotate.projection import inverse_pose, transformed
from ...annotate.symmetries import ASYMMETRIC
from ...core.errors import InputError
from ...dataset.format import layout
from ...dataset.format.conversion import Conversion, LabelKind
from ...dataset.format.partial_labels import PartialObject, stored_symmetry
from ...dataset.reader import StoredView
from ..targets.objects import ViewObject, canonical_pose
from .ground_truth import MAX_LENGTH, GroundTruth
from .views import check_rigid

#: What a network of ours learns, in the words of an error line.
_NEEDED: dict[LabelKind, str] = {
    "intrinsics": "calibrated cameras",
    "instances": "instances of objects",
    "objects": "objects",
    "poses": "poses of objects",
    "sizes": "sizes of objects",
}


def check_learnable(root: Path, record: Conversion, rule: str) -> None:
    """Refuse a converted data set that lacks what networks learn, or what the views of a sample need.

    Parameters
    ----------
    root : Path
        The data set.
    record : Conversion
        ``converted`` of its head.
    rule : str
        Rule by which source views are chosen (`ViewSettings`).
    """
    needed = dict(_NEEDED)
    if rule == "stereo":
        needed["stereo"] = "stereo pairs (views.rule is stereo)"
    else:
        needed["camera-poses"] = f"poses of cameras (views.rule is {rule})"
    missing = [text for kind, text in needed.items() if record.has.get(kind, 0) < record.views]
    if missing:
        listed = f"{', '.join(missing[:-1])} and {missing[-1]}" if missing[1:] else missing[0]
        raise InputError(root, f"{listed} in every view", f"{record.title}, which has {', '.join(record.has)}")


def read_partial_truth(view: StoredView, record: Conversion, size: tuple[int, int]) -> GroundTruth:
    """Return the labels of a converted view; InputError with file and field where one is missing or wrong.

    Parameters
    ----------
    view : StoredView
        The view.
    record : Conversion
        ``converted`` of the data set's head, of which `check_learnable` is true.
    size : (int, int)
        Height and width of its images [px].
    """
    where, labels = view.folder / layout.LABELS, view.partial_labels()
    instances = view.instances()
    Z = view.depth() if (view.folder / layout.GEOMETRY).is_file() and "depth" in record.has else None
    Z = np.full(size, np.inf, np.float32) if Z is None else np.where(np.isnan(Z), np.float32(np.inf), Z)
    for name, values in ((layout.INSTANCES, instances), (layout.GEOMETRY, Z)):
        if values.shape != size:
            raise InputError(view.folder / name, f"{size[0]} x {size[1]} px", values.shape)
    if not ((Z > 0.0) & ((Z <= MAX_LENGTH) | np.isposinf(Z))).all():
        raise InputError(view.folder / layout.GEOMETRY, f"depths above 0 and up to {MAX_LENGTH:g} m", "others")
    objects = tuple(_object(item, instances, f"{where}: object {item.id}") for item in labels.objects or ())
    keypoints = {item.id: _keypoints(item, view) for item in labels.objects or ()}
    return GroundTruth(instances, Z, objects, keypoints)


def box_depths(labels: GroundTruth) -> np.ndarray:
    """Return the depths of the corners of the objects' boxes [m], for data sets without depth maps."""
    found = [item.corners[:, 2] for item in labels.objects]
    if not found:
        raise InputError("depth range", "an object with a box, as the data set has no depth", "none")
    return np.concatenate(found)


def _object(item: PartialObject, instances: np.ndarray, where: str) -> ViewObject:
    if item.camera_T_object is None or item.size is None:
        raise InputError(where, "a pose and a size", "null")
    if item.transparent is None:
        expected = "whether it is transparent (convert again with --transparent)"
        raise InputError(f"{where} transparent", expected, "null: the data set does not say")
    pose = np.array(item.camera_T_object)
    check_rigid(pose, f"{where} camera_T_object")
    symmetry = stored_symmetry(item) or ASYMMETRIC
    return ViewObject(
        id=item.id,
        category=item.category,
        transparent=item.transparent,
        symmetry=symmetry,
        fill=None,
        camera_T_object=canonical_pose(pose, symmetry),
        size=np.array(item.size),
        visible=int((instances == item.id).sum()),
    )


def _keypoints(item: PartialObject, view: StoredView) -> np.ndarray:
    """Return the keypoints of an object in its frame, (k, 3) float64 [m]; corners of its box where it has none."""
    if item.keypoints is None or item.camera_T_object is None:
        return box_corners(item.size) if item.size is not None else np.zeros((0, 3))
    K = np.array(view.camera_record().K, np.float64)
    pixels = np.array([[*point.pixel, 1.0] for point in item.keypoints])
    points = pixels @ np.linalg.inv(K).T * np.array([[point.Z] for point in item.keypoints])
    return transformed(inverse_pose(np.asarray(item.camera_T_object)), points)
