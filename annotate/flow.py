"""Optical flow between two views of a scene in which nothing moves but the camera."""

from __future__ import annotations

import numpy as np

from ..procedural.description.camera import Camera
from .projection import inside_picture, project, transformed, unproject

#: A point that is farther from the other camera than what that one sees there by less than this is the same surface, as
#: a fraction of its depth: the other picture's depth is read between pixels, where a slanted surface lies between them.
DEPTH_SLACK = 0.01


def optical_flow(Z: np.ndarray, camera: Camera, other: Camera) -> np.ndarray:
    """Return where each pixel's point appears in another camera, minus the pixel.

    ``project(world_T_camera unproject(u, v, Z)) - (u, v)``, along straight rays.

    Parameters
    ----------
    Z : (H, W) float
        Planar depth of the points in `camera` [m]; +inf for none.
    camera, other : Camera
        The camera of the pixels, and the one in which their points are looked up; left eyes.

    Returns
    -------
    (H, W, 2) float32
        (du, dv) [px]; NaN where there is no point, or it is behind the other camera.
    """
    height, width = Z.shape
    pixels = _landing(Z, camera, other)[0]
    v, u = np.mgrid[:height, :width]
    return (pixels - np.stack([u, v], axis=-1)).astype(np.float32)


def flow_visibility(Z: np.ndarray, camera: Camera, other_Z: np.ndarray, other: Camera) -> np.ndarray:
    """Return where the other picture shows the point of a pixel: inside the picture, and nothing nearer in front of it.

    The depth of the other picture around the landing point is the largest of its four pixels; at a silhouette a point
    up to a pixel behind the edge counts as visible.

    Parameters
    ----------
    Z, camera
        As in `optical_flow`.
    other_Z : (H, W) float
        Planar depth in the other camera [m].
    other : Camera
        The other camera.

    Returns
    -------
    (H, W) bool
    """
    pixels, depth = _landing(Z, camera, other)
    inside = inside_picture(pixels.reshape(-1, 2), other.width, other.height).reshape(Z.shape)
    column, row = (np.where(inside, np.floor(pixels[..., axis]), 0).astype(int) for axis in (0, 1))
    around = [
        other_Z[np.clip(row + down, 0, other.height - 1), np.clip(column + right, 0, other.width - 1)]
        for down in (0, 1)
        for right in (0, 1)
    ]
    return inside & (depth <= np.max(around, axis=0) * (1.0 + DEPTH_SLACK))


def _landing(Z: np.ndarray, camera: Camera, other: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Return the image coordinates, (H, W, 2), and depths, (H, W), of a camera's points in another one; NaN: none."""
    points = unproject(Z, camera.K)
    seen = np.isfinite(points[..., 2])
    world = transformed(camera.world_T_camera, points[seen])
    pixels, depth = np.full((*Z.shape, 2), np.nan), np.full(Z.shape, np.nan)
    pixels[seen], depth[seen] = project(world, other.K, other.world_T_camera)
    return pixels, depth
