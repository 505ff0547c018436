"""A pinhole camera of its own: pixel centres on whole numbers, x right, y down, z forward."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.camera import Camera
from ...render.frame import Eye


@dataclass(frozen=True, eq=False)
class Pinhole:
    """One eye of a stereo pair."""

    focal: np.ndarray  #: (2,) float64, along x and y [px]
    centre: np.ndarray  #: (2,) float64, principal point [px]
    size: tuple[int, int]  #: width and height [px]
    axes: np.ndarray  #: (3, 3) float64, rows: x, y, z of the camera in the world
    origin: np.ndarray  #: (3,) float64, world [m]


def pinhole_of(camera: Camera, eye: Eye = "left") -> Pinhole:
    """Return one eye of a camera of a scene's description; the right one stands at +baseline along the left one's x."""
    axes, origin = camera.world_T_camera[:3, :3].T, camera.world_T_camera[:3, 3].astype(np.float64)
    if eye == "right":
        origin = origin + camera.baseline * axes[0]
    focal_y = camera.focal if camera.focal_y is None else camera.focal_y
    size = (camera.width, camera.height)
    return Pinhole(np.array([camera.focal, focal_y]), np.array(camera.centre), size, axes, origin)


def seen_from(camera: Pinhole, points: np.ndarray) -> np.ndarray:
    """Return points of the world, (..., 3), in the camera's frame."""
    return (points - camera.origin) @ camera.axes.T


def image_of(camera: Pinhole, local: np.ndarray) -> np.ndarray:
    """Return the image coordinates of points of the camera's frame, (..., 3), as (..., 2) [px]; NaN behind it."""
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = camera.focal * local[..., :2] / local[..., 2:] + camera.centre
    return np.where(local[..., 2:] > 0.0, pixels, np.nan)


def rays_of(camera: Pinhole, pixels: np.ndarray) -> np.ndarray:
    """Return the rays through image coordinates, (n, 2), in the camera's frame, with z = 1: (n, 3)."""
    return np.concatenate([(pixels - camera.centre) / camera.focal, np.ones((len(pixels), 1))], axis=1)


def pixel_centres(camera: Pinhole) -> np.ndarray:
    """Return the centres of all pixels, row by row, (W H, 2)."""
    width, height = camera.size
    v, u = np.indices((height, width))
    return np.stack([u.ravel(), v.ravel()], axis=1).astype(np.float64)


def in_picture(camera: Pinhole, pixels: np.ndarray) -> np.ndarray:
    """Return which image coordinates, (..., 2), are on a pixel; NaN is not."""
    (width, height), u, v = camera.size, pixels[..., 0], pixels[..., 1]
    return (u >= -0.5) & (u < width - 0.5) & (v >= -0.5) & (v < height - 0.5)
