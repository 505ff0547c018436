"""Checks of converted data sets: their files, and labels against each other.

There is no description to compare with: another project measured or rendered these views. What several of its labels
say must agree.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...annotate.boxes import amodal_box, box_corners, modal_box
from ...annotate.projection import transformed
from ...core.user_text import counted
from ..format import layout
from ..format.camera_file import CameraFile, known_K
from ..format.partial_labels import PartialObject
from ..format.views_table import scene_views
from ..reader import StoredScene, StoredView

#: How far an object's pixels may lie outside the projection of its box, as a fraction of the box's longer side, and in
#: pixels: masks and poses of people are off by some millimetres.
BOX_SLACK, BOX_PIXELS = 0.15, 4.0
#: Fraction of an object's pixels with a known depth that must lie at the depth of its box [1], and how far outside the
#: depth may be, as a fraction of the box's diagonal.
DEPTH_FRACTION, DEPTH_SLACK = 0.5, 0.5
#: Distance of a stated keypoint's depth from the object's centre, over the box's diagonal.
_KEYPOINT_REACH = 1.0
#: Greatest depth that is taken for metres [m].
_FARTHEST = 1000.0


def converted_scene_faults(stored: StoredScene) -> Iterator[str]:
    """Yield the faults of a converted scene's files: those that are missing, or contradict its index."""
    rows = {row.view: row for row in scene_views(stored.folder.parent.parent, stored.scene_id).views}
    if [view.number for view in stored.views] != sorted(rows) or not rows:
        yield f"{stored.folder}: expected the views of its index, found {[view.number for view in stored.views]}"
        return
    for view in stored.views:
        row, camera, labels = rows[view.number], view.camera_record(), view.partial_labels()
        size = (row.height, row.width)
        if (camera.height, camera.width) != size:
            yield f"{view.folder / layout.CAMERA}: expected {size} px as in the index, found others"
        pictures = ["left"] + ["right"] * (camera.baseline is not None)
        if (row.right is None) != (camera.baseline is None):
            yield f"{view.folder / layout.CAMERA}: expected a pair where the index has one, found otherwise"
        for eye in pictures:
            picture = view.picture("left" if eye == "left" else "right")
            if picture.shape[:2] != size:
                yield f"{view.folder / f'{eye}.png'}: expected {size} px, found {picture.shape[:2]}"
        for name, values in _maps(view):
            if values.shape != size:
                yield f"{view.folder / name}: expected {size} px, found {values.shape}"
        ids = [item.id for item in labels.objects or ()]
        if ids != list(row.object_ids):
            yield f"{view.folder / layout.LABELS}: expected the objects of the index, found {ids}"


def converted_label_faults(root: Path, scene_id: int) -> Iterator[str]:
    """Yield the faults of a converted scene's labels: where one contradicts another."""
    for view in StoredScene(layout.scene_folder(root, scene_id), scene_id).views:
        yield from (f"{view.folder}: {fault}" for fault in _view_faults(view))


def _maps(view: StoredView) -> Iterator[tuple[str, np.ndarray]]:
    for name, read in (
        (layout.GEOMETRY, view.depth),
        (layout.MEASURED_DEPTH, view.sensor_depth),
        (layout.INSTANCES, view.instances),
        (layout.CLASSES, view.classes),
    ):
        if (view.folder / name).is_file():
            yield name, read()


def _view_faults(view: StoredView) -> Iterator[str]:
    camera, labels, maps = view.camera_record(), view.partial_labels(), dict(_maps(view))
    yield from _pair_faults(camera)
    for name in (layout.GEOMETRY, layout.MEASURED_DEPTH):
        if name in maps:
            with np.errstate(invalid="ignore"):
                wrong = (maps[name] <= 0.0) | (np.isfinite(maps[name]) & (maps[name] > _FARTHEST))
            if wrong.any():
                yield f"{name}: expected depths above 0 and up to {_FARTHEST:g} m, found {maps[name][wrong][0]:g}"
    ids = maps.get(layout.INSTANCES)
    known = {0, 1, *(item.id for item in labels.objects or ())}
    if ids is not None and (unknown := sorted(set(np.unique(ids).tolist()) - known)):
        yield f"{layout.INSTANCES}: expected objects of {layout.LABELS}, found the id {unknown[0]}"
    for item in labels.objects or ():
        where = f"{layout.LABELS}: object {item.id}"
        mask = None if ids is None else ids == item.id
        if mask is not None and item.pixels != int(mask.sum()):
            yield f"{where} pixels: expected {int(mask.sum())}, found {item.pixels}"
        if mask is not None and item.box2d != modal_box(mask):
            yield f"{where} box2d: expected {modal_box(mask)} by {layout.INSTANCES}, found {item.box2d}"
        yield from (f"{where} {fault}" for fault in _pose_faults(item, camera, mask, maps.get(layout.GEOMETRY)))


def _pair_faults(camera: CameraFile) -> Iterator[str]:
    turn = np.asarray(camera.world_T_camera)[:3, :3]
    if np.abs(turn @ turn.T - np.eye(3)).max() > 1e-4 or np.linalg.det(turn) < 0.0:
        yield f"{layout.CAMERA}: world_T_camera: expected a rigid pose, found another matrix"
    if camera.baseline is None or camera.world_T_right is None:
        return
    expected = np.asarray(camera.world_T_camera) @ np.array(
        [[1, 0, 0, camera.baseline], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    )
    if np.abs(expected - camera.world_T_right).max() > 1e-9:
        yield f"{layout.CAMERA}: world_T_right: expected the left pose shifted by the baseline, found another"


def _pose_faults(
    item: PartialObject, camera: CameraFile, mask: np.ndarray | None, Z: np.ndarray | None
) -> Iterator[str]:
    if item.camera_T_object is None or item.size is None or camera.K is None:
        return
    pose, K = np.asarray(item.camera_T_object), np.array(known_K(camera, layout.CAMERA))
    corners = transformed(pose, box_corners(item.size))
    diagonal, box = float(np.linalg.norm(item.size)), amodal_box(corners, K)
    for number, point in enumerate(item.keypoints or ()):
        off = abs(point.Z - pose[2, 3]) / diagonal
        if off > _KEYPOINT_REACH:
            yield f"keypoint {number}: expected a depth near the object's, found one {off:.1f} diagonals away"
    if mask is None or not mask.any() or box is None:
        return
    found = modal_box(mask)
    assert found is not None
    slack = BOX_PIXELS + BOX_SLACK * max(box[2] - box[0], box[3] - box[1])
    outside = max(box[0] - found[0], box[1] - found[1], found[2] - box[2], found[3] - box[3])
    if outside > slack:
        shown = tuple(round(value, 1) for value in box)
        yield f"pose: expected its pixels {found} in the projection of its box {shown}, found {outside:.1f} px outside"
    if Z is None:
        return
    depth = Z[mask & np.isfinite(Z)]
    near, far = corners[:, 2].min() - DEPTH_SLACK * diagonal, corners[:, 2].max() + DEPTH_SLACK * diagonal
    if depth.size and ((depth >= near) & (depth <= far)).mean() < DEPTH_FRACTION:
        yield (
            f"depth: expected that of {counted(depth.size, 'pixel')} between {near:.3f} and {far:.3f} m by its box, "
            f"found a median of {np.median(depth):.3f} m"
        )
