"""Axes and scales of other projects' matrices."""

from __future__ import annotations

import numpy as np

from ...core.errors import InputError

#: Blender's and OpenGL's camera (x right, y up, z backwards) in OpenCV's axes; it is its own inverse.
BLENDER_CAMERA = np.diag([1.0, -1.0, -1.0, 1.0])
#: Largest product of two different columns of a rotation that was stored with six digits [1].
_SKEW = 1e-3


def without_scale(matrix: np.ndarray, where: object) -> np.ndarray:
    """Return a pose whose columns were scaled, (4, 4) float64, as Blender stores the matrix of a scaled object.

    Raises
    ------
    InputError
        Where the columns are not at right angles, so that the matrix shears, or mirror.
    """
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise InputError(where, "a matrix of 4 x 4 finite numbers", f"the shape {matrix.shape}")
    length = np.linalg.norm(matrix[:3, :3], axis=0)
    if not (length > 0.0).all():
        raise InputError(where, "a pose", "a column of length 0")
    return rigid(np.vstack([np.column_stack([matrix[:3, :3] / length, matrix[:3, 3]]), [0.0, 0.0, 0.0, 1.0]]), where)


def rigid(pose: np.ndarray, where: object) -> np.ndarray:
    """Return the nearest rigid pose, (4, 4) float64, of one that was rounded; InputError where it is none."""
    R = np.asarray(pose, np.float64)[:3, :3]
    if not np.isfinite(pose).all() or np.abs(R @ R.T - np.eye(3)).max() > _SKEW or np.linalg.det(R) < 0.0:
        raise InputError(where, "a rigid pose", "a matrix that scales, shears or mirrors")
    U, _, Vt = np.linalg.svd(R)
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = U @ Vt, pose[:3, 3]
    return found
