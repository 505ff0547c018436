"""From keypoints in the windows of a stereo pair to points in space."""

from __future__ import annotations

import torch
from torch import Tensor

#: Least disparity [px] (released code).
_MIN_DISPARITY = 1e-5


def points_in_space(keypoints: Tensor, K: Tensor, baseline: Tensor) -> Tensor:
    """Return the points of keypoints in the left camera's frame, (B, n, 3) [m].

    Parameters
    ----------
    keypoints : (B, n, 3) Tensor
        Column and row in the left window, and the column there less that in the right window [px].
    K : (B, 2, 3, 3) Tensor
        Intrinsic matrices of both windows [px].
    baseline : (B,) Tensor
        Distance of the eyes along x [m].
    """
    u, v, shift = keypoints.unbind(2)
    fx, fy = K[:, 0, 0, 0, None], K[:, 0, 1, 1, None]
    disparity = torch.relu(shift - K[:, 0, 0, 2, None] + K[:, 1, 0, 2, None]) + _MIN_DISPARITY
    Z = fx * baseline[:, None] / disparity
    return torch.stack([(u - K[:, 0, 0, 2, None]) / fx * Z, (v - K[:, 0, 1, 2, None]) / fy * Z, Z], dim=2)
