"""Colour cameras by name, and from YAML files."""

from __future__ import annotations

from pydantic import ValidationError

from ...core.errors import InputError
from ...core.setting_errors import setting_error, shortened, suggest
from ...core.yaml_file import yaml_settings
from .model import ColourCamera, Distortion, Sensor

#: From CIE XYZ to the sensor of a Nexus 6P (Sony IMX377, pixels of 1.55 um), by Brooks et al., Unprocessing Images for
#: Learned Raw Denoising, CVPR 2019. The nearest published one for the other small sensors as well.
_SMALL_SENSOR = ((1.0234, -0.2969, -0.2266), (-0.5625, 1.6328, -0.0469), (-0.0703, 0.2188, 0.6406))
#: Full well of small pixels [e-/um^2], read noise [e-] at the gains of indoor pictures, and black level, measured on
#: a Sony IMX477 (pixels of 1.55 um): 8180 e- and 3 e- at gain 1, 1.5 e- at gain 16, 256 of 4095
#: (strollswithmydog.com, Pi HQ Cam Sensor Performance).
_WELL, _READ_NOISE, _BLACK = 3400.0, 2.0, 0.0625

#: By name.
CAMERAS: dict[str, ColourCamera] = {
    "ideal": ColourCamera(source="the sRGB curve of radiance times exposure, clipped"),
    "d435": ColourCamera(
        name="d435",
        source="Intel RealSense D435, colour camera: 1920x1080 pixels of 1.4 um, f/2.0, f 1.88 mm, fixed focus, and a "
        "stream without distortion by its own calibration (D400 data sheet and units); full well and noise of a Sony "
        "IMX477 by area; assumed: focus at the hyperfocal distance of a circle of two pixels, gain, white balance",
        exposure_error=0.3,
        brightest_median=0.7,
        aperture=0.00094,
        focus=0.63,
        falloff=4.0,
        shading_correction=0.7,
        xyz_to_sensor=_SMALL_SENSOR,
        white_balance=0.5,
        white_balance_error=0.03,
        sensor=Sensor(
            width=1920, full_well=_WELL * 1.4**2, read_noise=_READ_NOISE, gain=(2.0, 8.0), bits=10, black_level=_BLACK
        ),
    ),
    "phone": ColourCamera(
        name="phone",
        source="Nexus 6P: 4032 pixels of 1.55 um across, f/2.0, f 4.67 mm, autofocus; full well and noise of a Sony "
        "IMX477, whose pixels have that size; assumed: gain, white balance, tone, JPEG; distortion is corrected",
        exposure_error=0.2,
        brightest_median=0.7,
        aperture=0.00234,
        falloff=4.0,
        shading_correction=0.85,
        xyz_to_sensor=_SMALL_SENSOR,
        white_balance=0.6,
        white_balance_error=0.02,
        sensor=Sensor(
            width=4032, full_well=_WELL * 1.55**2, read_noise=_READ_NOISE, gain=(1.0, 8.0), bits=10, black_level=_BLACK
        ),
        contrast=0.5,
        jpeg_quality=95,
    ),
    "webcam": ColourCamera(
        name="webcam",
        source="USB webcam: f/2.0, f 3.67 mm, 2304 pixels of 2.08 um across (a sensor of 1/3 inch), autofocus; "
        "distortion by a ROS calibration at 640x480 (davi1055/project, cam_480p); full well and noise of a Sony IMX477 "
        "by area; assumed: the mode of few pixels skips rows and columns, gain, white balance, tone, JPEG",
        exposure_error=0.4,
        brightest_median=0.7,
        aperture=0.00184,
        distortion=Distortion(k1=0.134462, k2=-0.311908, p1=0.002304, p2=0.003083),
        falloff=4.0,
        shading_correction=0.4,
        xyz_to_sensor=_SMALL_SENSOR,
        white_balance=0.8,
        white_balance_error=0.06,
        sensor=Sensor(
            width=1, full_well=_WELL * 2.08**2, read_noise=_READ_NOISE, gain=(4.0, 16.0), bits=10, black_level=_BLACK
        ),
        contrast=0.3,
        jpeg_quality=80,
    ),
}
#: What a YAML file may name to begin with a preset's figures.
_LIKE = "like"


def colour_camera(name: str, where: str = "--camera") -> ColourCamera:
    """Return a camera by its name, or from a YAML file.

    Parameters
    ----------
    name : str
        A preset, or the path of a file that ends in ``.yaml`` or ``.yml``: fields of `ColourCamera`, on top of those of
        the preset that its ``like`` names, else of the ideal camera.
    where : str
        The option, for errors.

    Raises
    ------
    InputError
        Where there is no such camera, or the file cannot be read or has a wrong field.
    """
    if not name.endswith((".yaml", ".yml")):
        return _preset(name, where, ", or a YAML file")
    given = yaml_settings(name, where)
    below = _preset(str(given.pop(_LIKE, "ideal")), f"{name}: {_LIKE}").model_dump()
    below |= {"name": "own", "source": ""}
    try:
        return ColourCamera.model_validate(_merged(below, given))
    except ValidationError as error:
        raise setting_error(name, error, ColourCamera) from error


def _preset(name: str, where: str, other: str = "") -> ColourCamera:
    if name not in CAMERAS:
        expected = f"one of {', '.join(CAMERAS)}{other}{suggest(name.lower(), list(CAMERAS))}"
        raise InputError(where, expected, shortened(name))
    return CAMERAS[name]


def _merged(below: dict, above: dict) -> dict:
    """Return fields with others on top; those of distortion and sensor one by one."""
    nested = {name: below[name] | value for name, value in above.items() if _both(below.get(name), value)}
    return below | above | nested


def _both(below: object, above: object) -> bool:
    return isinstance(below, dict) and isinstance(above, dict)
