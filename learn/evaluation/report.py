"""The evaluation report: metrics of all samples, by category, fill and thickness, as JSON and as tables."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from rich.table import Table

from ..metrics.depth import DepthErrors, mean_errors
from ..metrics.detection import average_precision, mean_overlap
from ..metrics.instances import instance_precision, mask_overlaps
from ..metrics.pose import area_under_curve, fraction_near
from .floors import summarised_floors
from .score import FOUND_IOU, PICTURE_PARTS, PIXEL_GROUPS, ObjectScore, SampleScore

#: Thresholds of the accuracy curve [m]: 0.1 m in steps of 5 mm.
CURVE = tuple(round(0.005 * step, 3) for step in range(21))
#: Limits of the classes of the least side of boxes [m].
THICKNESSES = (0.01, 0.03)


def summarise(scores: Sequence[SampleScore]) -> dict[str, Any]:
    """Return all metrics as JSON data: numbers, and None where a metric is undefined.

    Depth is in metres, angles in degrees, fractions from 0 to 1. ``depth`` by size (``full``, ``cleargrasp``) and group
    of pixels, and at full size by whether another view has a pixel in its picture (``overlap``, ``outside``).
    ``floors``: the same of what needs no network, the best constant depth, the true median of each picture's pixels,
    and of stereo pairs semi-global matching. ``boxes``: average precision at three IoUs, and the mean IoU of the
    detected objects (the 3D IoU of the paper) and of all. ``masks``: COCO average precision, and the mean IoU of all.
    ``pose``: see `pose_metrics`; ``keypoints``: see `keypoint_metrics`. Then pose metrics by category, by fill of a
    vessel and by thickness.
    """
    boxes = [score.boxes for score in scores]
    masks = [score.masks for score in scores]
    objects = [item for score in scores for item in score.objects]
    iou_found, iou_all = mean_overlap(boxes, FOUND_IOU)
    precision = instance_precision(masks)
    whole = {
        "samples": len(scores),
        "depth": {
            "full": _mean_by_group([score.full for score in scores]),
            "cleargrasp": _mean_by_group([score.small for score in scores]),
            **{part: _mean_by_group([score.parts[part] for score in scores]) for part in _known_parts(scores)},
        },
        "floors": {
            size: {kind: summarised_floors([score.floors[size] for score in scores], kind) for kind in PIXEL_GROUPS}
            for size in ("full", "cleargrasp")
        },
        "boxes": {
            **{f"ap{round(100 * at)}": average_precision(boxes, at) for at in (0.25, 0.5, 0.75)},
            "iou_found": iou_found,
            "iou_all": iou_all,
        },
        "masks": {**asdict(precision), "iou_all": mean_overlap([mask_overlaps(mask) for mask in masks], FOUND_IOU)[1]},
        "pose": pose_metrics(objects),
        "keypoints": keypoint_metrics(objects),
        **_by_kind(objects),
    }
    return nan_to_none(whole)


def _mean_by_group(rows: Sequence[Mapping[str, DepthErrors | None]]) -> dict[str, Any]:
    return {kind: _asdict(mean_errors([row[kind] for row in rows])) for kind in PIXEL_GROUPS}


def _known_parts(scores: Sequence[SampleScore]) -> list[str]:
    """Return the `PICTURE_PARTS` that all samples have; none where one has a single view."""
    return [part for part in PICTURE_PARTS if scores and all(part in score.parts for score in scores)]


def pose_metrics(objects: Sequence[ObjectScore]) -> dict[str, Any]:
    """Return pose metrics.

    ``auc`` and ``near`` are over the keypoints of all objects; those of missed objects are within no threshold.
    ``mae``, ``add``, ``add_s``, ``translation`` [m] and ``rotation`` [degrees] are means over the detected objects,
    to be read together with ``found``, the fraction of objects detected; ``translation_median`` is a median.
    """
    found = [item.pose for item in objects if item.pose is not None]
    distances = [distance for pose in found for distance in pose.points]
    missed = sum(item.points for item in objects if item.pose is None)
    return {
        "objects": len(objects),
        "found": len(found) / len(objects) if objects else math.nan,
        "auc": area_under_curve(distances, missed),
        "near": fraction_near(distances, missed),
        "mae": _mean(distances),
        "add": _mean([pose.add for pose in found]),
        "add_s": _mean([pose.add_s for pose in found]),
        "translation": _mean([pose.translation for pose in found]),
        "translation_median": float(np.median([pose.translation for pose in found])) if found else math.nan,
        "rotation": math.degrees(_mean([pose.rotation for pose in found])),
    }


def keypoint_metrics(objects: Sequence[ObjectScore]) -> dict[str, Any]:
    """Return the accuracy of the keypoints that all methods are compared on (`targets.keypoints`).

    ``auc`` and ``near``: those of missed objects are within no threshold. ``mae`` [m] is over the objects found.
    """
    distances = [distance for item in objects for distance in item.keypoints or ()]
    missed = sum(item.keypoint_count for item in objects if item.keypoints is None)
    return distance_metrics(distances, missed, len(objects))


def distance_metrics(distances: Sequence[float], missed: int, objects: int) -> dict[str, Any]:
    """Return `keypoint_metrics` from the distances of all keypoints [m] and the number of those that were missed."""
    return {
        "objects": objects,
        "auc": area_under_curve(distances, missed),
        "near": fraction_near(distances, missed),
        "mae": _mean(distances),
        "accuracy": [_within(distances, missed, limit) for limit in CURVE],
    }


def object_metrics(objects: Sequence[ObjectScore]) -> dict[str, Any]:
    """Return the metrics of networks that see one object at a time, by category, fill and thickness as well."""
    return {
        "keypoints": keypoint_metrics(objects),
        "pose": pose_metrics(objects),
        **_by_kind(objects),
    }


def _within(distances: Sequence[float], missed: int, limit: float) -> float:
    count = len(distances) + missed
    return float((np.asarray(distances, float) < limit).sum() / count) if count else math.nan


def fill_class(item: ObjectScore) -> str:
    """Return the fill of an object: ``solid`` if it is no vessel, ``empty``, ``under half``, ``over half``."""
    if not item.label.transparent:
        return "solid"
    if item.label.fill is None:
        return "empty"
    return "under half" if item.label.fill < 0.5 else "over half"


def thickness_class(item: ObjectScore) -> str:
    """Return the class of the least side of an object's box.

    The boxes of a fork do not overlap by a quarter where their depths are 3 mm apart.
    """
    low, high = (round(1e3 * limit) for limit in THICKNESSES)
    least = float(np.min(item.label.size))
    if least < THICKNESSES[0]:
        return f"below {low} mm"
    return f"{low} to {high} mm" if least < THICKNESSES[1] else f"{high} mm and more"


def tables(found: dict[str, Any]) -> list[Table]:
    """Return the result of `summarise` as tables: the columns of the paper, depth, floors, groups of objects.

    The paper's mAP of masks is the average precision at an IoU of 0.5, mask AP50 here; mask AP is COCO's.
    """
    if "locations" in found:
        return _object_tables(found)
    depth, boxes, masks, pose = (found[name] for name in ("depth", "boxes", "masks", "pose"))
    objects = depth["cleargrasp"]["objects"] or {}
    paper = [objects.get("rmse"), objects.get("mae"), objects.get("rel"), boxes["ap25"], boxes["iou_found"]]
    names = ("RMSE [m]", "MAE [m]", "REL", "3D AP25", "3D IoU found", "mask AP50", "mask AP", "mask IoU")
    names += ("AUC", "<2 cm", "found")
    values = [*paper, masks["ap50"], masks["ap"], masks["iou_all"], pose["auc"], pose["near"], pose["found"]]
    first = _table(f"{found['samples']} samples", names, [values])
    heading = ("pixels", "RMSE [m]", "MAE [m]", "REL", "1.05", "1.10", "1.25")
    kinds = _table("depth", ("size", *heading), _depth_rows(depth))
    floors = _table("depth without a network, full size", ("floor", *heading), _floor_rows(found["floors"]["full"]))
    columns = (
        "objects",
        "found",
        "iou_all",
        "depth_mae",
        "axis_mae",
        "auc",
        "near",
        "mae",
        "add_s",
        "translation",
        "rotation",
    )
    rows = [[name, *(row[column] for column in columns)] for group in _KINDS for name, row in found[group].items()]
    return [first, kinds, floors, _table("objects", ("kind", *columns), rows)]


def _object_tables(found: dict[str, Any]) -> list[Table]:
    names = (
        "location",
        "objects",
        "AUC",
        "<2 cm",
        "MAE [m]",
        "dropped",
        "missed",
        "lost",
        "unknown",
        "too small",
        "translation",
        "rotation",
    )
    rows = []
    for location, values in found["locations"].items():
        keypoints, pose = values["keypoints"], values["pose"]
        counts = [values[name] for name in ("dropped", "missed", "lost", "unknown", "too_small")]
        of_points = [keypoints[name] for name in ("objects", "auc", "near", "mae")]
        rows.append([location, *of_points, *counts, pose["translation"], pose["rotation"]])
    kinds = ("objects", "found", "axis_mae", "auc", "near", "mae", "add_s", "translation", "rotation")
    groups = [
        [name, *(row[column] for column in kinds)]
        for group in _KINDS
        for name, row in found["locations"]["truth"][group].items()
    ]
    return [
        _table(f"{found['samples']} samples", names, rows),
        _table("objects, true places", ("kind", *kinds), groups),
    ]


def _depth_rows(depth: dict[str, Any]) -> list[list[Any]]:
    return [
        [size, kind, *(errors.values() if errors else [None] * 6)]
        for size, kinds in depth.items()
        for kind, errors in kinds.items()
    ]


def _floor_rows(floors: dict[str, Any]) -> list[list[Any]]:
    names = ("rmse", "mae", "rel", "delta_105", "delta_110", "delta_125")
    return [
        [floor.replace("_", " "), kind, *((errors or {}).get(name) for name in names)]
        for kind, by_floor in floors.items()
        for floor, errors in by_floor.items()
    ]


def _by_kind(objects: Sequence[ObjectScore]) -> dict[str, Any]:
    return {group: _grouped(objects, [kind_of(item) for item in objects]) for group, kind_of in _KINDS.items()}


def _category(item: ObjectScore) -> str:
    return item.label.category


#: Kinds of objects that have metrics of their own: their entry in reports, and which of them an object is of.
_KINDS = {"by_category": _category, "by_content": fill_class, "by_thickness": thickness_class}


def _grouped(objects: Sequence[ObjectScore], names: Sequence[str]) -> dict[str, Any]:
    groups: dict[str, list[ObjectScore]] = {}
    for item, name in zip(objects, names, strict=True):
        groups.setdefault(name, []).append(item)
    return {
        name: {
            **pose_metrics(group),
            "axis_mae": _mean([distance for item in group for distance in item.keypoints or ()]),
            "iou_all": _mean([item.iou for item in group]),
            "depth_mae": _mean([item.depth_mae for item in group if item.depth_mae is not None]),
        }
        for name, group in sorted(groups.items())
    }


def _table(title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> Table:
    table = Table(title=title)
    for column in columns:
        table.add_column(column, justify="right")
    for row in rows:
        table.add_row(*(_cell(value) for value in row))
    return table


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else math.nan


def _asdict(errors: Any) -> dict[str, float] | None:
    return None if errors is None else asdict(errors)


def nan_to_none(value: Any) -> Any:
    """Return JSON data with None for the numbers that are undefined."""
    if isinstance(value, dict):
        return {name: nan_to_none(inner) for name, inner in value.items()}
    if isinstance(value, list):
        return [nan_to_none(inner) for inner in value]
    return None if isinstance(value, float) and math.isnan(value) else value
