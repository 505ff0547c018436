"""Depth cameras by name, and from YAML files."""

from __future__ import annotations

import math
from pathlib import Path

from ...core.assets import asset
from ...core.errors import InputError
from ...core.setting_errors import shortened
from ..description.depth_camera import DepthCamera, InfraredImager, Matching, PatternProjector
from ..description.time_of_flight import DepthDevice, TimeOfFlightCamera
from .devices import LIKE, NONE, device_fields, is_device_file, named_device, own_device
from .pattern_picture import pattern_picture
from .time_of_flight import TIME_OF_FLIGHT_CAMERAS

#: Value of `kind` of time-of-flight cameras; others have none.
_TIMED = "tof"
#: Where a figure that both devices share comes from.
_SHARED = (
    "projector: 360 mW on average, class 1, 850 nm (D400 data sheet); 6,437 dots, as counted in the picture of its "
    "pattern in SAPIEN; nearest depth f b / 126 (126 disparities are searched); millimetres, as the driver reports; "
    "exposure by the mean of a region in the middle of the picture (Intel's tuning guide for the D400 series, and "
    "librealsense issue 10940), of which half of each side is assumed; also assumed: quantum efficiency with lens, "
    "full well and read noise of sensors of this size, target of the exposure, width of a dot (three pixels of the "
    "depth stream), ambient light of 300 lm/W (white LEDs have 280 to 350; 400 to 1000 nm of daylight 150). Matching: "
    "windows of 9 px (ClearGrasp's settings of a D400), steps of 1/32 px; the "
    "margin of the best match is fitted to how much ClearGrasp's captures lack on glass; the rest by OpenCV's advice"
)
# The middle half of the picture, across and down: exposure looks at it.
_MIDDLE = (0.25, 0.25, 0.75, 0.75)
# Matching of both devices; `_SHARED` says where its figures come from.
_MATCHING = Matching(disparities=128, block=9, uniqueness=40, left_right=1, speckle=60, texture=2.0, step=1.0 / 32.0)
#: By name.
DEPTH_CAMERAS: dict[str, DepthCamera] = {
    "d415": DepthCamera(
        name="d415",
        source="Intel RealSense D415: 446.31 px at 640x360 (DREDS, ECCV 2022; units 444 to 451), here at 1280x720; "
        "55 mm, 15 mm beside the colour camera, 0.45 to 10 m (D400 data sheet); projector 41 mm from the left camera "
        "(D3RoMa); pixels of 1.4 um of a 1920x1080 sensor, f/2.0; " + _SHARED,
        baseline=0.055,
        place=0.015,
        imager=InfraredImager(
            width=1280,
            height=720,
            focal=892.62,
            blur=0.5,
            aperture=2.0,
            pitch=1.4e-6 * 1920 / 1280,
            efficiency=0.25,
            full_well=6500.0,
            read_noise=4.0,
            exposure=(1e-5, 0.033),
            gain=16.0,
            target=0.35,
            region=_MIDDLE,
            efficacy=300.0,
        ),
        projector=PatternProjector(
            place=0.041,
            field=(math.radians(67.0), math.radians(41.0)),
            power=0.36,
            wavelength=850.0,
            dots=6437,
            dot=3.0 / 892.62,
            turn=math.radians(1.0),
        ),
        matching=_MATCHING,
        range=(0.40, 10.0),
        unit=0.001,
        samples=4,
    ),
    "d435": DepthCamera(
        name="d435",
        source="Intel RealSense D435: 430.14 px at 848x480, its best depth mode (a unit's calibration); 50 mm, 15 mm "
        "beside the colour camera, 0.17 to 10 m, projector of 86 x 57 degrees 44 mm beside the colour camera (D400 "
        "data sheet); pixels of 3 um of a 1280x800 sensor, f/2.0; " + _SHARED,
        baseline=0.050,
        place=0.015,
        imager=InfraredImager(
            width=848,
            height=480,
            focal=430.14,
            centre=(425.16, 235.28),
            blur=0.5,
            aperture=2.0,
            pitch=3.0e-6 * 1280 / 848,
            efficiency=0.25,
            full_well=12000.0,
            read_noise=4.0,
            exposure=(1e-5, 0.033),
            gain=16.0,
            target=0.35,
            region=_MIDDLE,
            efficacy=300.0,
        ),
        projector=PatternProjector(
            place=0.029,
            field=(math.radians(86.0), math.radians(57.0)),
            power=0.36,
            wavelength=850.0,
            dots=6437,
            dot=3.0 / 430.14,
            turn=math.radians(1.0),
        ),
        matching=_MATCHING,
        range=(0.17, 10.0),
        unit=0.001,
        samples=8,
    ),
}
_DEVICES: dict[str, DepthDevice] = {**DEPTH_CAMERAS, **TIME_OF_FLIGHT_CAMERAS}


def depth_camera(name: str | Path, where: str = "sensors.depth") -> DepthDevice | None:
    """Return a depth camera by its name, or from a YAML file; None for ``none``.

    Parameters
    ----------
    name : str or Path
        A device, ``none``, or a file that ends in ``.yaml`` or ``.yml``: fields of `DepthCamera` or, with the `kind`
        ``tof``, of `TimeOfFlightCamera`, on top of those of the device that its ``like`` names.
    where : str
        The setting, for errors.

    Raises
    ------
    InputError
        Where there is no such device, or the file cannot be read or has a wrong field.
    """
    text = str(name)
    if text == NONE:
        return None
    if not is_device_file(text):
        return named_device(_DEVICES, text, where, f"{NONE}, or a YAML file")
    given, like = device_fields(text, where)
    below = {} if like is None else named_device(_DEVICES, like, f"{text}: {LIKE}").model_dump()
    kind = _kind(text, given, below)
    _take_picture(given, text)
    fields = _merged(below | {"name": "own", "source": ""}, given)
    return own_device(text, kind, fields, None if like else "l515" if kind is TimeOfFlightCamera else "d435")


def _kind(path: str, given: dict, below: dict) -> type[DepthCamera] | type[TimeOfFlightCamera]:
    """Return the model of a file's device: time of flight where the file or the device below it says so."""
    kind = given.get("kind", below.get("kind"))
    if kind is None:
        return DepthCamera
    if kind != _TIMED:
        raise InputError(f"{path}: kind", f"{_TIMED} for time of flight, or none for stereo", shortened(kind))
    if below and below.get("kind") != _TIMED:
        raise InputError(f"{path}: kind", f"none with {LIKE}: {below['name']}, which is a stereo camera", _TIMED)
    return TimeOfFlightCamera


def _take_picture(given: dict, path: str) -> None:
    """Put the record of a pattern's picture in place of its path, which begins at the folder of the YAML file."""
    projector = given.get("projector")
    if not isinstance(projector, dict) or projector.get("picture") is None:
        return
    name = projector["picture"]
    if not isinstance(name, str):
        raise InputError(f"{path}: projector.picture", "the path of a picture", shortened(name))
    picture = Path(path).parent / name
    pattern_picture(picture)
    projector["picture"] = asset(picture)


def _merged(below: dict, above: dict) -> dict:
    """Return fields with others on top; those of imager, projector and matching one by one."""
    nested = {
        name: below[name] | value
        for name, value in above.items()
        if isinstance(below.get(name), dict) and isinstance(value, dict)
    }
    return below | above | nested
