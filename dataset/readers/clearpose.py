"""ClearPose: sequences of scenes with transparent objects, with poses of objects and of cameras.

::

    set1/scene1/
        metadata.mat                      a struct for each frame, by its number
        000000-color.png  000000-depth.png  000000-depth_true.png  000000-label.png  000000-normal_true.png

Pictures are 640 x 480 px, made of 1280 x 720 by cutting 160 px at the left and the right and dividing by 1.5; older
metadata has the intrinsics of the large ones. Depth is in thousandths of a metre. ``label`` has classes, and not
instances: two objects of a class merge. (opipari/ClearPose; ProgressLabeller issue 3.)
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat

from ...annotate.projection import inverse_pose
from ...annotate.symmetries import ASYMMETRIC
from ...core.errors import InputError, cause_of
from .axes import rigid
from .layout import Layout, names_in
from .picture_files import read_colour, read_depth_png, read_levels
from .source_view import FIRST_OBJECT, Collection, Entry, LeftOut, SourceCamera, SourceObject, SourceView, check_view
from .world_poses import camera_to_world

#: Ids from here on are opaque objects (of YCB and HOPE).
FIRST_OPAQUE = 200
#: Classes without any symmetry; the others have an axis of revolution, along which is not stated.
_ASYMMETRIC = frozenset({1, 6, 7, 12, 14, *range(31, 37), 39, 40})
#: Height and width of the distributed pictures [px]; what was cut at the left of the captured ones [px], and the scale.
_SIZE, _CUT, _SCALE = (480, 640), 160.0, 1.5
_STEPS = 1000.0
_NEEDED = ("color.png", "depth.png", "depth_true.png", "label.png")
#: Names under which the intrinsic matrix is found: that of the code, and that of the documentation.
_INTRINSICS = ("intrinsic_matrix", "camera_intrinsics")


@dataclass(frozen=True, eq=False)
class _Frame:
    """The metadata of a frame."""

    classes: tuple[int, ...]
    poses: np.ndarray  #: (n, 4, 4), camera_T_object [m]
    stated: np.ndarray | None  #: (4, 4), the pose of the camera, in whichever direction
    K: np.ndarray  #: (3, 3)


def _is_unit(names: frozenset[str]) -> bool:
    return "metadata.mat" in names or any(name.endswith("-depth_true.png") for name in names)


def _open(root: Path, units: Sequence[Path]) -> Collection:
    entries: list[Entry] = []
    left_out: list[LeftOut] = []
    notes = [
        "labels are classes: objects whose class is twice in a frame have no instance",
        "true depth is the sensor's with the models drawn over it: holes beside objects remain",
        "sizes of objects are not stated, so boxes in space are unknown",
    ]
    for unit in units:
        names = names_in(unit)
        if "metadata.mat" not in names:
            raise InputError(unit, "calibration of its pictures, metadata.mat", "none")
        frames = _metadata(unit / "metadata.mat")
        scene = "/".join(unit.relative_to(root).parts[-2:]) or unit.name
        world = camera_to_world(
            [(frame.stated, dict(zip(frame.classes, frame.poses, strict=True))) for frame in frames.values()]
        )
        if world is None:
            notes.append(
                f"{scene}: the direction of the cameras' poses does not follow from its objects; they are unknown"
            )
        for number in sorted({name[:6] for name in names if re.fullmatch(r"\d{6}-color\.png", name)} | set(frames)):
            missing = [f"{number}-{end}" for end in _NEEDED if f"{number}-{end}" not in names]
            missing += [] if number in frames else ["its record in metadata.mat"]
            if missing:
                left_out.append(LeftOut(f"{scene}/{number}", f"expected {' and '.join(missing)}, found none"))
            else:
                name = f"{scene}/{number}"
                read = _reader(unit, number, frames[number], world)
                entries.append(Entry(name, scene if world else name, read, _split(unit)))
    return Collection(tuple(entries), tuple(left_out), notes=tuple(notes))


LAYOUT = Layout(
    name="clearpose",
    title="ClearPose",
    licence="unknown (none is stated for the data; the code is MIT)",
    is_unit=_is_unit,
    expected="metadata.mat with NNNNNN-color.png, -depth.png, -depth_true.png and -label.png",
    open=_open,
)


def _split(unit: Path) -> str | None:
    """Return the split of the authors: set 1 scenes 1 to 4, sets 4 to 7 scenes 1 to 5 for training; the rest tests."""
    match = re.search(r"set(\d+)/scene(\d+)$", unit.as_posix())
    if match is None:
        return None
    group, scene = int(match[1]), int(match[2])
    training = (group == 1 and scene <= 4) or (4 <= group <= 7 and scene <= 5)
    return "train" if training else "test"


def _metadata(path: Path) -> dict[str, _Frame]:
    try:
        data = loadmat(path)
    except OSError as error:
        raise InputError(path, "a readable MATLAB file", cause_of(error)) from error
    except (ValueError, TypeError, NotImplementedError, KeyError) as error:
        raise InputError(path, "a whole MATLAB file of version 5", " ".join(str(error).split())[:120]) from error
    return {key: _frame(value, f"{path}: {key}") for key, value in sorted(data.items()) if re.fullmatch(r"\d{6}", key)}


def _frame(value: Any, where: str) -> _Frame:
    record = np.asarray(value).reshape(-1)
    names = record.dtype.names
    if not names or not len(record):
        raise InputError(where, "a struct", "something else")
    fields = {name: np.asarray(record[0][name]) for name in names}
    missing = [name for name in ("cls_indexes", "poses") if name not in fields]
    key = next((name for name in _INTRINSICS if name in fields), None)
    if missing or key is None:
        raise InputError(where, f"cls_indexes, poses and {' or '.join(_INTRINSICS)}", ", ".join(sorted(fields)))
    classes = tuple(int(number) for number in fields["cls_indexes"].reshape(-1))
    poses = fields["poses"].astype(np.float64)
    poses = poses[..., None] if poses.ndim == 2 else poses
    if poses.shape != (3, 4, len(classes)):
        raise InputError(f"{where} poses", f"3 x 4 x {len(classes)} numbers", poses.shape)
    stated = fields.get("rotation_translation_matrix")
    return _Frame(
        classes,
        np.stack([_rigid(poses[..., i], f"{where} pose {i}") for i in range(len(classes))] or [np.eye(4)])[
            : len(classes)
        ],
        None if stated is None or stated.size != 12 else _rigid(stated.astype(np.float64).reshape(3, 4), where),
        _small_K(fields[key].astype(np.float64), f"{where} {key}"),
    )


def _rigid(matrix: np.ndarray, where: str) -> np.ndarray:
    return rigid(np.vstack([matrix, [0.0, 0.0, 0.0, 1.0]]), where)


def _small_K(K: np.ndarray, where: str) -> np.ndarray:
    """Return the intrinsic matrix of the distributed pictures; those of the captured ones are cut and scaled."""
    if K.shape != (3, 3):
        raise InputError(where, "3 x 3 numbers", K.shape)
    if K[0, 2] < 0.75 * _SIZE[1]:
        return K
    small = K.copy()
    small[0, 2] -= _CUT
    small[:2] /= _SCALE
    return small


def _reader(unit: Path, number: str, frame: _Frame, world: str | None) -> Callable[[], SourceView]:
    def read() -> SourceView:
        picture = read_colour(unit / f"{number}-color.png")
        if picture.shape[:2] != _SIZE:
            expected = f"{_SIZE[1]} x {_SIZE[0]} px, as ClearPose distributes"
            raise InputError(unit / f"{number}-color.png", expected, f"{picture.shape[1]} x {picture.shape[0]} px")
        labels = read_levels(unit / f"{number}-label.png").astype(np.int64)
        objects, instances = _objects(frame, labels)
        pose = frame.stated if world else None
        view = SourceView(
            picture=picture,
            camera=SourceCamera(frame.K, inverse_pose(pose) if pose is not None and world == "inverse" else pose),
            Z=read_depth_png(unit / f"{number}-depth_true.png", _STEPS),
            sensor_Z=read_depth_png(unit / f"{number}-depth.png", _STEPS),
            instances=instances,
            classes=labels.astype(np.uint16),
            objects=objects,
        )
        return check_view(view, unit / number)

    return read


def _objects(frame: _Frame, labels: np.ndarray) -> tuple[tuple[SourceObject, ...], np.ndarray | None]:
    """Return the objects of a frame, and their instances where no class is there twice."""
    twice = {number for number, count in Counter(frame.classes).items() if count > 1}
    instances = np.zeros(labels.shape, np.uint16)
    objects = []
    for index, (number, pose) in enumerate(zip(frame.classes, frame.poses, strict=True)):
        name = f"object_{number:03d}"
        instances[labels == number] = index + FIRST_OBJECT
        symmetry = ASYMMETRIC if number in _ASYMMETRIC else None
        objects.append(
            SourceObject(
                index + FIRST_OBJECT, f"{name}-{index}", name, number < FIRST_OPAQUE, pose, "stated", symmetry=symmetry
            )
        )
    return tuple(objects), None if twice else instances
