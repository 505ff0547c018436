"""A view of a BOP data set from its records, whichever files they come from.

BOP's units are millimetres, its camera axes OpenCV's, its K has pixel centres on whole numbers, as ours. (bop_toolkit,
docs/bop_datasets_format.md.)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...annotate.boxes import Box
from ...annotate.projection import inverse_pose
from ...annotate.symmetries import Symmetry
from ...core.errors import InputError
from ...core.json_file import read_json
from .axes import rigid
from .picture_files import metres
from .source_view import FIRST_OBJECT, SourceCamera, SourceObject, SourceView, check_view

#: Millimetres of a metre.
_MM = 1000.0
#: An axis of revolution within this of an axis of the model is that axis [1].
_ON_AXIS = 1e-3
#: Names of folders of models, the best one first: those for evaluation have the symmetries.
_MODELS = ("models_eval", "models", "models_cad", "models_reconst", "models_fine")


@dataclass(frozen=True, eq=False)
class BopModel:
    """What ``models_info.json`` says of an object."""

    bop_T_ours: np.ndarray  #: (4, 4) float64 [m]: the centre of its box, with the axis of revolution along z
    size: np.ndarray  #: (3,) float64, along our axes [m]
    symmetry: Symmetry | None  #: None where the axis of revolution is along none of the model's


@dataclass(frozen=True, eq=False)
class BopImage:
    """The records and decoded files of one image; None is what the data set lacks."""

    camera: Mapping[str, Any]
    gt: Sequence[Mapping[str, Any]] | None
    info: Sequence[Mapping[str, Any]] | None
    picture: np.ndarray
    depth: np.ndarray | None  #: (H, W) whole numbers, as stored
    masks: Mapping[int, np.ndarray] | None  #: visible pixels by the number of the object in `gt`, (H, W) bool
    depth_is_true: bool  #: whether depth was rendered; else a sensor measured it


def read_models(folders: Sequence[Path]) -> dict[int, BopModel]:
    """Return the models of the first ``models_info.json`` that is found below some folders; empty without one."""
    for folder in folders:
        for name in _MODELS:
            path = folder / name / "models_info.json"
            if path.is_file():
                return {int(number): _model(record, f"{path}: {number}") for number, record in read_json(path).items()}
    return {}


def bop_view(image: BopImage, models: Mapping[int, BopModel], where: object) -> SourceView:
    """Return a view of its records.

    Raises
    ------
    InputError
        Where a record lacks a field or holds something else.
    """
    camera = bop_camera(image.camera, where)
    objects, instances = None, None
    if image.gt is not None:
        objects = tuple(
            _object(number, record, image.info, models, f"{where}: object {number}")
            for number, record in enumerate(image.gt)
        )
        if image.masks is not None and len(image.masks) == len(image.gt):
            instances = np.zeros(image.picture.shape[:2], np.uint16)
            for number, mask in image.masks.items():
                if mask.shape != instances.shape:
                    raise InputError(where, f"masks of {instances.shape} px", mask.shape)
                instances[mask] = number + FIRST_OBJECT
    Z = None
    if image.depth is not None:
        Z = metres(image.depth, _MM / _number(image.camera, "depth_scale", where))
    return check_view(
        SourceView(
            picture=image.picture,
            camera=camera,
            Z=Z if image.depth_is_true else None,
            sensor_Z=None if image.depth_is_true else Z,
            instances=instances,
            objects=objects,
        ),
        where,
    )


def bop_camera(record: Mapping[str, Any], where: object) -> SourceCamera:
    """Return the camera of an entry of ``scene_camera.json``."""
    if "cam_K" not in record:
        found = "a cam_model (a fisheye lens, which is not read)" if "cam_model" in record else "none"
        raise InputError(f"{where}: cam_K", "the intrinsic matrix of a pinhole", found)
    K = _numbers(record, "cam_K", 9, where).reshape(3, 3)
    pose = None
    if "cam_R_w2c" in record and "cam_t_w2c" in record:
        pose = inverse_pose(_pose(record, "cam_R_w2c", "cam_t_w2c", where))
    return SourceCamera(K, pose)


def places(record: Mapping[str, Any], gt: Sequence[Mapping[str, Any]] | None, where: object) -> np.ndarray | None:
    """Return where the objects of an image stand in the world, (n, 4) rows of id and place [m]; None without a pose."""
    camera = bop_camera(record, where)
    if camera.world_T_camera is None or gt is None:
        return None
    rows = [[float(item["obj_id"]), *(camera.world_T_camera @ _object_pose(item, where))[:3, 3]] for item in gt]
    return np.array(sorted(rows)).reshape(-1, 4)


def _object(
    number: int,
    record: Mapping[str, Any],
    info: Sequence[Mapping[str, Any]] | None,
    models: Mapping[int, BopModel],
    where: object,
) -> SourceObject:
    try:
        bop_id = int(record["obj_id"])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{where}: obj_id", "a number", "none") from error
    pose, model = _object_pose(record, where), models.get(bop_id)
    name = f"obj_{bop_id:06d}"
    return SourceObject(
        id=number + FIRST_OBJECT,
        name=f"{name}-{number}",
        category=name,
        camera_T_object=pose if model is None else pose @ model.bop_T_ours,
        pose_from="stated",
        size=None if model is None else model.size,
        box=None if info is None or number >= len(info) else _box(info[number]),
        symmetry=None if model is None else model.symmetry,
    )


def _box(info: Mapping[str, Any]) -> Box | None:
    """Return the box of visible pixels. ``bbox_visib`` is (xmin, ymin, xmax - xmin, ymax - ymin), without the last one.

    (bop_toolkit_lib/misc.py, calc_2d_bbox; (-1, -1, -1, -1) for nothing visible.)
    """
    values = info.get("bbox_visib")
    if not isinstance(values, list) or len(values) != 4 or values[2] < 0:
        return None
    left, top, width, height = (float(value) for value in values)
    return (left - 0.5, top - 0.5, left + width + 0.5, top + height + 0.5)


def _object_pose(record: Mapping[str, Any], where: object) -> np.ndarray:
    return _pose(record, "cam_R_m2c", "cam_t_m2c", where)


def _pose(record: Mapping[str, Any], turn: str, shift: str, where: object) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = _numbers(record, turn, 9, where).reshape(3, 3)
    pose[:3, 3] = _numbers(record, shift, 3, where) / _MM
    return rigid(pose, f"{where}: {turn}")


def _model(record: Mapping[str, Any], where: str) -> BopModel:
    low = np.array([_number(record, f"min_{axis}", where) for axis in "xyz"]) / _MM
    size = np.array([_number(record, f"size_{axis}", where) for axis in "xyz"]) / _MM
    axes = [_numbers(item, "axis", 3, where) for item in record.get("symmetries_continuous", [])]
    axes = [axis / np.linalg.norm(axis) for axis in axes]
    along = [int(np.argmax(np.abs(axis))) for axis in axes]
    straight = all(abs(axis[place]) > 1.0 - _ON_AXIS for axis, place in zip(axes, along, strict=True))
    T = np.eye(4)
    if along and straight:
        # A turn by axes: x, y, z of ours are the model's, moved on so that z is the axis of revolution.
        T[:3, :3] = np.roll(np.eye(3), along[0] + 1, axis=0)
    T[:3, 3] = low + size / 2.0
    motions = [_motion(values, T, where) for values in record.get("symmetries_discrete", [])]
    symmetry = Symmetry(turns=bool(axes), ball=len(set(along)) > 1, motions=np.stack([np.eye(4), *motions]))
    return BopModel(T, np.abs(T[:3, :3].T @ size), symmetry if straight else None)


def _motion(values: Any, T: np.ndarray, where: str) -> np.ndarray:
    motion = np.array(values, np.float64)
    if motion.size != 16:
        raise InputError(f"{where}: symmetries_discrete", "16 numbers each", motion.size)
    motion = motion.reshape(4, 4)
    motion[:3, 3] /= _MM
    return rigid(inverse_pose(T) @ motion @ T, f"{where}: symmetries_discrete")


def _number(record: Mapping[str, Any], name: str, where: object) -> float:
    value = record.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{where}: {name}", "a number", "none" if value is None else value)
    return float(value)


def _numbers(record: Mapping[str, Any], name: str, count: int, where: object) -> np.ndarray:
    try:
        values = np.array(record[name], np.float64).reshape(-1)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{where}: {name}", f"{count} numbers", "none") from error
    if values.size != count or not np.isfinite(values).all():
        raise InputError(f"{where}: {name}", f"{count} finite numbers", values.size)
    return values
