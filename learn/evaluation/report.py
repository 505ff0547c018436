"""Scores of many samples as figures: the whole, and each kind of object."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from rich.table import Table

from ..metrics.depth import mean_errors
from ..metrics.detection import average_precision, mean_overlap
from ..metrics.instances import instance_precision, mask_overlaps
from ..metrics.pose import area_under_curve, share_near
from .score import FOUND, PIXELS, ObjectScore, SampleScore


def figures(scores: Sequence[SampleScore]) -> dict[str, Any]:
    """Return all figures, as JSON holds them: numbers, and null for what has no value.

    Depth in metres, angles in degrees, shares from 0 to 1. ``depth`` by size (``full``, ``cleargrasp``) and kind of
    pixels. ``boxes``: average precision at three overlaps, and the mean overlap of those found (the paper's 3D IoU) and
    of all. ``masks``: COCO's precision, and the mean overlap of all. ``pose``: see `pose_figures`. Then the same by
    category and by what a vessel holds.
    """
    boxes = [score.boxes for score in scores]
    masks = [score.masks for score in scores]
    objects = [item for score in scores for item in score.objects]
    iou_found, iou_all = mean_overlap(boxes, FOUND)
    precision = instance_precision(masks)
    whole = {
        "samples": len(scores),
        "depth": {
            "full": {kind: _asdict(mean_errors([score.full[kind] for score in scores])) for kind in PIXELS},
            "cleargrasp": {kind: _asdict(mean_errors([score.small[kind] for score in scores])) for kind in PIXELS},
        },
        "boxes": {
            **{f"ap{round(100 * at)}": average_precision(boxes, at) for at in (0.25, 0.5, 0.75)},
            "iou_found": iou_found,
            "iou_all": iou_all,
        },
        "masks": {**asdict(precision), "iou_all": mean_overlap([mask_overlaps(mask) for mask in masks], FOUND)[1]},
        "pose": pose_figures(objects),
        "by_category": _by(objects, [item.label.category for item in objects]),
        "by_content": _by(objects, [content(item) for item in objects]),
    }
    return _without_nan(whole)


def pose_figures(objects: Sequence[ObjectScore]) -> dict[str, Any]:
    """Return figures of poses.

    ``auc`` and ``near`` are over the keypoints of all objects; those of a missed object are right at no threshold.
    ``mae``, ``add``, ``add_s``, ``translation`` [m] and ``rotation`` [degrees] are means over the objects found, so
    they tell nothing without ``found``, the share of objects that were.
    """
    found = [item.pose for item in objects if item.pose is not None]
    distances = [distance for pose in found for distance in pose.points]
    missed = sum(item.points for item in objects if item.pose is None)
    return {
        "objects": len(objects),
        "found": len(found) / len(objects) if objects else math.nan,
        "auc": area_under_curve(distances, missed),
        "near": share_near(distances, missed),
        "mae": _mean(distances),
        "add": _mean([pose.add for pose in found]),
        "add_s": _mean([pose.add_s for pose in found]),
        "translation": _mean([pose.translation for pose in found]),
        "rotation": math.degrees(_mean([pose.rotation for pose in found])),
    }


def content(item: ObjectScore) -> str:
    """Return what an object holds: ``solid`` for no vessel, ``empty``, ``under half``, ``over half``."""
    if not item.label.transparent:
        return "solid"
    if item.label.fill is None:
        return "empty"
    return "under half" if item.label.fill < 0.5 else "over half"


def tables(found: dict[str, Any]) -> list[Table]:
    """Return the figures as tables: the paper's columns first, then depth, then kinds of objects."""
    depth, boxes, masks, pose = (found[name] for name in ("depth", "boxes", "masks", "pose"))
    objects = depth["cleargrasp"]["objects"] or {}
    paper = [objects.get("rmse"), objects.get("mae"), objects.get("rel"), boxes["ap25"], boxes["iou_found"]]
    names = ("RMSE [m]", "MAE [m]", "REL", "3D AP25", "3D IoU found", "mask AP", "mask IoU", "AUC", "<2 cm", "found")
    values = [*paper, masks["ap"], masks["iou_all"], pose["auc"], pose["near"], pose["found"]]
    first = _table(f"{found['samples']} samples", names, [values])
    kinds = _table(
        "depth", ("size", "pixels", "RMSE [m]", "MAE [m]", "REL", "1.05", "1.10", "1.25"), _depth_rows(depth)
    )
    columns = ("objects", "found", "iou_all", "depth_mae", "auc", "near", "mae", "add_s", "translation", "rotation")
    rows = [
        [name, *(row[column] for column in columns)]
        for group in ("by_category", "by_content")
        for name, row in found[group].items()
    ]
    return [first, kinds, _table("objects", ("kind", *columns), rows)]


def _depth_rows(depth: dict[str, Any]) -> list[list[Any]]:
    rows = []
    for size, kinds in depth.items():
        for kind, errors in kinds.items():
            rows.append([size, kind, *(errors.values() if errors else [None] * 6)])
    return rows


def _by(objects: Sequence[ObjectScore], names: Sequence[str]) -> dict[str, Any]:
    groups: dict[str, list[ObjectScore]] = {}
    for item, name in zip(objects, names, strict=True):
        groups.setdefault(name, []).append(item)
    return {
        name: {
            **pose_figures(group),
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


def _without_nan(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _without_nan(inner) for name, inner in value.items()}
    return None if isinstance(value, float) and math.isnan(value) else value
