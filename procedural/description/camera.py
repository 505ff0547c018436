"""A stereo camera, as data."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from ...core.images import Tone
from ...core.model import Matrix4, Model

#: Longest side of a picture [px], as `CameraSettings` allows it; the product of two is 2^28 pixels.
LONGEST_SIDE = 16384


class Camera(Model):
    """A stereo pair of pinhole cameras with OpenCV axes (x right, y down, z forward).

    Pixel (0, 0) has its centre at image coordinate (0, 0). The right camera stands at ``+baseline`` along the left
    camera's x axis and has the same axes.
    """

    width: int = Field(ge=1, description="[px]")
    height: int = Field(ge=1, description="[px]")
    focal: float = Field(gt=0.0, description="Focal length along x, and along y as well without `focal_y` [px]")
    focal_y: float | None = Field(
        default=None, gt=0.0, exclude_if=lambda y: y is None, description="Focal length along y where it differs [px]"
    )
    centre: tuple[float, float] = Field(description="Principal point (cx, cy) [px]")
    world_T_camera: Matrix4 = Field(description="Pose of the left camera")
    baseline: float = Field(gt=0.0, description="Distance between the two cameras [m]")
    exposure: float = Field(gt=0.0, description="Factor from radiance to the linear value that sRGB encodes")
    balance: tuple[float, float, float] | Literal["grey-world"] = Field(
        default=(1.0, 1.0, 1.0),
        exclude_if=lambda balance: balance == (1.0, 1.0, 1.0),
        description="White balance of the 8-bit pictures: factors on red, green, blue, or by the left picture's mean",
    )
    white: float = Field(
        default=1.0,
        ge=1.0,
        le=1e3,
        exclude_if=lambda white: white == 1.0,
        description="Linear value that is encoded as white in the 8-bit pictures; above 1 highlights are compressed",
    )
    grid_index: int | None = Field(
        ge=0, le=56, description="Position in the 57-view grid: 0 zenith, then 4 rings of 14; None off the grid"
    )

    @property
    def fx(self) -> float:
        """Focal length along x [px]."""
        return self.focal

    @property
    def fy(self) -> float:
        """Focal length along y [px]."""
        return self.focal if self.focal_y is None else self.focal_y

    @property
    def tone(self) -> Tone:
        """White balance and highlights of the 8-bit pictures."""
        return Tone(self.balance, self.white)

    @property
    def K(self) -> np.ndarray:
        """Intrinsic matrix, (3, 3) float64 [px]."""
        cx, cy = self.centre
        return np.array([[self.fx, 0.0, cx], [0.0, self.fy, cy], [0.0, 0.0, 1.0]])

    @property
    def world_T_right(self) -> np.ndarray:
        """Pose of the right camera, (4, 4) float64."""
        shift = np.eye(4)
        shift[0, 3] = self.baseline
        return self.world_T_camera @ shift
