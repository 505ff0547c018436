"""The records of a converted view: its camera, its labels, its row of the index."""

from __future__ import annotations

import numpy as np

from ...annotate.boxes import modal_box
from ..format import layout
from ..format.camera_file import CONVENTIONS, CameraFile
from ..format.partial_labels import PartialKeypoint, PartialLabels, PartialObject, symmetry_axes
from ..format.views_table import ViewRow
from ..readers.source_view import SourceKeypoints, SourceObject, SourceView

#: What differs from the conventions of rendered views.
_WORLD = "right-handed; that of the data set, whatever its axes"
_OWN_WORLD = "the left camera's frame: the data set states no pose of this camera"
_CONVENTIONS = CONVENTIONS | {
    "Z": "planar depth along the optical axis, metres; NaN where it is unknown",
    "colour": "PNG sRGB, as the data set has it",
}


def camera_record(view: SourceView) -> CameraFile:
    """Return the record of a view's cameras; what is unknown is null, and an unknown pose the identity."""
    camera, (height, width) = view.camera, view.picture.shape[:2]
    pose = np.eye(4) if camera.world_T_camera is None else camera.world_T_camera
    baseline = camera.baseline if view.right is not None else None
    shift = np.eye(4)
    shift[0, 3] = baseline or 0.0
    return CameraFile.model_validate(
        {
            "K": None if camera.K is None else tuple(tuple(row) for row in camera.K.tolist()),
            "width": width,
            "height": height,
            "world_T_camera": pose,
            "world_T_right": None if baseline is None else pose @ shift,
            "baseline": baseline,
            "exposure": None,
            "grid_index": None,
            "conventions": _CONVENTIONS | {"world": _OWN_WORLD if camera.world_T_camera is None else _WORLD},
        }
    )


def labels_record(name: str, view: SourceView) -> PartialLabels:
    """Return the labels of a view; boxes around visible pixels follow from the instances where there are any."""
    objects = view.objects
    return PartialLabels(
        source=name,
        objects=None if objects is None else tuple(_object(item, view.instances) for item in objects),
    )


def view_row(scene_id: int, view: int, source: SourceView, labels: PartialLabels) -> ViewRow:
    """Return the row of a view in the index; what is not labelled is null."""
    path = f"{layout.SCENES}/{layout.scene_name(scene_id)}/{layout.view_name(view)}"
    height, width = source.picture.shape[:2]
    objects = labels.objects or ()
    glass = [item.transparent for item in objects]
    stated = labels.objects is not None and None not in glass
    return ViewRow(
        scene_id=scene_id,
        view=view,
        seed=0,
        path=path,
        left=f"{path}/left.png",
        right=None if source.right is None or source.camera.baseline is None else f"{path}/right.png",
        width=width,
        height=height,
        grid_index=None,
        vessels=sum(map(bool, glass)) if stated else None,
        props=len(glass) - sum(map(bool, glass)) if stated else None,
        objects_in_view=sum(item.pixels is None or item.pixels > 0 for item in objects),
        object_ids=tuple(item.id for item in objects),
        visible_pixels=tuple(item.pixels for item in objects),
        visible_fractions=tuple(None for _ in objects),
        seen_through_fractions=tuple(None for _ in objects),
        spp_left=None,
        spp_right=None,
        noise_left=None,
        noise_right=None,
    )


def _object(item: SourceObject, instances: np.ndarray | None) -> PartialObject:
    mask = None if instances is None else instances == item.id
    symmetry = item.symmetry
    return PartialObject.model_validate(
        {
            "id": item.id,
            "name": item.name,
            "category": item.category,
            "transparent": item.transparent,
            "camera_T_object": item.camera_T_object,
            "pose_from": item.pose_from,
            "size": None if item.size is None else tuple(item.size.tolist()),
            "box2d": item.box if mask is None else modal_box(mask),
            "pixels": None if mask is None else int(mask.sum()),
            "keypoints": None if item.keypoints is None else _keypoints(item.keypoints),
            "symmetries_continuous": symmetry_axes(symmetry),
            "symmetries_discrete": None if symmetry is None else tuple(symmetry.motions[1:]),
        }
    )


def _keypoints(points: SourceKeypoints) -> tuple[PartialKeypoint, ...]:
    rows = zip(points.pixels.tolist(), points.Z.tolist(), points.visible.tolist(), strict=True)
    return tuple(PartialKeypoint(pixel=(u, v), Z=depth, visible=seen) for (u, v), depth, seen in rows)
