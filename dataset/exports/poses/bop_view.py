"""A view as BOP describes it: instances with poses, masks, counts and boxes (bop_toolkit, scripts/calc_gt_*.py)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....annotate.labels import ObjectLabel
from ....annotate.projection import inverse_pose, transformed
from ....procedural.description.camera import Camera
from ....render.frame import Geometry
from ...reader import StoredView
from ..depth import MM
from ..job import chosen_labels
from .bop_objects import BopObject
from .silhouette import wide_depth, wide_silhouette

#: Objects with a smaller visible fraction are to be ignored in `scene_gt_coco.json` (calc_gt_coco.py).
IGNORED_BELOW = 0.1
#: Of objects without a visible pixel.
_NO_BOX = [-1, -1, -1, -1]
#: A liquid that is this near behind the first surface is the first surface [m]: rounding of depth and meshes.
_SAME_SURFACE = 1e-4


@dataclass(frozen=True, eq=False)
class Instance:
    """An object in a view."""

    number: int  #: in `scene_gt.json`
    model: int  #: `obj_id`
    label: ObjectLabel
    points: np.ndarray  #: (n, 3) float, vertices in the camera frame [m]
    faces: np.ndarray
    whole: np.ndarray  #: (H, W) bool, silhouette
    visible: np.ndarray  #: (H, W) bool


def instances_of(objects: Sequence[BopObject], view: StoredView, camera: Camera, geometry: Geometry) -> list[Instance]:
    """Return the instances of a view, in the order of the objects.

    A solid object is visible where it is the first surface. Where liquids are objects of their own, a liquid is visible
    in its silhouette where its vessel is the first surface, glass or liquid; and the glass where the liquid is not the
    first surface.
    """
    labels = view.labels()
    rows = {label.id: row for row, label in enumerate(labels.objects)}
    by_id = {label.id: label for label in chosen_labels(labels, sorted({one.object_id for one in objects}), view)}
    depths: dict[int, np.ndarray] = {}
    found = []
    for number, one in enumerate(objects):
        label = by_id[one.object_id]
        points = transformed(np.array(label.camera_T_object), one.mesh.vertices.astype(np.float64))
        whole, own = geometry.crossed[rows[one.object_id]], geometry.id == one.object_id
        if one.liquid:
            depth = _inside(wide_depth(points, one.mesh.faces, camera.K, camera.width, camera.height), camera)
            depths[one.object_id] = np.minimum(depth, depths.get(one.object_id, np.inf))
            whole = np.isfinite(depth)
            own &= whole
        found.append(Instance(number, one.model, label, points, one.mesh.faces, whole, own))
    glass = {one.model for one in objects if not one.liquid and one.object_id in depths}
    return [_without_liquid(item, depths[item.label.id], geometry) if item.model in glass else item for item in found]


def _without_liquid(glass: Instance, depth: np.ndarray, geometry: Geometry) -> Instance:
    shown, both = glass.visible.copy(), np.isfinite(depth) & np.isfinite(geometry.Z)
    shown[both] &= np.abs(depth[both] - geometry.Z[both]) >= _SAME_SURFACE
    return replace(glass, visible=shown)


def gt_info(instance: Instance, camera: Camera, depth: np.ndarray) -> dict[str, Any]:
    """Return counts and boxes of an instance, as calc_gt_info.py defines them.

    `px_count_all` and `bbox_obj` count pixels outside the picture as well, on a canvas of three pictures by three.
    Boxes are (left, top, right - left, bottom - top) of pixel numbers: one less than the width in pixels.
    """
    whole = instance.whole
    origin = (0, 0)
    if _leaves_the_picture(instance.label, camera):
        canvas = wide_silhouette(instance.points, instance.faces, camera.K, camera.width, camera.height)
        _inside(canvas, camera)[:] = whole
        whole, origin = canvas, (camera.width, camera.height)
    total, visible = int(whole.sum()), int(instance.visible.sum())
    return {
        "px_count_all": total,
        "px_count_valid": int((instance.whole & (depth > 0)).sum()),
        "px_count_visib": visible,
        "visib_fract": visible / total if total else 0.0,
        "bbox_obj": box_of(whole, origin) if visible else _NO_BOX,
        "bbox_visib": box_of(instance.visible) if visible else _NO_BOX,
    }


def box_of(mask: np.ndarray, origin: tuple[int, int] = (0, 0)) -> list[int]:
    """Return left, top, right - left, bottom - top of a mask with pixels, as the toolkit's calc_2d_bbox does."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    left, top = int(columns[0]), int(rows[0])
    return [left - origin[0], top - origin[1], int(columns[-1]) - left, int(rows[-1]) - top]


def _leaves_the_picture(label: ObjectLabel, camera: Camera) -> bool:
    box = label.box2d.amodal
    if box is None:
        return True
    left, top, right, bottom = box
    return left < -0.5 or top < -0.5 or right > camera.width - 0.5 or bottom > camera.height - 0.5


def _inside(canvas: np.ndarray, camera: Camera) -> np.ndarray:
    """Return the picture's part of a canvas of three pictures by three."""
    return canvas[camera.height : 2 * camera.height, camera.width : 2 * camera.width]


def camera_record(camera: Camera, depth_scale: float) -> dict[str, Any]:
    """Return the entry of `scene_camera.json`."""
    camera_T_world = inverse_pose(np.array(camera.world_T_camera))
    return {
        "cam_K": camera.K.ravel().tolist(),
        "cam_R_w2c": camera_T_world[:3, :3].ravel().tolist(),
        "cam_t_w2c": (camera_T_world[:3, 3] * MM).tolist(),
        "depth_scale": depth_scale,
    }


def pose_record(instance: Instance) -> dict[str, Any]:
    """Return the entry of `scene_gt.json`."""
    camera_T_object = np.array(instance.label.camera_T_object)
    return {
        "cam_R_m2c": camera_T_object[:3, :3].ravel().tolist(),
        "cam_t_m2c": (camera_T_object[:3, 3] * MM).tolist(),
        "obj_id": instance.model,
    }


def coco_annotation(instance: Instance, info: dict[str, Any]) -> dict[str, Any]:
    """Return an annotation as calc_gt_coco.py writes it: here a box's width is the number of pixels."""
    left, top, across, down = box_of(instance.visible)
    return {
        "category_id": instance.model,
        "iscrowd": 0,
        "area": info["px_count_visib"],
        "bbox": [left, top, across + 1, down + 1],
        "segmentation": run_lengths(instance.visible),
        "ignore": info["visib_fract"] < IGNORED_BELOW,
    }


def run_lengths(mask: np.ndarray) -> dict[str, Any]:
    """Return a mask as the toolkit's run lengths: column by column, pixels outside first, not compressed."""
    edges = np.flatnonzero(np.diff(mask.ravel(order="F").astype(np.int8), prepend=0)).tolist()
    return {"counts": np.diff([0, *edges, mask.size]).tolist(), "size": list(mask.shape)}
