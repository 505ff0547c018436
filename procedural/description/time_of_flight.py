"""A depth camera that measures the time of flight of a scanned laser beam, as data.

Lengths in metres, along the axes of the left colour camera (OpenCV's: x right, y down, z forward). The beam leaves and
returns at one place on the x axis, which looks along z.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from ...core.model import Model, Ordered
from .camera import Camera
from .depth_camera import DepthCamera, along_x

#: Reflectance of the surface that `TimeOfFlightCamera.reach` is stated for [1]: data sheets' white target.
WHITE = 0.95
#: Largest value of a 16-bit file.
_LARGEST = 65535


class TimeOfFlightCamera(Model):
    """A depth camera that sends one narrow beam along each pixel and times what comes back."""

    kind: Literal["tof"] = "tof"
    name: str = Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$", description="Name of the device")
    source: str = Field(default="", description="Where its figures come from")
    place: float = Field(description="x of the device, from the left colour camera [m]")
    width: int = Field(ge=16, le=4096, description="[px]")
    height: int = Field(ge=16, le=4096, description="[px]")
    focal: float = Field(gt=0.0, description="Focal length [px]")
    centre: tuple[float, float] | None = Field(default=None, description="Principal point [px]; none: the middle")
    wavelength: float = Field(ge=380.0, le=2500.0, description="Of the laser [nm]")
    beam: float = Field(ge=0.0, le=0.1, description="Full angle of the beam where it has 1/e^2 of its intensity [rad]")
    returns: Literal["first", "strongest"] = Field(
        default="strongest", description="Which of several returns is reported"
    )
    pulse: float = Field(
        gt=0.0, le=10.0, description="Distance of two surfaces from which on their returns are told apart [m]"
    )
    reach: float = Field(
        gt=0.0, description="Distance up to which a matte surface of reflectance 0.95 that faces the device returns [m]"
    )
    error: Annotated[tuple[float, float], Ordered] = Field(
        description="Standard deviation of strong returns, and of the weakest, which are those at `reach` [m]"
    )
    range: Annotated[tuple[float, float], Ordered] = Field(description="Depths that are reported [m]")
    unit: float = Field(gt=0.0, le=0.1, description="Of the reported depth [m]")

    @model_validator(mode="after")
    def _numbers_fit(self) -> TimeOfFlightCamera:
        low, high = self.range
        if low <= 0.0 or high == low:
            raise ValueError(f"range: expected two different depths above 0, found {self.range}")
        if high > _LARGEST * self.unit:
            most = _LARGEST * self.unit
            raise ValueError(f"range: expected at most {most:g} m, as 16 bits hold in this unit, found {high:g}")
        if self.error[0] < 0.0:
            raise ValueError(f"error: expected no negative number, found {self.error}")
        return self

    @property
    def least(self) -> float:
        """The weakest return that is measured [1/m^2]: reflectance times cosine, over the squared distance."""
        return WHITE / self.reach**2

    @property
    def K(self) -> np.ndarray:
        """Intrinsic matrix, (3, 3) float64 [px]."""
        cx, cy = self.centre or ((self.width - 1) / 2.0, (self.height - 1) / 2.0)
        return np.array([[self.focal, 0.0, cx], [0.0, self.focal, cy], [0.0, 0.0, 1.0]])

    def scanner(self, camera: Camera) -> Camera:
        """Return the device of a view as a camera, of which the left eye counts."""
        (_, _, cx), (_, _, cy), _ = self.K.tolist()
        return camera.model_copy(
            update={
                "width": self.width,
                "height": self.height,
                "focal": self.focal,
                "focal_y": None,
                "centre": (cx, cy),
                "world_T_camera": camera.world_T_camera @ along_x(self.place),
            }
        )


#: What a scene may have beside its left colour camera.
DepthDevice: TypeAlias = DepthCamera | TimeOfFlightCamera
