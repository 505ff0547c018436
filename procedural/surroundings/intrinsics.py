"""Intrinsics of drawn cameras: size, focal lengths and principal point, and the distance at which they show a ball.

Pixel (0, 0) has its centre at image coordinate (0, 0), as in OpenCV and librealsense: the middle of a picture w pixels
wide is at (w - 1) / 2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..description.camera import Camera


@dataclass(frozen=True)
class Intrinsics:
    """A pinhole camera without its pose; sizes and lengths in pixels."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def resized(self, width: int, height: int) -> Intrinsics:
        """Return the same field of view at another size: the edges of the picture stay where they are."""
        across, down = width / self.width, height / self.height
        return Intrinsics(
            width=width,
            height=height,
            fx=self.fx * across,
            fy=self.fy * down,
            cx=(self.cx + 0.5) * across - 0.5,
            cy=(self.cy + 0.5) * down - 0.5,
        )

    def half_angles(self) -> tuple[float, float, float, float]:
        """Return the angles from the optical axis to the left, right, upper and lower edge [rad]."""
        left, right = (self.cx + 0.5) / self.fx, (self.width - 0.5 - self.cx) / self.fx
        up, down = (self.cy + 0.5) / self.fy, (self.height - 0.5 - self.cy) / self.fy
        return math.atan(left), math.atan(right), math.atan(up), math.atan(down)

    def camera(
        self, world_T_camera: np.ndarray, baseline: float, exposure: float, grid_index: int | None = None
    ) -> Camera:
        """Return the stereo camera with these intrinsics at a pose."""
        return Camera(
            width=self.width,
            height=self.height,
            focal=self.fx,
            focal_y=None if self.fy == self.fx else self.fy,
            centre=(self.cx, self.cy),
            world_T_camera=world_T_camera,
            baseline=baseline,
            exposure=exposure,
            grid_index=grid_index,
        )


def fit_distance(lens: Intrinsics, baseline: float, radius: float, tilt: float = 0.0) -> float:
    """Return the shortest distance at which a sphere lies inside both pictures of a stereo pair.

    The left camera looks at the sphere's centre, or up to `tilt` past it. The sphere is inside where its centre is at
    least ``radius`` away from each side plane of the view. For the left camera this is d sin(a - tilt) >= r with the
    angles a from the axis to the edges; the right camera sees the centre ``baseline`` farther left:
    d sin(a - tilt) - b cos(a) >= r.

    Parameters
    ----------
    lens : Intrinsics
        The camera; `tilt` is smaller than each of its `half_angles`.
    baseline : float
        Distance between the cameras [m].
    radius : float
        Radius of the sphere [m].
    tilt : float
        Largest angle between the optical axis and the direction to the sphere's centre [rad].

    Returns
    -------
    float
        Distance from the left eye to the sphere's centre [m].
    """
    left, right, up, down = lens.half_angles()
    across = (radius + baseline * math.cos(left)) / math.sin(left - tilt)
    return max(across, *(radius / math.sin(edge - tilt) for edge in (right, up, down)))
