"""ClearGrasp: rendered scenes of transparent objects, and captures of a depth camera with sprayed twins.

::

    synthetic-val/square-plastic-bottle-val/
        rgb-imgs/000000000-rgb.jpg                          json-files/000000000-masks.json
        depth-imgs-rectified/000000000-depth-rectified.exr  camera-normals/000000000-cameraNormals.exr
        segmentation-masks/000000000-segmentation-mask.png  variant-masks/000000000-variantMasks.exr
    real-val/d435/
        camera_intrinsics.yaml
        000000123-transparent-rgb-img.jpg  -transparent-depth-img.exr  -opaque-depth-img.exr  -mask.png  -normals.exr

Depth is planar, in metres (Shreeyak/cleargrasp, issues 8 and 24). Normals have x right, y up, z towards the camera.
Matrices of objects and cameras are row by row, to the world, with Blender's camera axes and scaled columns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from ...annotate.projection import inverse_pose
from ...core.errors import InputError
from ...core.json_file import read_json
from ...core.yaml_file import yaml_settings
from ..format.exr import channel, read_exr
from .axes import BLENDER_CAMERA, without_scale
from .layout import Layout, names_in
from .picture_files import read_colour, read_depth_exr, read_levels, read_normals_exr
from .source_view import FIRST_OBJECT, Collection, Entry, LeftOut, SourceCamera, SourceObject, SourceView, check_view

CLASSES = ("background", "transparent")
#: First number of an object in ``variantMasks``: the first one that is rendered has it.
_FIRST_NUMBER = 100
_REAL = "-transparent-rgb-img.jpg"
_INTRINSICS = "camera_intrinsics.yaml"


def _is_unit(names: frozenset[str]) -> bool:
    rendered = "rgb-imgs" in names and bool(names & {"json-files", "depth-imgs-rectified", "segmentation-masks"})
    return rendered or any(name.endswith(_REAL) for name in names)


def _open(root: Path, units: Sequence[Path]) -> Collection:
    entries: list[Entry] = []
    left_out: list[LeftOut] = []
    for unit in units:
        names = names_in(unit)
        find = _rendered if "rgb-imgs" in names else _captured
        more, less = find(unit, unit.relative_to(root.parent if unit == root else root).as_posix(), names)
        entries += more
        left_out += less
    notes = (
        "every view is a scene of its own: views share no world frame",
        "sizes of objects are not stated, so boxes in space are unknown",
        "masks of captures name no single objects",
    )
    return Collection(tuple(entries), tuple(left_out), CLASSES, notes)


LAYOUT = Layout(
    name="cleargrasp",
    title="ClearGrasp",
    licence="unknown (the project's repository, which holds a part of the data, is Apache-2.0)",
    is_unit=_is_unit,
    expected="rgb-imgs with json-files, or NAME-transparent-rgb-img.jpg with camera_intrinsics.yaml",
    open=_open,
)


def _split(name: str) -> str | None:
    match = re.search(r"(?:^|[-/_])(train|val|test)(?:$|[-/_])", name)
    return match[1] if match else None


def _rendered(unit: Path, name: str, names: frozenset[str]) -> tuple[list[Entry], list[LeftOut]]:
    if "json-files" not in names:
        raise InputError(unit, "calibration of each picture, json-files/*-masks.json", "pictures without it")
    have = {folder: names_in(unit / folder) for folder in ("json-files", "depth-imgs-rectified", "segmentation-masks")}
    entries, left_out = [], []
    for number in _numbers(names_in(unit / "rgb-imgs"), "-rgb.jpg"):
        needed = {
            "json-files": f"{number}-masks.json",
            "depth-imgs-rectified": f"{number}-depth-rectified.exr",
            "segmentation-masks": f"{number}-segmentation-mask.png",
        }
        missing = [
            f"{folder}/{file}" for folder, file in needed.items() if folder in names and file not in have[folder]
        ]
        _add(entries, left_out, f"{name}/{number}", missing, _read_later(_read_rendered, unit, number))
    return entries, left_out


def _captured(unit: Path, name: str, names: frozenset[str]) -> tuple[list[Entry], list[LeftOut]]:
    if _INTRINSICS not in names:
        raise InputError(unit, f"calibration of its pictures, {_INTRINSICS}", "none")
    entries, left_out = [], []
    for number in _numbers(names, _REAL):
        needed = (f"{number}-mask.png", f"{number}-opaque-depth-img.exr", f"{number}-transparent-depth-img.exr")
        missing = [file for file in needed if file not in names]
        _add(entries, left_out, f"{name}/{number}", missing, _read_later(_read_captured, unit, number))
    return entries, left_out


def _numbers(names: frozenset[str], end: str) -> list[str]:
    return sorted(name.removesuffix(end) for name in names if name.endswith(end))


def _add(
    entries: list[Entry], left_out: list[LeftOut], name: str, missing: list[str], read: Callable[[], SourceView]
) -> None:
    if missing:
        left_out.append(LeftOut(name, f"expected {' and '.join(missing)}, found none"))
    else:
        entries.append(Entry(name, name, read, _split(name)))


def _read_later(read: Callable[[Path, str], SourceView], unit: Path, number: str) -> Callable[[], SourceView]:
    return lambda: read(unit, number)


def _read_rendered(unit: Path, number: str) -> SourceView:
    where = unit / "json-files" / f"{number}-masks.json"
    record = read_json(where)
    camera = _rendered_camera(record, where)
    mask = unit / "segmentation-masks" / f"{number}-segmentation-mask.png"
    variants = unit / "variant-masks" / f"{number}-variantMasks.exr"
    depth = unit / "depth-imgs-rectified" / f"{number}-depth-rectified.exr"
    normals = unit / "camera-normals" / f"{number}-cameraNormals.exr"
    instances, objects = None, None
    if variants.is_file():
        instances = _instances(variants)
        objects = _objects(record, camera, where)
    view = SourceView(
        picture=read_colour(unit / "rgb-imgs" / f"{number}-rgb.jpg"),
        camera=camera,
        Z=read_depth_exr(depth) if depth.is_file() else None,
        normals=read_normals_exr(normals) if normals.is_file() else None,
        instances=instances,
        classes=_transparent(mask) if mask.is_file() else None,
        objects=objects,
    )
    if instances is not None:
        _check_ids(instances, objects or (), variants)
    return check_view(view, unit / number)


def _rendered_camera(record: Any, where: Path) -> SourceCamera:
    """Return the camera of a record: its field of view gives K, and its matrix, whose columns are scaled, the pose."""
    try:
        image, camera = record["image"], record["camera"]
        width, height = int(image["width_px"]), int(image["height_px"])
        across, down = (float(camera["field_of_view"][f"{axis}_axis_rads"]) for axis in "xy")
        matrix = np.array(camera["world_pose"]["matrix_4x4"], np.float64)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            where, "image, camera.field_of_view and camera.world_pose.matrix_4x4", f"none ({error})"
        ) from error
    fx, fy = width / 2.0 / math.tan(across / 2.0), height / 2.0 / math.tan(down / 2.0)
    # The optical axis goes through the middle of the picture; pixel (0, 0) has its centre at (0, 0).
    K = np.array([[fx, 0.0, (width - 1) / 2.0], [0.0, fy, (height - 1) / 2.0], [0.0, 0.0, 1.0]])
    return SourceCamera(K, without_scale(matrix, f"{where}: camera") @ BLENDER_CAMERA)


def _objects(record: Any, camera: SourceCamera, where: Path) -> tuple[SourceObject, ...]:
    assert camera.world_T_camera is not None
    camera_T_world = inverse_pose(camera.world_T_camera)
    try:
        listed = record["variants"]["masks_and_poses_by_pixel_value"]
        rows = {
            int(number): (item["world_pose"]["matrix_4x4"], str(item["variant_uri"])) for number, item in listed.items()
        }
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"{where}: variants", "masks_and_poses_by_pixel_value", f"none ({error})") from error
    found = []
    for number, (matrix, uri) in sorted(rows.items()):
        name = PurePosixPath(uri).name
        pose = camera_T_world @ without_scale(np.array(matrix, np.float64), f"{where}: variant {number}")
        found.append(
            SourceObject(
                number - _FIRST_NUMBER + FIRST_OBJECT,
                f"{name}-{number}",
                name,
                True,
                camera_T_object=pose,
                pose_from="stated",
            )
        )
    return tuple(found)


def _instances(path: Path) -> np.ndarray:
    numbers = channel(read_exr(path), "R", path)
    whole = np.rint(numbers).astype(np.int64)
    wrong = (np.abs(numbers - whole) > 1e-3) | ((whole != 0) & (whole < _FIRST_NUMBER)) | (whole > 60000)
    if wrong.any():
        raise InputError(path, f"0 and whole numbers from {_FIRST_NUMBER}", f"{numbers[wrong][0]:g}")
    return np.where(whole > 0, whole - _FIRST_NUMBER + FIRST_OBJECT, 0).astype(np.uint16)


def _check_ids(instances: np.ndarray, objects: Sequence[SourceObject], where: Path) -> None:
    unknown = sorted(set(np.unique(instances).tolist()) - {0, *(item.id for item in objects)})
    if unknown:
        number = unknown[0] - FIRST_OBJECT + _FIRST_NUMBER
        raise InputError(where, "the objects of json-files", f"the number {number}, which is none of them")


def _transparent(path: Path) -> np.ndarray:
    return (read_levels(path) > 0).astype(np.uint16)


def _read_captured(unit: Path, number: str) -> SourceView:
    normals = unit / f"{number}-normals.exr"
    picture = read_colour(unit / f"{number}{_REAL}")
    view = SourceView(
        picture=picture,
        camera=SourceCamera(_captured_K(unit / _INTRINSICS, picture)),
        Z=read_depth_exr(unit / f"{number}-opaque-depth-img.exr"),
        sensor_Z=read_depth_exr(unit / f"{number}-transparent-depth-img.exr"),
        normals=read_normals_exr(normals) if normals.is_file() else None,
        classes=_transparent(unit / f"{number}-mask.png"),
    )
    return check_view(view, unit / number)


def _captured_K(path: Path, picture: np.ndarray) -> np.ndarray:
    values = yaml_settings(path, "camera_intrinsics.yaml")
    try:
        fx, fy, cx, cy = (float(values[name]) for name in ("fx", "fy", "cx", "cy"))
        size = int(values["yres"]), int(values["xres"])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(path, "xres, yres, fx, fy, cx and cy", f"none ({error})") from error
    if size != picture.shape[:2]:
        found = f"{picture.shape[1]} x {picture.shape[0]} px"
        raise InputError(path, f"pictures of {size[1]} x {size[0]} px", found)
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
