"""Projection and back-projection for pinhole cameras with OpenCV axes (x right, y down, z forward).

Pixel (0, 0) has its centre at image coordinate (0, 0), so a pixel extends half a pixel to each side of its coordinates
and a picture covers ``[-0.5, width - 0.5] x [-0.5, height - 0.5]``.
"""

from __future__ import annotations

import numpy as np


def inverse_pose(a_T_b: np.ndarray) -> np.ndarray:
    """Return ``b_T_a`` of a rigid pose, (4, 4) float64."""
    b_T_a = np.eye(4)
    b_T_a[:3, :3] = a_T_b[:3, :3].T
    b_T_a[:3, 3] = -a_T_b[:3, :3].T @ a_T_b[:3, 3]
    return b_T_a


def transformed(a_T_b: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return points in frame a, (n, 3) float64, given in frame b, (n, 3)."""
    return np.asarray(points, np.float64) @ a_T_b[:3, :3].T + a_T_b[:3, 3]


def project(points: np.ndarray, K: np.ndarray, world_T_camera: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Project points of the world into a picture.

    Parameters
    ----------
    points : (n, 3) float
        Points in the world frame [m].
    K : (3, 3) float
        Intrinsic matrix [px].
    world_T_camera : (4, 4) float
        Pose of the camera.

    Returns
    -------
    pixels : (n, 2) float64
        Image coordinates (u, v) [px]; NaN where Z <= 0. (Hartley & Zisserman, *Multiple View Geometry*, eq. 6.2.)
    Z : (n,) float64
        Planar depth along the optical axis [m].
    """
    return project_camera(transformed(inverse_pose(world_T_camera), points), K)


def project_camera(points: np.ndarray, K: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Project points of the camera frame, as `project` does."""
    Z = points[:, 2]
    in_front = Z > 0.0
    homogeneous = points @ K.T
    pixels = np.full((len(points), 2), np.nan)
    pixels[in_front] = homogeneous[in_front, :2] / homogeneous[in_front, 2:]
    return pixels, Z


def pixel_rays(height: int, width: int, K: np.ndarray) -> np.ndarray:
    """Return the directions through the pixel centres with Z = 1, camera frame, (H, W, 3) float64."""
    v, u = np.mgrid[:height, :width].astype(np.float64)
    return np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(K).T


def unproject(Z: np.ndarray, K: np.ndarray) -> np.ndarray:
    """Return the 3D points of a map of planar depth.

    Parameters
    ----------
    Z : (H, W) float
        Planar depth [m]; +inf where the ray meets no surface.
    K : (3, 3) float
        Intrinsic matrix [px].

    Returns
    -------
    (H, W, 3) float64
        Points in the camera frame [m]; NaN where the depth is infinite.
    """
    depth = np.where(np.isfinite(Z), Z, np.nan).astype(np.float64)
    return pixel_rays(Z.shape[0], Z.shape[1], K) * depth[..., None]


def disparity(Z: np.ndarray, focal: float, baseline: float) -> np.ndarray:
    """Return the disparity of a rectified stereo pair, ``u_left - u_right = f b / Z`` [px]; 0 at infinity.

    Parameters
    ----------
    Z : (...) float
        Planar depth [m]; +inf where the ray meets no surface.
    focal : float
        Focal length along x, the direction of the baseline [px].
    baseline : float
        Distance between the cameras [m].
    """
    return focal * baseline / np.asarray(Z, np.float64)


def inside_picture(pixels: np.ndarray, width: int, height: int) -> np.ndarray:
    """Return which image coordinates, (n, 2), lie on a pixel of the picture, (n,) bool; NaN does not."""
    u, v = pixels[:, 0], pixels[:, 1]
    return (u >= -0.5) & (u < width - 0.5) & (v >= -0.5) & (v < height - 0.5)
