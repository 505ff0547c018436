"""``camera.json``: one view's stereo pair."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from ...annotate.labels import Rle
from ...core.errors import InputError
from ...core.model import Matrix4, Model
from ...procedural.description.camera import Camera
from ...procedural.description.depth_camera import DepthCamera, along_x
from ...procedural.description.time_of_flight import TimeOfFlightCamera
from ..cameras.model import Distortion, SensorColour

CAMERA_SCHEMA = "glassware/camera/1"
#: Written into every file, because conventions differ between projects.
CONVENTIONS = {
    "axes": "OpenCV: x right, y down, z forward",
    "pixels": "pixel (0, 0) has its centre at image coordinate (0, 0); it covers -0.5 to 0.5",
    "poses": "a_T_b takes coordinates in b to coordinates in a; metres",
    "world": "right-handed, z up, table top at z = 0",
    "pair": "rectified: the right camera has the same axes and K, and stands at +baseline along the left camera's x",
    "Z": "planar depth along the optical axis, metres; +inf where there is nothing",
    "colour": "EXR linear Rec.709 radiance; PNG sRGB of radiance times exposure and balance, up to white",
}

Row3 = tuple[float, float, float]


def _is_none(value: object) -> bool:
    return value is None


class DepthCameraRecord(Model):
    """The depth camera of a view: its place, its infrared cameras, and what the numbers in its files mean."""

    name: str = Field(description="Of the device")
    unit: float = Field(gt=0.0, description="Of the numbers in `sensor_depth.png` [m]")
    range: tuple[float, float] = Field(description="Smallest and largest reported depth [m]")
    kind: Literal["stereo", "tof"] = Field(
        default="stereo", exclude_if=lambda kind: kind == "stereo", description="tof: time of flight; absent: stereo"
    )
    K: tuple[Row3, Row3, Row3] = Field(description="Intrinsic matrix of both infrared cameras, or of the beams [px]")
    width: int = Field(ge=1, description="[px]")
    height: int = Field(ge=1, description="[px]")
    baseline: float | None = Field(
        default=None,
        gt=0.0,
        exclude_if=_is_none,
        description="Between the infrared cameras [m]; absent "
        "with time of flight, as are all fields of a second camera and of pictures",
    )
    camera_T_left: Matrix4 = Field(
        description="Pose of the left infrared camera, or of the place of the beams, in the left colour camera's frame"
    )
    camera_T_right: Matrix4 | None = Field(
        default=None, exclude_if=_is_none, description="Pose of the right infrared camera"
    )
    camera_T_projector: Matrix4 | None = Field(
        default=None, exclude_if=_is_none, description="Pose of the projector, which looks along z"
    )
    exposure: float | None = Field(
        default=None, gt=0.0, exclude_if=_is_none, description="Of the infrared pictures [s]"
    )
    gain: float | None = Field(default=None, ge=1.0, exclude_if=_is_none, description="Of the infrared pictures")
    reasons: tuple[str, ...] = Field(description="Names of the numbers 0, 1, 2 ... in `sensor_valid.png`")


class PolarisationRecord(Model):
    """The polarisation camera in the place of a view's left camera, and what the numbers of its mosaic mean."""

    name: str = Field(description="Of the device")
    angles: tuple[tuple[float, float], tuple[float, float]] = Field(
        description="Axes of the filters of the first 2 x 2 pixels, row by row, counter-clockwise from x [deg]"
    )
    colour: bool = Field(description="Whether each such cell lies behind one colour of a Bayer mosaic, rows R G, G B")
    extinction_ratio: float = Field(gt=1.0, description="Light that passes along the axis over that across it")
    bits: int = Field(ge=1, le=16, description="Of the numbers; the largest one is saturated")
    black_level: float = Field(ge=0.0, lt=1.0, description="Number of no light, as a fraction of the largest one")
    gain: float = Field(gt=0.0, description="Signal, from black 0 to saturated 1, for each unit of radiance")

    @property
    def axes(self) -> np.ndarray:
        """Axes of the filters of a cell, (2, 2) float64 [rad]."""
        return np.radians(np.array(self.angles))


class CameraFile(Model):
    """Intrinsics, pose and exposure of a view."""

    schema_version: Literal["glassware/camera/1"] = CAMERA_SCHEMA
    K: tuple[Row3, Row3, Row3] | None = Field(
        description="Intrinsic matrix of both cameras [px]; null only in converted data sets: not calibrated"
    )
    width: int = Field(ge=1, description="[px]")
    height: int = Field(ge=1, description="[px]")
    world_T_camera: Matrix4 = Field(description="Pose of the left camera")
    world_T_right: Matrix4 | None = Field(
        description="Pose of the right camera; null only in converted data sets: there is none"
    )
    baseline: float | None = Field(gt=0.0, description="[m]; null with `world_T_right`")
    distortion: Literal["none"] | Distortion = Field(
        default="none",
        description="none: the pictures are those of pinholes. Else what the lens has done to the pictures, by the "
        "same K; all labels, depths and ids stay those of the pinhole",
    )
    colour_camera: str | None = Field(
        default=None, exclude_if=lambda name: name is None, description="What took the pictures; absent: the ideal one"
    )
    sensitivities: SensorColour | None = Field(
        default=None,
        exclude_if=lambda sensor: sensor is None,
        description="Of the sensor whose raw responses the pictures are made of; absent: of linear Rec.709",
    )
    lost: Rle | None = Field(
        default=None, exclude_if=lambda mask: mask is None, description="Black pixels that were not rendered"
    )
    exposure: float | None = Field(
        gt=0.0,
        description="Factor from radiance to the linear value that sRGB encodes; null only in converted data sets",
    )
    balance: tuple[float, float, float] | Literal["grey-world"] = Field(
        default=(1.0, 1.0, 1.0),
        exclude_if=lambda balance: balance == (1.0, 1.0, 1.0),
        description="White balance of the ideal camera's 8-bit pictures: factors on red, green and blue",
    )
    white: float = Field(
        default=1.0,
        exclude_if=lambda white: white == 1.0,
        description="Linear value that the ideal camera's 8-bit pictures show as white",
    )
    grid_index: int | None = Field(
        description="Position in the 57-view grid: 0 zenith, then 4 rings of 14; null off the grid"
    )
    depth_camera: DepthCameraRecord | None = Field(
        default=None, exclude_if=lambda record: record is None, description="Of `sensor_depth.png`; absent without one"
    )
    polarisation_camera: PolarisationRecord | None = Field(
        default=None,
        exclude_if=lambda record: record is None,
        description="Of `polarisation_mosaic.png`; absent without one",
    )
    conventions: dict[str, str] = Field(description="What the numbers mean")


def depth_camera_record(
    device: DepthCamera, exposure: float, gain: float, reasons: tuple[str, ...]
) -> DepthCameraRecord:
    """Return the record of a depth camera: `exposure` [s] and `gain` are those of its infrared pictures."""
    first, second, third = (tuple(row) for row in device.K.tolist())
    return DepthCameraRecord(
        name=device.name,
        unit=device.unit,
        range=device.range,
        K=(first, second, third),
        width=device.imager.width,
        height=device.imager.height,
        baseline=device.baseline,
        camera_T_left=along_x(device.place),
        camera_T_right=along_x(device.place + device.baseline),
        camera_T_projector=along_x(device.place + device.projector.place),
        exposure=exposure,
        gain=gain,
        reasons=reasons,
    )


def time_of_flight_record(device: TimeOfFlightCamera, reasons: tuple[str, ...]) -> DepthCameraRecord:
    """Return the record of a time-of-flight camera."""
    first, second, third = (tuple(row) for row in device.K.tolist())
    return DepthCameraRecord(
        name=device.name,
        unit=device.unit,
        range=device.range,
        kind="tof",
        K=(first, second, third),
        width=device.width,
        height=device.height,
        camera_T_left=along_x(device.place),
        reasons=reasons,
    )


def camera_file(camera: Camera) -> CameraFile:
    """Return the record of a camera."""
    cx, cy = camera.centre
    return CameraFile(
        K=((camera.fx, 0.0, cx), (0.0, camera.fy, cy), (0.0, 0.0, 1.0)),
        width=camera.width,
        height=camera.height,
        world_T_camera=camera.world_T_camera,
        world_T_right=camera.world_T_right,
        baseline=camera.baseline,
        exposure=camera.exposure,
        balance=camera.balance,
        white=camera.white,
        grid_index=camera.grid_index,
        conventions=CONVENTIONS,
    )


def camera_of(record: CameraFile, where: object = "camera.json") -> Camera:
    """Return the stereo camera that a record describes.

    Parameters
    ----------
    record : CameraFile
        The record.
    where : object
        Its file, for the error.

    Raises
    ------
    InputError
        Where the record is of a single camera, or of one that is not calibrated.
    """
    (fx, _, cx), (_, fy, cy), _ = known_K(record, where)
    if record.baseline is None:
        raise InputError(where, "a stereo pair with its baseline", "one camera, of a converted data set")
    return Camera(
        width=record.width,
        height=record.height,
        focal=fx,
        focal_y=None if fy == fx else fy,
        centre=(cx, cy),
        world_T_camera=record.world_T_camera,
        baseline=record.baseline,
        # A photograph's is unknown, and its labels do not depend on it.
        exposure=1.0 if record.exposure is None else record.exposure,
        balance=record.balance,
        white=record.white,
        grid_index=record.grid_index,
    )


def known_K(record: CameraFile, where: object) -> tuple[Row3, Row3, Row3]:
    """Return the intrinsic matrix of a record; InputError where its camera is not calibrated."""
    if record.K is None:
        raise InputError(f"{where}: K", "a calibrated camera", "null: this data set has no calibration")
    return record.K
