"""Stereo cameras of a user's pair: a device by its name, a calibration in a file, or baseline and focal length."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from ...core.errors import InputError
from ...core.json_file import parsed, read_json
from ...core.model import Matrix4, Model
from ...core.setting_errors import suggest
from ...dataset.cameras.model import Distortion
from ...dataset.format.camera_file import CAMERA_SCHEMA, CameraFile, Row3, known_K
from ...procedural.surroundings.camera_presets import PRESETS
from ...procedural.surroundings.intrinsics import Intrinsics
from ..data.views import check_camera
from .own_pictures import OwnPicture, checked_lens, lens_of

#: Largest relative difference of two shapes that count as one: whole pixels make one of 1/424 in KeyPose's pictures.
_SHAPE = 0.01


class EyeFile(Model):
    """One camera of a calibration file."""

    K: tuple[Row3, Row3, Row3] = Field(description="Intrinsic matrix [px]")
    width: int = Field(ge=1, description="[px]")
    height: int = Field(ge=1, description="[px]")
    distortion: tuple[float, ...] = Field(default=(), description="k1, k2, p1, p2, k3, as OpenCV has them")


class RigFile(Model):
    """A calibration file of a stereo camera."""

    left: EyeFile
    right: EyeFile
    left_T_right: Matrix4 = Field(description="Pose of the right camera in the left one's frame [m]")


@dataclass(frozen=True)
class RigOptions:
    """What a user says of the camera of a stereo pair."""

    camera: str | None = None  #: name of a device, or a JSON file
    baseline: float | None = None  #: [m]
    focal: float | None = None  #: [px]
    fov: float | None = None  #: horizontal field of view [rad]

    @property
    def given(self) -> bool:
        """Whether anything is said."""
        return any(value is not None for value in (self.camera, self.baseline, self.focal, self.fov))


def with_rig(pictures: Sequence[np.ndarray], options: RigOptions) -> list[OwnPicture]:
    """Return the two pictures of a stereo pair with their cameras; the left camera's frame is the world.

    Parameters
    ----------
    pictures : 2 (H, W, 3) uint8
        The left picture and the right one.
    options : RigOptions
        A device's picture may be of another size of the same shape. Without a device or a file, the principal point is
        in the middle.

    Raises
    ------
    InputError
        Where there are not two pictures, the camera is not known or is of pictures of another size, or options
        contradict each other.
    """
    if len(pictures) != 2:
        where = "--camera" if options.camera is not None else "--baseline"
        raise InputError(where, "the two pictures of a stereo pair", f"{len(pictures)}")
    sizes = [picture.shape[:2] for picture in pictures]
    if sizes[0] != sizes[1]:
        raise InputError("pictures", "two of one size", " and ".join(f"{w} x {h} px" for h, w in sizes))
    if options.camera is not None and options.camera.endswith(".json"):
        _refuse_beside_file(options)
        return _of_file(pictures, Path(options.camera))
    K, baseline = _pinhole(options, sizes[0])
    right = np.eye(4)
    right[0, 3] = baseline
    return [OwnPicture(one, pose, K, Distortion()) for one, pose in zip(pictures, (np.eye(4), right), strict=True)]


def _pinhole(options: RigOptions, size: tuple[int, int]) -> tuple[np.ndarray, float]:
    height, width = size
    if options.focal is not None and options.fov is not None:
        raise InputError("--focal", "either it or --fov", "both")
    focal = options.focal
    if options.fov is not None:
        focal = width / 2.0 / math.tan(options.fov / 2.0)
    if options.camera is None:
        if options.baseline is None or focal is None:
            given = "--baseline" if options.baseline is not None else "--focal or --fov"
            raise InputError("the camera", "--baseline with --focal or --fov, or --camera", f"{given} alone")
        return _K(Intrinsics(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)), options.baseline
    if options.camera not in PRESETS:
        hint = suggest(options.camera.lower(), list(PRESETS))
        raise InputError("--camera", f"one of {', '.join(PRESETS)}{hint}, or a JSON file", options.camera)
    preset = PRESETS[options.camera]
    lens = preset.lens
    if abs(width * lens.height - height * lens.width) > _SHAPE * height * lens.width:
        other = f"{width} x {height} px (--baseline {1e3 * preset.baseline:g}mm with --focal takes them)"
        expected = f"pictures of {lens.width} x {lens.height} px, or of that shape"
        raise InputError(f"--camera {options.camera}", expected, other)
    lens = lens.resized(width, height)
    if focal is not None:
        lens = Intrinsics(width, height, focal, focal, lens.cx, lens.cy)
    return _K(lens), preset.baseline if options.baseline is None else options.baseline


def _K(lens: Intrinsics) -> np.ndarray:
    return np.array([[lens.fx, 0.0, lens.cx], [0.0, lens.fy, lens.cy], [0.0, 0.0, 1.0]])


def _refuse_beside_file(options: RigOptions) -> None:
    others = {"--baseline": options.baseline, "--focal": options.focal, "--fov": options.fov}
    given = [name for name, value in others.items() if value is not None]
    if given:
        raise InputError(given[0], f"nothing beside {options.camera}, which has it", "it")


def _of_file(pictures: Sequence[np.ndarray], path: Path) -> list[OwnPicture]:
    data = read_json(path)
    rig = (
        _stored_rig(data, path) if isinstance(data, dict) and "schema_version" in data else parsed(RigFile, data, path)
    )
    found = []
    for name, picture, eye in zip(("left", "right"), pictures, (rig.left, rig.right), strict=True):
        height, width = picture.shape[:2]
        if (height, width) != (eye.height, eye.width):
            expected = f"pictures of {eye.width} x {eye.height} px, as it is calibrated for"
            raise InputError(f"{path}: {name}", expected, f"{width} x {height} px")
        pose, K = np.eye(4) if name == "left" else rig.left_T_right, np.array(eye.K)
        check_camera(K, pose, f"{path}: {name}")
        lens = lens_of(list(eye.distortion), f"{path}: {name}.distortion")
        found.append(checked_lens(OwnPicture(picture, pose, K, lens), f"{path}: {name}"))
    return found


def _stored_rig(data: dict[str, Any], path: Path) -> RigFile:
    """Return the calibration in a `camera.json` of ours, whose eyes have one K and one lens."""
    if data["schema_version"] != CAMERA_SCHEMA:
        raise InputError(f"{path}: schema_version", CAMERA_SCHEMA, data["schema_version"])
    record = parsed(CameraFile, data, path)
    if record.world_T_right is None:
        raise InputError(f"{path}: world_T_right", "the pose of the right camera", "null")
    lens = () if record.distortion == "none" else record.distortion.coefficients
    eye = EyeFile(K=known_K(record, path), width=record.width, height=record.height, distortion=lens)
    return RigFile(left=eye, right=eye, left_T_right=np.linalg.inv(record.world_T_camera) @ record.world_T_right)
