"""Settings of sensors: those beside the colour cameras, and the sensitivities of these."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from pydantic import Field, field_validator

from ...core.errors import InputError
from ...core.model import Model
from ...core.user_text import UserPath
from .depth_cameras import depth_camera
from .polarisation_cameras import polarisation_camera
from .sensitivities import check_sensitivities

#: The settings, as errors of what reads them name them.
_DEPTH, _POLARISATION, _SENSITIVITIES = "sensors.depth: ", "sensors.polarisation: ", "sensors.sensitivities: "


class SensorSettings(Model):
    """What measures a scene beside the colour cameras."""

    depth: Literal["none", "d415", "d435", "l515"] | UserPath = Field(
        default="none",
        description="Depth camera beside the left colour camera: none, d415, d435, l515, or a YAML file of a device "
        "of your own (docs/sensors.md)",
    )

    polarisation: Literal["none", "imx250mzr", "imx250myr"] | UserPath = Field(
        default="none",
        description="Polarisation camera in the place of the left colour camera: none, imx250mzr, imx250myr (in "
        "colour), or a YAML file of a device of your own (docs/polarisation.md)",
    )

    sensitivities: Literal["none", "nikon-d5100", "sigma-sd-merrill"] | UserPath = Field(
        default="none",
        description="Spectral sensitivities of the colour cameras' sensors, for `picture.spectral`: none, nikon-d5100, "
        "sigma-sd-merrill, or a CSV file of your own; needs the extra `colour` (docs/cameras.md)",
    )

    carbon_black: float | None = Field(
        default=None,
        ge=0.0,
        le=1.0,
        description="Probability that what is grey or black is so by carbon black, which is black to depth cameras as "
        "well; none: by what it is made of",
    )

    @field_validator("depth")
    @classmethod
    def _is_known(cls, depth: object) -> object:
        _check(depth_camera, depth, _DEPTH)
        return depth

    @field_validator("polarisation")
    @classmethod
    def _is_known_polarisation(cls, polarisation: object) -> object:
        _check(polarisation_camera, polarisation, _POLARISATION)
        return polarisation

    @field_validator("sensitivities")
    @classmethod
    def _are_known(cls, sensitivities: object) -> object:
        _check(check_sensitivities, sensitivities, _SENSITIVITIES)
        return sensitivities


def _check(read: Callable[[str], object], value: object, where: str) -> None:
    """Raise ValueError where a device of the setting `where` is not known, InputError where its file is wrong."""
    try:
        read(str(value))
    except InputError as error:
        if str(error).startswith(where):  # the field is named by whoever reports it
            raise ValueError(str(error).removeprefix(where)) from error
        raise
