"""A stereo camera, as data."""

from __future__ import annotations

import numpy as np
from pydantic import Field

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
    focal: float = Field(gt=0.0, description="Focal length, both directions [px]")
    centre: tuple[float, float] = Field(description="Principal point (cx, cy) [px]")
    world_T_camera: Matrix4 = Field(description="Pose of the left camera")
    baseline: float = Field(gt=0.0, description="Distance between the two cameras [m]")
    exposure: float = Field(gt=0.0, description="Factor from radiance to the linear value that sRGB encodes")
    grid_index: int = Field(ge=0, le=56, description="Position in the 57-view grid: 0 zenith, then 4 rings of 14")

    @property
    def K(self) -> np.ndarray:
        """Intrinsic matrix, (3, 3) float64 [px]."""
        cx, cy = self.centre
        return np.array([[self.focal, 0.0, cx], [0.0, self.focal, cy], [0.0, 0.0, 1.0]])

    @property
    def world_T_right(self) -> np.ndarray:
        """Pose of the right camera, (4, 4) float64."""
        shift = np.eye(4)
        shift[0, 3] = self.baseline
        return self.world_T_camera @ shift
