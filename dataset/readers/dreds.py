"""DREDS (rendered) and STD (captured): RGB-D pictures of diffuse, specular and transparent objects.

::

    00000/0000_color.png  0000_mask.exr  0000_meta.txt  0000_simDepthImage.exr  0000_depth_120.exr       DREDS
    test_0/0000_color.png  0000_mask.png  0000_meta.txt  0000_depth_415.exr     0000_gt_depth.exr        STD

A row of ``meta.txt``: index in the mask, label, folder, name, scale, material, quaternion, translation. Materials: 0 as
the model has it, 1 diffuse, 2 transparent, 3 specular. Masks in EXR files are the index over 255. The quaternion, w
first, turns the camera's axes (OpenCV's) to the model's, whose y axis is up: the inverse of a pose's rotation, as the
renderer writes it. Nothing says that of STD, whose poses are not read. (PKU-EPIC/DREDS, CatePoseEstimation/datasets
and trainer.py, DepthSensorSimulator/renderer.py.)
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from ...annotate.symmetries import REVOLUTION
from ...core.errors import InputError, cause_of
from ..format.exr import read_exr
from .layout import Layout, names_in
from .picture_files import first_of, read_colour, read_depth_exr, read_levels
from .source_view import FIRST_OBJECT, Collection, Entry, LeftOut, SourceCamera, SourceObject, SourceView, check_view

LABELS = ("other", "bottle", "bowl", "camera", "can", "car", "mug", "aeroplane")
_TRANSPARENT = 2
#: Labels of objects that look the same from all sides of their upward axis (utils/metrics_nocs.py).
_ROUND = frozenset({"bottle", "bowl", "can"})
#: From our object axes, z up, to those of the models, y up.
_MODEL_R_OBJECT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
#: Focal lengths of the authors' code [px]: of DREDS at 640 x 360, and of the D415 of STD at 1280 x 720.
_RENDERED_FOCAL, _RENDERED_WIDTH = (446.31, 446.31), 640
_CAPTURED_FOCAL, _CAPTURED_WIDTH = (918.295227050781, 917.5439453125), 1280
#: Index of the mask where there is no object.
_NOTHING = (0, 255)
_SENSOR, _TRUE, _MASK = (
    ("simDepthImage.exr", "depth_415.exr"),
    ("depth_120.exr", "gt_depth.exr"),
    ("mask.exr", "mask.png"),
)


@dataclass(frozen=True)
class _Row:
    """A row of ``meta.txt``."""

    index: int
    label: int
    name: str
    material: int
    quaternion: tuple[float, float, float, float]  #: w first
    place: tuple[float, float, float]  #: camera frame [m]


def _is_unit(names: frozenset[str]) -> bool:
    return any(name.endswith("_meta.txt") for name in names) and any(name.endswith("_color.png") for name in names)


def _open(root: Path, units: Sequence[Path]) -> Collection:
    entries: list[Entry] = []
    left_out: list[LeftOut] = []
    for unit in units:
        names = names_in(unit)
        base = unit.relative_to(root).as_posix() if unit != root else unit.name
        for number in sorted(name[:4] for name in names if re.fullmatch(r"\d{4}_color\.png", name)):
            missing = [
                " or ".join(group)
                for group in ((*_SENSOR,), (*_TRUE,), (*_MASK,), ("meta.txt",))
                if not _has(names, number, group)
            ]
            name = f"{base}/{number}"
            if missing:
                left_out.append(LeftOut(name, f"expected {number}_{f' and {number}_'.join(missing)}, found none"))
            else:
                entries.append(Entry(name, name, _reader(unit, number), _split(unit, root)))
    notes = (
        "poses of STD are not read: the convention of their quaternions is not stated",
        "sizes of objects are not stated, so boxes in space are unknown",
        "the principal point is the middle of the picture, as in the authors' code",
        "pictures that are larger than their labels are reduced to these",
    )
    return Collection(tuple(entries), tuple(left_out), notes=notes)


LAYOUT = Layout(
    name="dreds",
    title="DREDS / STD",
    licence="CC BY-NC 4.0",
    is_unit=_is_unit,
    expected="NNNN_color.png, _mask, _meta.txt, and depth of a sensor and of the models",
    open=_open,
)


def _has(names: frozenset[str], number: str, ends: Sequence[str]) -> bool:
    return any(f"{number}_{end}" in names for end in ends)


def _split(unit: Path, root: Path) -> str | None:
    words = [root.name, *unit.relative_to(root).parts]
    return next((word for word in words if word in ("train", "val", "test")), None)


def _reader(unit: Path, number: str) -> Callable[[], SourceView]:
    def read() -> SourceView:
        picture = read_colour(unit / f"{number}_color.png")
        sensor, true, mask = (first_of(unit, [f"{number}_{end}" for end in ends]) for ends in (_SENSOR, _TRUE, _MASK))
        assert sensor is not None
        assert true is not None
        assert mask is not None
        rows = _rows(unit / f"{number}_meta.txt")
        instances = _instances(mask, rows)
        captured = sensor.name.endswith(_SENSOR[1])
        K = _intrinsics(captured, instances.shape)
        view = SourceView(
            picture=_reduced(picture, instances.shape, unit / f"{number}_color.png"),
            camera=SourceCamera(K),
            Z=_nearest(read_depth_exr(true), instances.shape),
            sensor_Z=_nearest(read_depth_exr(sensor), instances.shape),
            instances=instances,
            objects=tuple(_object(row, captured, unit / number) for row in rows),
        )
        return check_view(view, unit / number)

    return read


def _rows(path: Path) -> tuple[_Row, ...]:
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise InputError(path, "a readable file", cause_of(error)) from error
    found = []
    for number, line in enumerate(filter(str.strip, lines), start=1):
        words = line.split()
        try:
            w, x, y, z, right, down, ahead = (float(word) for word in words[6:13])
            names = int(words[0]), int(words[1]), words[3], int(words[5])
        except (IndexError, ValueError) as error:
            expected = "index, label, folder, name, scale, material, quaternion and translation"
            raise InputError(f"{path}, line {number}", expected, line) from error
        found.append(_Row(*names, (w, x, y, z), (right, down, ahead)))
    return tuple(sorted(found, key=lambda row: row.index))


def _instances(path: Path, rows: Sequence[_Row]) -> np.ndarray:
    if path.suffix == ".exr":
        channels = read_exr(path)
        index = np.rint(channels[next(iter(sorted(channels, reverse=True)))] * 255.0).astype(np.int64)
    else:
        index = read_levels(path).astype(np.int64)
    known = {row.index for row in rows}
    unknown = sorted(set(np.unique(index).tolist()) - {*_NOTHING, *known})
    if unknown:
        raise InputError(path, f"the indices of meta.txt, {sorted(known)}", unknown[0])
    return np.where(np.isin(index, list(known)), index + FIRST_OBJECT, 0).astype(np.uint16)


def _intrinsics(captured: bool, labels: tuple[int, ...]) -> np.ndarray:
    """Return K at the size of the labels."""
    focal, at = (_CAPTURED_FOCAL, _CAPTURED_WIDTH) if captured else (_RENDERED_FOCAL, _RENDERED_WIDTH)
    fx, fy = (value * labels[1] / at for value in focal)
    return np.array([[fx, 0.0, (labels[1] - 1) / 2.0], [0.0, fy, (labels[0] - 1) / 2.0], [0.0, 0.0, 1.0]])


def _reduced(picture: np.ndarray, size: tuple[int, ...], where: Path) -> np.ndarray:
    """Return a picture at the size of its labels, by the mean over each pixel's area."""
    if picture.shape[:2] == size:
        return picture
    height, width = size
    if picture.shape[0] % height or picture.shape[0] // height != picture.shape[1] / width:
        expected = f"a whole multiple of its labels, {width} x {height} px"
        raise InputError(where, expected, f"{picture.shape[1]} x {picture.shape[0]} px")
    return cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)


def _nearest(values: np.ndarray, size: tuple[int, ...]) -> np.ndarray:
    """Return a map at another size, by the nearest pixel: depths are never averaged."""
    if values.shape == size:
        return values
    rows, columns = ((2 * np.arange(new) + 1) * old // (2 * new) for new, old in zip(size, values.shape, strict=True))
    return values[rows[:, None], columns]


def _object(row: _Row, captured: bool, where: Path) -> SourceObject:
    category = LABELS[row.label] if 0 <= row.label < len(LABELS) else f"label {row.label}"
    pose = None if captured else _pose(row, where)
    return SourceObject(
        id=row.index + FIRST_OBJECT,
        name=row.name,
        category=category,
        transparent=row.material == _TRANSPARENT,
        camera_T_object=pose,
        pose_from=None if pose is None else "stated",
        symmetry=REVOLUTION if category in _ROUND else None,
    )


def _pose(row: _Row, where: Path) -> np.ndarray:
    """Return the pose of an object whose z axis is up, (4, 4) float64."""
    w, x, y, z = row.quaternion
    if not math.isclose(math.hypot(w, x, y, z), 1.0, abs_tol=1e-3):
        raise InputError(f"{where}_meta.txt", f"a quaternion of length 1 of object {row.index}", row.quaternion)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat([x, y, z, w]).as_matrix().T @ _MODEL_R_OBJECT
    pose[:3, 3] = row.place
    return pose
