"""An active stereo depth camera, as data: two infrared cameras, a projector of dots, and a matcher.

Lengths in metres, along the axes of the left colour camera (OpenCV's: x right, y down, z forward). All three parts of
the device look along z; they stand on the x axis.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from ...core.assets import Asset
from ...core.model import Model, Ordered
from .camera import Camera

#: Of `Matching.disparities`: OpenCV takes multiples of this number.
DISPARITY_STEP = 16
#: Largest value of a 16-bit file.
_LARGEST = 65535
#: Of a picture's width or height.
Part = Annotated[float, Field(ge=0.0, le=1.0)]


class InfraredImager(Model):
    """One of the two infrared cameras: a pinhole, and the photon transfer of its pixels."""

    width: int = Field(ge=16, le=4096, description="[px]")
    height: int = Field(ge=16, le=4096, description="[px]")
    focal: float = Field(gt=0.0, description="Focal length [px]")
    centre: tuple[float, float] | None = Field(default=None, description="Principal point [px]; none: the middle")
    blur: float = Field(
        default=0.0, ge=0.0, le=8.0, description="Standard deviation of the lens' and resampling's [px]"
    )
    aperture: float = Field(gt=0.0, description="f-number")
    pitch: float = Field(gt=0.0, le=1e-3, description="Width of a pixel of the stream, as an area of silicon [m]")
    efficiency: float = Field(gt=0.0, le=1.0, description="Electrons for each photon that meets the lens")
    full_well: float = Field(gt=0.0, description="Electrons of a saturated pixel at gain 1 [e-]")
    read_noise: float = Field(ge=0.0, description="Standard deviation of the read noise [e-]")
    bits: int = Field(default=8, ge=6, le=16, description="Of the pictures that are matched")
    exposure: Annotated[tuple[float, float], Ordered] = Field(description="Range of the exposure time [s]")
    gain: float = Field(default=1.0, ge=1.0, le=256.0, description="Largest analogue gain, where time does not suffice")
    target: float = Field(gt=0.0, lt=1.0, description="Mean of the pictures that exposure aims at, of the full scale")
    region: tuple[Part, Part, Part, Part] = Field(
        default=(0.0, 0.0, 1.0, 1.0),
        description="Left, upper, right and lower edge of what exposure looks at, of the left picture's size",
    )
    efficacy: float = Field(
        gt=0.0, description="Light of lamps for each watt of it that the pixels see; it turns luminance to power [lm/W]"
    )
    daylight_efficacy: float = Field(default=150.0, gt=0.0, description="The same of daylight [lm/W]")

    @model_validator(mode="after")
    def _region_has_an_area(self) -> InfraredImager:
        left, top, right, bottom = self.region
        if not (left < right and top < bottom):
            raise ValueError(f"region: expected left before right and upper before lower, found {self.region}")
        return self


class PatternProjector(Model):
    """A projector of dots: a point that sends the same power into each of them."""

    place: float = Field(description="x of the projector, from the left infrared camera [m]")
    field: tuple[float, float] = Field(description="Full angles across and down that dots fill [rad]")
    power: float = Field(ge=0.0, description="Mean radiant power of all dots [W]; 0: off")
    wavelength: float = Field(ge=380.0, le=2500.0, description="[nm]")
    dots: int = Field(ge=1, le=200_000, description="Number of dots")
    dot: float = Field(gt=0.0, le=0.1, description="Full width of a dot at half its height [rad]")
    picture: Asset | None = Field(
        default=None,
        exclude_if=lambda picture: picture is None,
        description="Picture of the pattern, in place of drawn dots: it fills the field, in the plane at distance 1",
    )
    turn: float = Field(default=0.0, ge=0.0, description="Largest angle by which a unit's pattern is turned [rad]")

    @model_validator(mode="after")
    def _field_is_less_than_half_a_sphere(self) -> PatternProjector:
        if not all(0.0 < angle < 0.95 * math.pi for angle in self.field):
            raise ValueError(f"field: expected two angles above 0 and below 171deg, found {self.field}")
        return self


class Matching(Model):
    """How depth is found in the two pictures: semi-global matching with sub-pixel steps."""

    disparities: int = Field(ge=DISPARITY_STEP, le=1024, description="Disparities that are searched, from 0 on [px]")
    block: int = Field(ge=3, le=21, description="Width of the window that is compared, odd [px]")
    uniqueness: int = Field(ge=0, le=100, description="Least margin of the best match before the second one [%]")
    left_right: int = Field(ge=0, le=64, description="Largest difference of the matches from left and right [px]")
    speckle: int = Field(ge=0, description="Islands of at most so many pixels are removed [px]")
    texture: float = Field(ge=0.0, description="Least standard deviation of a window's grey levels, of its noise's")
    step: float = Field(gt=0.0, le=1.0, description="Smallest difference of disparities [px]")

    @model_validator(mode="after")
    def _as_the_matcher_takes_them(self) -> Matching:
        if self.disparities % DISPARITY_STEP:
            raise ValueError(f"disparities: expected a multiple of {DISPARITY_STEP}, found {self.disparities}")
        if self.block % 2 == 0:
            raise ValueError(f"block: expected an odd number, found {self.block}")
        return self


class DepthCamera(Model):
    """An active stereo depth camera beside the left colour camera."""

    name: str = Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$", description="Name of the device")
    source: str = Field(default="", description="Where its figures come from")
    baseline: float = Field(gt=0.0, le=10.0, description="From the left to the right infrared camera [m]")
    place: float = Field(description="x of the left infrared camera, from the left colour camera [m]")
    imager: InfraredImager
    projector: PatternProjector
    matching: Matching
    range: Annotated[tuple[float, float], Ordered] = Field(description="Depths that are reported [m]")
    unit: float = Field(gt=0.0, le=0.1, description="Of the reported depth [m]")
    samples: int = Field(default=16, ge=1, le=4096, description="Light paths of each infrared pixel")

    @model_validator(mode="after")
    def _range_fits(self) -> DepthCamera:
        low, high = self.range
        if low <= 0.0 or high == low:
            raise ValueError(f"range: expected two different depths above 0, found {self.range}")
        if high > _LARGEST * self.unit:
            most = _LARGEST * self.unit
            raise ValueError(f"range: expected at most {most:g} m, as 16 bits hold in this unit, found {high:g}")
        return self

    @property
    def centre(self) -> tuple[float, float]:
        """Principal point of the infrared cameras [px]."""
        imager = self.imager
        return imager.centre or ((imager.width - 1) / 2.0, (imager.height - 1) / 2.0)

    @property
    def K(self) -> np.ndarray:
        """Intrinsic matrix of the infrared cameras, (3, 3) float64 [px]."""
        (cx, cy), focal = self.centre, self.imager.focal
        return np.array([[focal, 0.0, cx], [0.0, focal, cy], [0.0, 0.0, 1.0]])

    def infrared_pair(self, camera: Camera) -> Camera:
        """Return the two infrared cameras of a view, as a stereo pair; its exposure is the colour camera's."""
        return camera.model_copy(
            update={
                "width": self.imager.width,
                "height": self.imager.height,
                "focal": self.imager.focal,
                "focal_y": None,
                "centre": self.centre,
                "world_T_camera": camera.world_T_camera @ along_x(self.place),
                "baseline": self.baseline,
            }
        )

    def world_T_projector(self, camera: Camera) -> np.ndarray:
        """Return the projector's pose in a view, (4, 4) float64; it looks along z as the cameras do."""
        return camera.world_T_camera @ along_x(self.place + self.projector.place)


def along_x(shift: float) -> np.ndarray:
    """Return the pose of what stands along x [m], with the same axes."""
    pose = np.eye(4)
    pose[0, 3] = shift
    return pose
