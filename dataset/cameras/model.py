"""A colour camera, as data: lens, sensor and processing. What each step does is in the modules beside this one."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, field_validator

from ...core.model import Model, Ordered, Unit
from ...core.units import LENGTH, Length

_Row = tuple[float, float, float]
_Positive = Annotated[float, Field(gt=0.0)]
#: CIE XYZ of daylight, D65 (CIE 15:2018, table 11.1, 2 degrees, Y = 1).
_DAYLIGHT = np.array([0.95047, 1.0, 1.08883])
#: Distortion coefficients in OpenCV's order: k1, k2, p1, p2, k3.
Coefficients = tuple[float, float, float, float, float]


class Distortion(Model):
    """Coefficients of the lens distortion of Brown (1966) and Conrady (1919), as OpenCV orders and applies them."""

    k1: float = Field(default=0.0, description="Radial, of the second power of the radius")
    k2: float = Field(default=0.0, description="Radial, of the fourth power")
    p1: float = Field(default=0.0, description="Tangential")
    p2: float = Field(default=0.0, description="Tangential")
    k3: float = Field(default=0.0, description="Radial, of the sixth power")

    @property
    def absent(self) -> bool:
        """Whether the lens does not distort."""
        return not any(self.coefficients)

    @property
    def coefficients(self) -> Coefficients:
        """All coefficients, in OpenCV's order."""
        return self.k1, self.k2, self.p1, self.p2, self.k3

    @classmethod
    def of(cls, coefficients: Coefficients) -> Distortion:
        """Return the distortion of these coefficients."""
        k1, k2, p1, p2, k3 = coefficients
        return cls(k1=k1, k2=k2, p1=p1, p2=p2, k3=k3)

    def scaled(self, factor: float) -> Distortion:
        """Return a weaker or stronger distortion of the same kind."""
        return Distortion(**{name: factor * value for name, value in self.model_dump().items()})


class Sensor(Model):
    """Photon transfer of a sensor with a Bayer mosaic (Janesick, Photon Transfer, SPIE 2007)."""

    width: int = Field(ge=1, description="Pixels across, of which those of the picture are sums; 1: it skips them [px]")
    full_well: float = Field(gt=0.0, description="Electrons of a saturated pixel at gain 1 [e-]")
    read_noise: float = Field(ge=0.0, description="Standard deviation of the read noise of a pixel [e-]")
    gain: Annotated[tuple[_Positive, _Positive], Ordered] = Field(
        default=(1.0, 1.0), description="Range of the analogue gain, drawn per view; it divides the full well"
    )
    bits: int = Field(default=10, ge=6, le=16, description="Of the analogue-to-digital converter")
    black_level: float = Field(
        default=0.0625, ge=0.0, lt=1.0, description="Value of a pixel without light, as a fraction of the scale"
    )


class SensorColour(Model):
    """What the raw responses of a sensor of measured sensitivities mean: in the place of a camera's own primaries."""

    name: str = Field(description="Name of the sensor")
    white: tuple[_Positive, _Positive, _Positive] = Field(
        description="Signals of light like D65, over that of green; its raw response is 1 in each channel"
    )
    matrix: tuple[_Row, _Row, _Row] = Field(
        description="From raw responses in light like D65 to linear Rec.709; rows sum to 1"
    )


class ColourCamera(Model):
    """What turns radiance into a picture; without arguments, the ideal camera."""

    name: str = Field(default="ideal", pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$", description="Name of the camera")
    source: str = Field(default="", description="Where its figures come from")
    exposure_error: float = Field(default=0.0, ge=0.0, le=4.0, description="Standard deviation, per view [stops]")
    brightest_median: float | None = Field(
        default=None,
        gt=0.0,
        description="Greatest median over a view of its pixels' brightest channel, of saturation: brighter views are "
        "exposed less; none: all views of a scene are exposed alike",
    )
    aperture: Length = Field(
        default=0.0, ge=0.0, lt=1.0, description="Diameter of the entrance pupil; 0: a pinhole [m]"
    )
    focus: Annotated[float, Field(gt=0.0), LENGTH] | None = Field(
        default=None, description="Distance in focus [m]; none: the middle of the view (autofocus)"
    )
    distortion: Distortion = Field(default=Distortion(), description="Of the lens")
    rectified: bool = Field(
        default=True, description="Whether the picture is resampled to that of a pinhole, to which labels belong"
    )
    falloff: float = Field(
        default=0.0, ge=0.0, le=8.0, description="Power of the cosine by which light falls off to the corners; 4 in air"
    )
    shading_correction: Unit = Field(default=0.0, description="Fraction of the fall-off that is corrected digitally")
    xyz_to_sensor: tuple[_Row, _Row, _Row] | None = Field(
        default=None,
        description="From CIE XYZ to red, green, blue of the sensor; none: it has the primaries of Rec.709",
    )
    white_balance: Unit = Field(default=0.0, description="Fraction of the light's colour that is balanced; 0: daylight")
    white_balance_error: float = Field(
        default=0.0, ge=0.0, le=0.5, description="Standard deviation of the logarithms of red and blue gain, per view"
    )
    sensor: Sensor | None = Field(default=None, description="Mosaic and noise; none: every pixel sees three colours")
    contrast: Unit = Field(default=0.0, description="Fraction of a smooth step in the tone curve, on top of sRGB's")
    jpeg_quality: int | None = Field(default=None, ge=1, le=100, description="Compression; none: lossless")

    @field_validator("xyz_to_sensor")
    @classmethod
    def _has_a_way_back(cls, matrix: tuple[_Row, _Row, _Row] | None) -> tuple[_Row, _Row, _Row] | None:
        if matrix is None:
            return None
        white = np.array(matrix) @ _DAYLIGHT
        if not (white > 0.0).all():
            values = ", ".join(f"{value:.4g}" for value in white)
            raise ValueError(f"expected a matrix that gives daylight three signals above 0, found {values}")
        if np.linalg.matrix_rank(np.array(matrix)) < 3:
            raise ValueError("expected a matrix that can be inverted, found colours that look alike to the sensor")
        return matrix

    @property
    def ideal(self) -> bool:
        """Whether it does nothing but expose and encode."""
        plain = ColourCamera(name=self.name, source=self.source)
        return self.model_copy(update={"focus": None, "rectified": True, "shading_correction": 0.0}) == plain
