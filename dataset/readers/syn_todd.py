"""Syn-TODD as its authors distribute the raw scenes: rendered stereo pairs of 57 cameras.

::

    1234/                                                       a scene
        BoundingBox.json                                        cameras, boxes and poses
        Camera_3_EmptyVessel_Frame_0_RGB_L.jpg  _RGB_R.jpg  _Depth.exr
        segmentation_Camera_3_NAME_visible_L.png                for each object: (206, 206, 206) where it is seen

Blender rendered it: corners of boxes are in its camera's axes, and its principal point is the middle of the picture
with the first pixel from 0 to 1. Whether ``camera_extrinsic`` goes to the world or from it is not stated; it follows
from boxes that stand still. The pickled form (``.pickle.zstd``) is refused: a pickle runs code when it is read.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...annotate.projection import inverse_pose
from ...core.errors import InputError
from ...core.json_file import read_json
from .axes import BLENDER_CAMERA, rigid, without_scale
from .layout import Layout, names_in
from .picture_files import read_colour, read_depth_exr
from .source_view import (
    FIRST_OBJECT,
    TABLE,
    Collection,
    Entry,
    LeftOut,
    SourceCamera,
    SourceObject,
    SourceView,
    check_view,
)
from .world_poses import camera_to_world

_BASE = "Camera_{}_EmptyVessel_Frame_0_"
_GLASS = "transparent_"
#: Longest name of an object in the names of files [characters].
_LONGEST_NAME = 38
#: Red above which a pixel belongs to an object, and green below which that is another one: codes are blended at edges.
_OBJECT_RED, _OTHER_GREEN = 110, 100
#: Corners of a box that lie along x, y and z of the first one, in Blender's order.
_ALONG = (4, 3, 1)
#: Half a pixel: Blender's principal point counts from the corner of the first pixel, ours from its centre [px].
_HALF = 0.5


def _is_unit(names: frozenset[str]) -> bool:
    return "BoundingBox.json" in names or any(name.endswith(".pickle.zstd") for name in names)


def _open(root: Path, units: Sequence[Path]) -> Collection:
    entries: list[Entry] = []
    left_out: list[LeftOut] = []
    notes = ["3D boxes give poses and sizes; symmetries are not stated"]
    for unit in units:
        names = names_in(unit)
        if "BoundingBox.json" not in names:
            expected = "raw scenes of Syn-TODD, with BoundingBox.json"
            raise InputError(unit, expected, "pickles, which run code when they are read and are refused")
        cameras = _cameras(unit / "BoundingBox.json")
        scene = unit.relative_to(root).as_posix() if unit != root else unit.name
        found = {number: _boxes(record, f"{unit.name}: Camera_{number}") for number, record in cameras.items()}
        direction = _direction(cameras, found, unit)
        if direction is None:
            notes.append(
                f"{scene}: the direction of camera_extrinsic does not follow from its boxes; poses are unknown"
            )
        for number, record in sorted(cameras.items()):
            name = f"{scene}/Camera_{number}"
            missing = [_BASE.format(number) + end for end in ("RGB_L.jpg", "RGB_R.jpg", "Depth.exr")]
            missing = [file for file in missing if file not in names]
            if missing:
                left_out.append(LeftOut(name, f"expected {' and '.join(missing)}, found none"))
                continue
            read = _reader(unit, number, record, found[number], direction, names)
            entries.append(Entry(name, scene if direction else name, read))
    return Collection(tuple(entries), tuple(left_out), notes=tuple(notes))


LAYOUT = Layout(
    name="syn-todd",
    title="Syn-TODD (raw)",
    licence="unknown (see the terms of its archive, DOI 10.5683/SP3/LQKTXE)",
    is_unit=_is_unit,
    expected="BoundingBox.json with Camera_N_EmptyVessel_Frame_0_RGB_L.jpg, _RGB_R.jpg and _Depth.exr",
    open=_open,
)


def _cameras(path: Path) -> dict[int, dict[str, Any]]:
    data = read_json(path)
    if not isinstance(data, dict):
        raise InputError(path, "cameras by their names", type(data).__name__)
    found = {int(key[7:]): value for key, value in data.items() if re.fullmatch(r"Camera_\d+", key)}
    if not found or not all(isinstance(value, dict) for value in found.values()):
        raise InputError(path, "records Camera_0, Camera_1 and so on", ", ".join(sorted(data)[:5]) or "none")
    return found


def _boxes(record: Mapping[str, Any], where: str) -> dict[str, np.ndarray]:
    """Return the corners of each object's box in the camera's frame with OpenCV's axes, (8, 3) [m], by name."""
    found = {}
    for name, value in record.items():
        if not isinstance(value, dict) or "3dbox" not in value:
            continue
        try:
            corners = np.array(value["3dbox"]["camera_frame"], np.float64)
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"{where}: {name}", "3dbox.camera_frame", "none") from error
        if corners.shape != (8, 3) or not np.isfinite(corners).all():
            raise InputError(f"{where}: {name} 3dbox.camera_frame", "8 x 3 numbers", corners.shape)
        found[name] = corners * [1.0, -1.0, -1.0] if corners[:, 2].mean() < 0.0 else corners
    return found


def _pose_and_size(corners: np.ndarray, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Return pose and size of a box of its corners, in Blender's order."""
    edges = np.stack([corners[place] - corners[0] for place in _ALONG])
    size = np.linalg.norm(edges, axis=1)
    if not (size > 0.0).all():
        raise InputError(where, "a box with three sides", size.tolist())
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = (edges / size[:, None]).T, corners.mean(axis=0)
    return rigid(pose, where), size


def _direction(
    cameras: Mapping[int, Mapping[str, Any]], boxes: Mapping[int, Mapping[str, np.ndarray]], unit: Path
) -> tuple[str, bool] | None:
    """Return the direction of ``camera_extrinsic``, and whether its camera has Blender's axes."""
    for blender in (True, False):
        rows = []
        for number in sorted(cameras):
            stated = _extrinsic(cameras[number], unit / f"Camera_{number}")
            places = {
                name: np.vstack([np.column_stack([np.eye(3), corners.mean(axis=0)]), [0, 0, 0, 1]])
                for name, corners in boxes[number].items()
            }
            rows.append((stated, {name: BLENDER_CAMERA @ at if blender else at for name, at in places.items()}))
        found = camera_to_world(rows)
        if found is not None:
            return found, blender
    return None


def _extrinsic(record: Mapping[str, Any], where: Path) -> np.ndarray | None:
    if "camera_extrinsic" not in record:
        return None
    matrix = np.array(record["camera_extrinsic"], np.float64)
    if matrix.shape == (3, 4):
        matrix = np.vstack([matrix, [0.0, 0.0, 0.0, 1.0]])
    return without_scale(matrix, f"{where} camera_extrinsic")


def _reader(
    unit: Path,
    number: int,
    record: Mapping[str, Any],
    boxes: Mapping[str, np.ndarray],
    direction: tuple[str, bool] | None,
    names: frozenset[str],
) -> Callable[[], SourceView]:
    def read() -> SourceView:
        where, base = unit / f"Camera_{number}", _BASE.format(number)
        picture = read_colour(unit / f"{base}RGB_L.jpg")
        objects = tuple(_object(index, name, boxes[name], where) for index, name in enumerate(sorted(boxes)))
        view = SourceView(
            picture=picture,
            right=read_colour(unit / f"{base}RGB_R.jpg"),
            camera=_camera(record, direction, where),
            Z=read_depth_exr(unit / f"{base}Depth.exr"),
            instances=_instances(unit, number, sorted(boxes), names, picture.shape[:2]),
            objects=objects,
        )
        return check_view(view, where)

    return read


def _camera(record: Mapping[str, Any], direction: tuple[str, bool] | None, where: Path) -> SourceCamera:
    try:
        K = np.array(record["camera_intrinsic"], np.float64)
        baseline = float(record["baseline"])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(where, "camera_intrinsic and baseline", "none") from error
    if K.shape != (3, 3) or not baseline > 0.0:
        raise InputError(where, "an intrinsic matrix of 3 x 3 numbers, and a baseline", f"{K.shape} and {baseline}")
    K = K.copy()
    K[:2, 2] -= _HALF
    stated = _extrinsic(record, where)
    if direction is None or stated is None:
        return SourceCamera(K, None, baseline)
    pose = inverse_pose(stated) if direction[0] == "inverse" else stated
    return SourceCamera(K, pose @ BLENDER_CAMERA if direction[1] else pose, baseline)


def _object(index: int, name: str, corners: np.ndarray, where: Path) -> SourceObject:
    pose, size = _pose_and_size(corners, f"{where}: {name}")
    glass = name.startswith(_GLASS)
    category = "vessel" if glass else "opaque object"
    return SourceObject(index + FIRST_OBJECT, name, category, glass, pose, "box", size)


def _instances(
    unit: Path, number: int, objects: Sequence[str], names: frozenset[str], size: tuple[int, ...]
) -> np.ndarray | None:
    """Return the instances of a view: an object's file shows where it is seen, and where all are black is the table."""
    found, table = np.zeros(size, np.uint16), np.ones(size, bool)
    for index, name in enumerate(objects):
        start = f"segmentation_Camera_{number}_{name[:_LONGEST_NAME]}"
        file = next(
            (f for f in sorted(names) if f.startswith(start) and f.endswith("_visible_L.png") and "_Content_" not in f),
            None,
        )
        if file is None:
            return None
        codes = read_colour(unit / file)
        if codes.shape[:2] != size:
            raise InputError(unit / file, f"{size[1]} x {size[0]} px, as its picture has", codes.shape[:2])
        bright = codes[..., 0] > _OBJECT_RED
        found[bright & (codes[..., 1] >= _OTHER_GREEN)] = index + FIRST_OBJECT
        table &= ~bright
    found[table & (found == 0)] = TABLE
    return found
