"""KeyPose's data (TOD): stereo pairs of single objects with keypoints.

::

    bottle_0/texture_5_pose_0/
        000001_L.png  000001_R.png  000001_L.pbtxt  000001_R.pbtxt       the rectified pair, cameras and keypoints
        000001_mask.png  000001_border.png                               the object in the left picture, its outline
        000001_Dt.exr  000001_Do.exr                                     depth of the object, and of its opaque twin
    objects/bottle_0.obj                                                 models, with keypoints as groups kp.000 ...

The layout and its units are those of ``README.md`` and ``data.proto`` of google-research/keypose. Poses are not
stored: where the models are there, they are aligned with the keypoints (`keypose_models`).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...annotate.projection import inverse_pose
from ...core.errors import InputError
from .keypose_models import KeyposeModel, aligned, category_of, read_model, symmetry_of_category
from .layout import Layout, names_in
from .picture_files import read_colour, read_depth_exr, read_levels
from .source_view import (
    FIRST_OBJECT,
    Collection,
    Entry,
    LeftOut,
    SourceCamera,
    SourceKeypoints,
    SourceObject,
    SourceView,
    check_view,
)
from .text_proto import Group, numbers, read_text_proto

_FRAME = re.compile(r"(\d{6})_(?:L|R|mask|border|Dt|Do)\.(?:png|pbtxt|exr)")
#: Files without which a view is left out.
_NEEDED = ("L.png", "R.png", "L.pbtxt", "R.pbtxt")
#: Frames that are known to be damaged (TransCG's reader of the same data, datasets/transparent_object.py).
DAMAGED = ("mug_3/texture_8_pose_3/000010", "mug_4/texture_4_pose_1/000013")
#: Texture that the protocol "t5" of KeyPose leaves out of the training.
TEST_TEXTURE = 5
#: Largest difference between the baseline and the distance of the two stated cameras [m]: they have eight digits.
_BASELINE_ERROR = 1e-4


def _is_unit(names: frozenset[str]) -> bool:
    # A pair of files in KeyPose's names, whichever: half a download is one all the same.
    return any(name.endswith((".pbtxt", "_L.png", "_R.png")) and _FRAME.fullmatch(name) for name in names)


def _open(root: Path, units: Sequence[Path]) -> Collection:
    entries: list[Entry] = []
    left_out: list[LeftOut] = []
    models: dict[str, KeyposeModel | None] = {}
    for unit in units:
        names = names_in(unit)
        if not any(name.endswith(".pbtxt") and _FRAME.fullmatch(name) for name in names):
            raise InputError(unit, "calibration and keypoints of each picture, NNNNNN_L.pbtxt", "pictures without any")
        known = _object_name(unit)
        if known not in models:
            models[known] = _model(root, unit, known)
        scene = f"{known}/{unit.name}"
        for number in sorted({match[1] for match in map(_FRAME.fullmatch, names) if match}):
            name = f"{scene}/{number}"
            missing = [f"{number}_{end}" for end in _NEEDED if f"{number}_{end}" not in names]
            if name in DAMAGED:
                left_out.append(LeftOut(name, "a frame that is known to be damaged"))
            elif missing:
                left_out.append(LeftOut(name, f"expected {' and '.join(missing)}, found none"))
            else:
                model = models[known]
                entries.append(Entry(name, scene, _reader(unit, number, known, model), _split(unit)))
    notes = [
        f"no model of {name} (objects/{name}.obj): its poses stay unknown"
        for name, model in models.items()
        if model is None
    ]
    if any(model is not None for model in models.values()):
        notes.append("poses are aligned with the keypoints; about an axis of revolution they are arbitrary")
    notes.append("depth is that of the opaque twin at the same place, sensor depth that of the transparent object")
    return Collection(tuple(entries), tuple(left_out), notes=tuple(notes))


LAYOUT = Layout(
    name="keypose",
    title="KeyPose (TOD)",
    licence="unknown (the project's repository, which holds a part of the data, is Apache-2.0)",
    is_unit=_is_unit,
    expected="NNNNNN_L.png, _R.png, _L.pbtxt and _R.pbtxt in one folder",
    open=_open,
)


def _split(unit: Path) -> str | None:
    match = re.match(r"texture_(\d+)_pose_\d+", unit.name)
    if unit.parent.parent.name in ("train", "val", "test"):  # as our own exports have it
        return unit.parent.parent.name
    if match is None:
        return None
    return "test" if int(match[1]) == TEST_TEXTURE else "train"


def _object_name(unit: Path) -> str:
    """Return the name of a sequence's object: that of the folder above, which our own exports give each sequence."""
    match = re.fullmatch(r"texture_(\d+)_pose_(\d+)", unit.name)
    if match is None:
        return unit.name
    own = f"{unit.parent.name}_{match[1]}_{match[2]}"
    return own if (unit.parent.parent / "objects" / f"{own}.obj").is_file() else unit.parent.name


def _model(root: Path, unit: Path, name: str) -> KeyposeModel | None:
    """Return the model of an object, beside its folder, in the given one or beside that; None where there is none."""
    for folder in (unit.parent, unit.parent.parent, root, root.parent):
        path = folder / "objects" / f"{name}.obj"
        if path.is_file():
            return read_model(path)
    return None


def _reader(unit: Path, number: str, name: str, model: KeyposeModel | None):
    def read() -> SourceView:
        return _read(unit, number, name, model)

    return read


def _read(unit: Path, number: str, name: str, model: KeyposeModel | None) -> SourceView:
    where = unit / f"{number}_L.pbtxt"
    target = _target(where)
    camera, keypoints = _camera(target, where), _keypoints(target, where)
    _check_right(unit / f"{number}_R.pbtxt", camera, where)
    picture, right = (read_colour(unit / f"{number}_{eye}.png") for eye in "LR")
    stated = tuple(int(numbers(target["camera"][0], side, 1, where)[0]) for side in ("resy", "resx"))
    if stated != picture.shape[:2]:
        expected = f"a picture of {stated[1]} x {stated[0]} px, as its camera is"
        raise InputError(unit / f"{number}_L.png", expected, f"{picture.shape[1]} x {picture.shape[0]} px")
    masks = unit / f"{number}_mask.png"
    instances = None
    if masks.is_file():
        instances = np.where(read_levels(masks) > 0, FIRST_OBJECT, 0).astype(np.uint16)
    Z, sensor_Z = (
        read_depth_exr(path) if path.is_file() else None
        for path in (unit / f"{number}_{end}.exr" for end in ("Do", "Dt"))
    )
    view = SourceView(
        picture=picture,
        right=right,
        camera=camera,
        Z=Z,
        sensor_Z=sensor_Z,
        instances=instances,
        objects=(_object(name, keypoints, camera, model, where),),
    )
    return check_view(view, unit / number)


def _target(path: Path) -> Group:
    groups = read_text_proto(path).get("kp_target", [])
    if len(groups) != 1 or not isinstance(groups[0], dict):
        raise InputError(path, "one kp_target", f"{len(groups)}")
    for field in ("transform", "camera"):
        if len(groups[0].get(field, [])) != 1:
            raise InputError(f"{path}: kp_target", f"one {field}", f"{len(groups[0].get(field, []))}")
    return groups[0]


def _camera(target: Group, where: Path) -> SourceCamera:
    values = {name: numbers(target["camera"][0], name, 1, where)[0] for name in ("fx", "fy", "cx", "cy", "baseline")}
    K = np.array([[values["fx"], 0.0, values["cx"]], [0.0, values["fy"], values["cy"]], [0.0, 0.0, 1.0]])
    if not values["baseline"] > 0.0:
        raise InputError(f"{where}: baseline", "a distance above 0 m", values["baseline"])
    return SourceCamera(K, _world_T_camera(target, where), values["baseline"])


def _world_T_camera(target: Group, where: Path) -> np.ndarray:
    """Return the pose of a camera; the file has its inverse, from the world to the camera, row by row."""
    elements = numbers(target["transform"][0], "element", 16, where)
    return inverse_pose(np.array(elements).reshape(4, 4))


def _check_right(path: Path, left: SourceCamera, where: Path) -> None:
    """Refuse a right camera that does not stand at the baseline along the left one's x axis."""
    assert left.world_T_camera is not None
    assert left.baseline is not None
    pose = _world_T_camera(_target(path), path)
    apart = inverse_pose(left.world_T_camera) @ pose
    if np.abs(apart[:3, 3] - [left.baseline, 0.0, 0.0]).max() > _BASELINE_ERROR:
        shown = ", ".join(f"{value:.4f}" for value in apart[:3, 3])
        raise InputError(path, f"a right camera at ({left.baseline:.4f}, 0, 0) m of {where.name}'s", f"({shown}) m")


def _keypoints(target: Group, where: Path) -> SourceKeypoints:
    rows = [
        [numbers(point, name, 1, where)[0] for name in ("u", "v", "z", "visible")]
        for point in target.get("keypoints", [])
    ]
    if not rows:
        raise InputError(where, "keypoints", "none")
    values = np.array(rows)
    return SourceKeypoints(values[:, :2], values[:, 2], values[:, 3] > 0.5)


def _object(
    name: str, keypoints: SourceKeypoints, camera: SourceCamera, model: KeyposeModel | None, where: Path
) -> SourceObject:
    category = category_of(name)
    item = SourceObject(
        FIRST_OBJECT, name, category, True, keypoints=keypoints, symmetry=symmetry_of_category(category)
    )
    if model is None:
        return item
    assert camera.K is not None
    (fx, _, cx), (_, fy, cy), _ = camera.K
    (u, v), Z = keypoints.pixels.T, keypoints.Z
    points = np.stack([(u - cx) / fx * Z, (v - cy) / fy * Z, Z], axis=1)
    pose = aligned(model, points, item.symmetry, f"{where}: keypoints")
    if pose is None:
        return item
    return SourceObject(
        FIRST_OBJECT,
        name,
        category,
        True,
        camera_T_object=pose,
        pose_from="keypoints",
        size=model.size,
        keypoints=keypoints,
        symmetry=item.symmetry,
    )
