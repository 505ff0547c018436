"""What a page shows of a scene of a converted data set: pictures, the maps that it has, boxes, poses and points."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...annotate.boxes import EDGES
from ...annotate.projection import transformed
from ...core.images import id_colour
from ...render.frame import Eye
from ..format import layout
from ..format.camera_file import CameraFile
from ..format.conversion import LABEL_KINDS, Conversion
from ..format.partial_labels import PartialObject
from ..reader import StoredView
from .bodies import MOST_POINTS
from .choice import Choice
from .packing import packed
from .shapes import box_sides, pixel_lists, segments

#: Names of a keypoint's states: other data sets say whether it is visible, and no more.
_STATES = {True: "visible", False: "occluded"}


def converted_scene(choice: Choice) -> dict[str, Any]:
    """Return a scene as a JSON record: objects with a pose in the first view that has it, and all cameras."""
    found: dict[int, tuple[StoredView, PartialObject]] = {}
    for view in choice.views:
        for item in view.partial_labels().objects or ():
            known = found.get(item.id)
            if known is None or (known[1].camera_T_object is None and item.camera_T_object is not None):
                found[item.id] = view, item
    bodies = [_body(view, item) for view, item in found.values() if item.camera_T_object is not None]
    names = {number: item.name for number, (_, item) in found.items()}
    return {
        "bodies": bodies,
        "cameras": [_pair(view.camera_record()) for view in choice.views],
        "colours": {number: id_colour(number) for number in (1, *names)},
        "names": names,
        "objects": [{"id": number, "cells": _cells(item)} for number, (_, item) in found.items()],
        "target": _middle(choice.views[0]),
    }


def converted_shapes(view: StoredView) -> list[dict[str, Any]]:
    """Return what is drawn of each object on the left picture, as JSON records."""
    K = view.camera_record().K
    return [_shape(item, None if K is None else np.array(K)) for item in view.partial_labels().objects or ()]


def converted_cloud(view: StoredView) -> dict[str, Any] | None:
    """Return the points of the true depth in the world, evenly spaced; None where depth or calibration is missing."""
    record = view.camera_record()
    if record.K is None or not view.has_depth():
        return None
    Z = view.depth()
    rows, columns = np.nonzero(np.isfinite(Z))
    step = max(1, -(-len(rows) // MOST_POINTS))
    rows, columns = rows[::step], columns[::step]
    local = _points(np.array(record.K), np.stack([columns, rows], axis=1), Z[rows, columns])
    points = transformed(record.world_T_camera, local).astype(np.float32)
    ids = view.instances() if (view.folder / layout.INSTANCES).is_file() else np.zeros(Z.shape, np.uint16)
    arrays = {"points": points.T, "colours": view.picture()[rows, columns].T, "ids": ids[rows, columns][None]}
    return {name: packed(values) for name, values in arrays.items()}


def lacking(record: Conversion) -> list[str]:
    """Return the kinds of labels that no view of a data set has."""
    return [kind.replace("-", " ") for kind in LABEL_KINDS if kind not in record.has]


def _body(view: StoredView, item: PartialObject) -> dict[str, Any]:
    pose = np.asarray(view.camera_record().world_T_camera) @ np.asarray(item.camera_T_object)
    size = None if item.size is None else list(item.size)
    return {"id": item.id, "name": item.name, "pose": pose.ravel().tolist(), "size": size, "surfaces": []}


def _pair(record: CameraFile) -> dict[Eye, dict[str, Any] | None]:
    poses: dict[Eye, Any] = {"left": record.world_T_camera, "right": record.world_T_right}
    return {eye: None if pose is None else _pinhole(record, pose) for eye, pose in poses.items()}


def _pinhole(record: CameraFile, pose: np.ndarray) -> dict[str, Any] | None:
    if record.K is None:
        return None
    size = {"width": record.width, "height": record.height}
    return size | {"K": [list(row) for row in record.K], "pose": np.asarray(pose).ravel().tolist()}


def _middle(view: StoredView) -> list[float] | None:
    """Return the point about which a view from outside turns: the middle of what the first view sees, in the world."""
    record = view.camera_record()
    if record.K is None:
        return None
    centre = np.array([[(record.width - 1) / 2, (record.height - 1) / 2]])
    Z = view.depth() if view.has_depth() else np.ones(1)
    known = Z[np.isfinite(Z)]
    depth = float(np.median(known)) if known.size else 1.0
    return transformed(record.world_T_camera, _points(np.array(record.K), centre, np.array([depth])))[0].tolist()


def _points(K: np.ndarray, pixels: np.ndarray, Z: np.ndarray) -> np.ndarray:
    """Return the points of pixels (u, v) at depths, camera frame, (n, 3) float64 [m]."""
    rays = np.concatenate([pixels, np.ones((len(pixels), 1))], axis=1) @ np.linalg.inv(K).T
    return rays * Z[:, None].astype(np.float64)


def _shape(item: PartialObject, K: np.ndarray | None) -> dict[str, Any]:
    edges, axes = _box_lines(item, K)
    keypoints = [[*pixel_lists([point.pixel])[0], _STATES[point.visible]] for point in item.keypoints or ()]
    box = box_sides(item.box2d)
    centre = None if box is None else [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2]
    shape = {"id": item.id, "modal": box, "amodal": None, "edges": edges, "axes": axes, "keypoints": keypoints}
    return shape | {"centre": centre, "silhouette": [], "fractions": None}


def _box_lines(item: PartialObject, K: np.ndarray | None) -> tuple[list[Any], list[Any]]:
    """Return the edges of an object's box and its axes as lines in the picture; none where they are not known."""
    if K is None or item.camera_T_object is None or item.size is None:
        return [], []
    pose, size = np.asarray(item.camera_T_object), np.array(item.size)
    corners = ((np.arange(8)[:, None] >> np.arange(3) & 1) - 0.5) * size
    ends = 0.5 * float(np.linalg.norm(size)) / np.sqrt(3.0) * np.vstack([np.zeros(3), np.eye(3)])
    pairs = ((0, 1), (0, 2), (0, 3))
    return segments(transformed(pose, corners), EDGES, K), segments(transformed(pose, ends), pairs, K)


def _cells(item: PartialObject) -> list[str]:
    """Return what the table of objects says of one, in the order of `page._COLUMNS`."""
    size = "-" if item.size is None else " x ".join(f"{1e3 * side:.0f}" for side in item.size)
    return [item.name, item.category, "", size, "-", "-", "-", "-", "-"]
