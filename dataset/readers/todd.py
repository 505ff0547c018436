"""TODD: captures of vessels by a RealSense D435i with poses from a board.

::

    1622673245.1234/                                     a view; its name is the time [s]
        image.jpg  depth.exr  detph_GroundTruth.exr      (so written)
        instance_segment.png                             first channel: 10 (id + 1)
        pose_type.json                                   {"0": {"pose": 3 x 4, "type": ...}}, object to camera [m]

The intrinsics are those of the loader of its authors (MVTrans, dataloaders/dataset_TODD.py). Poses of cameras are not
stored: objects stand still, so the first object of a run is its world.
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
from .axes import rigid
from .layout import Layout, names_in
from .picture_files import read_colour, read_depth_exr
from .source_view import FIRST_OBJECT, Collection, Entry, LeftOut, SourceCamera, SourceObject, SourceView, check_view

#: Of the D435i that took them, for pictures of 640 x 480 px.
K = np.array([[613.962, 0.0, 324.447], [0.0, 613.756, 239.171], [0.0, 0.0, 1.0]])
SIZE = (480, 640)
#: Longest time between two views of one run [s]: the loader of its authors takes as much.
_PAUSE = 100.0
_NEEDED = ("image.jpg", "instance_segment.png", "pose_type.json")
#: Step of ids in the first channel of ``instance_segment.png``.
_STEP = 10


def _is_unit(names: frozenset[str]) -> bool:
    return "instance_segment.png" in names or "detph_GroundTruth.exr" in names


def _open(root: Path, units: Sequence[Path]) -> Collection:
    entries: list[Entry] = []
    left_out: list[LeftOut] = []
    records: list[tuple[Path, Mapping[int, np.ndarray]]] = []
    for unit in units:
        missing = [name for name in _NEEDED if name not in names_in(unit)]
        if missing:
            left_out.append(LeftOut(_name(unit, root), f"expected {' and '.join(missing)}, found none"))
            continue
        try:
            records.append((unit, {number: pose for number, (pose, _) in _objects(unit / "pose_type.json").items()}))
        except InputError as error:  # a damaged view is named, and the others are read
            left_out.append(LeftOut(_name(unit, root), str(error)))
    for unit, scene, world in _runs(records):
        entries.append(Entry(_name(unit, root), f"{_name(scene, root)}", _reader(unit, world), _split(unit, root)))
    notes = (
        "poses of cameras follow from the first object of a run, which stands still",
        "sizes of objects are not stated, so boxes in space are unknown",
    )
    return Collection(tuple(entries), tuple(left_out), notes=notes)


LAYOUT = Layout(
    name="todd",
    title="TODD",
    licence="unknown (see the terms of its archive, DOI 10.5683/SP3/ZJJAJ3)",
    is_unit=_is_unit,
    expected="image.jpg, instance_segment.png and pose_type.json in one folder",
    open=_open,
)


def _name(unit: Path, root: Path) -> str:
    return unit.relative_to(root).as_posix() if unit != root else unit.name


def _split(unit: Path, root: Path) -> str | None:
    names = [root.name, *unit.relative_to(root).parts]
    return next((name for name in names if name in ("train", "val", "test")), None)


def _runs(records: Sequence[tuple[Path, Mapping[int, np.ndarray]]]) -> list[tuple[Path, Path, int | None]]:
    """Return for each view its folder, the first folder of its run, and the object that is the run's world.

    A run goes on while the time between views is short and its world is in the next view.
    """
    found: list[tuple[Path, Path, int | None]] = []
    last: tuple[Path, float] | None = None
    for unit, poses in sorted(records, key=lambda item: (item[0].parent, _time(item[0]))):
        now = _time(unit)
        goes_on = last is not None and last[0] == unit.parent and now - last[1] < _PAUSE
        if goes_on and found[-1][2] is not None and found[-1][2] in poses:
            found.append((unit, found[-1][1], found[-1][2]))
        else:
            found.append((unit, unit, min(poses, default=None)))
        last = (unit.parent, now)
    return found


def _time(unit: Path) -> float:
    return float(unit.name) if re.fullmatch(r"\d+(\.\d+)?", unit.name) else float("inf")


def _objects(path: Path) -> dict[int, tuple[np.ndarray, str]]:
    """Return pose and category of each object."""
    data = read_json(path)
    if not isinstance(data, dict):
        raise InputError(path, "objects by their numbers", type(data).__name__)
    found = {}
    for key, record in data.items():
        where = f"{path}: {key}"
        if not key.isdigit() or not isinstance(record, dict):
            raise InputError(where, "an object with its pose", "something else")
        found[int(key)] = (_pose(record, where), str(record.get("type", "vessel")))
    return found


def _pose(record: dict[str, Any], where: str) -> np.ndarray:
    try:
        matrix = np.array(record["pose"], np.float64)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{where} pose", "3 x 4 numbers", "none") from error
    if matrix.shape not in ((3, 4), (4, 4)):
        raise InputError(f"{where} pose", "3 x 4 numbers", matrix.shape)
    return rigid(np.vstack([matrix[:3], [0.0, 0.0, 0.0, 1.0]]), f"{where} pose")


def _reader(unit: Path, world: int | None) -> Callable[[], SourceView]:
    def read() -> SourceView:
        picture, objects = read_colour(unit / "image.jpg"), _objects(unit / "pose_type.json")
        if picture.shape[:2] != SIZE:
            found = f"{picture.shape[1]} x {picture.shape[0]} px"
            raise InputError(unit / "image.jpg", f"{SIZE[1]} x {SIZE[0]} px, for which the camera is calibrated", found)
        pose = inverse_pose(objects[world][0]) if world is not None else None
        true, sensor = unit / "detph_GroundTruth.exr", unit / "depth.exr"
        view = SourceView(
            picture=picture,
            camera=SourceCamera(K, pose),
            Z=read_depth_exr(true) if true.is_file() else None,
            sensor_Z=read_depth_exr(sensor) if sensor.is_file() else None,
            instances=_instances(unit / "instance_segment.png", objects),
            objects=tuple(
                SourceObject(number + FIRST_OBJECT, f"{name}-{number}", name, True, pose, "stated")
                for number, (pose, name) in sorted(objects.items())
            ),
        )
        return check_view(view, unit)

    return read


def _instances(path: Path, objects: Mapping[int, object]) -> np.ndarray:
    levels = read_colour(path)[..., 0].astype(np.int64)
    known = {(number + 1) * _STEP: number + FIRST_OBJECT for number in objects}
    unknown = sorted(set(np.unique(levels).tolist()) - {0, *known})
    if unknown:
        raise InputError(path, f"0 and {_STEP} (id + 1) of its objects, {sorted(known)}", unknown[0])
    found = np.zeros(levels.shape, np.uint16)
    for level, number in known.items():
        found[levels == level] = number
    return found
