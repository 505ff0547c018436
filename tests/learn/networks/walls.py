"""A rectified pair of pictures of a wall without shading, whose disparity is known."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

FOCAL, BASELINE, DISPARITY = 200.0, 0.1, 24
DEPTH = FOCAL * BASELINE / DISPARITY


def wall_pair(rng: np.random.Generator) -> tuple[Tensor, Tensor, Tensor]:
    """Images in [0, 1], (1, 2, 3, 64, 128), poses and K of a wall with random colours."""
    wall = torch.from_numpy(rng.uniform(0.2, 0.8, (3, 64, 128 + DISPARITY))).float()
    images = torch.stack([wall[..., :128], wall[..., DISPARITY:]])[None]
    poses = torch.eye(4).repeat(1, 2, 1, 1)
    poses[0, 1, 0, 3] = BASELINE
    K = torch.tensor([[FOCAL, 0.0, 64.0], [0.0, FOCAL, 32.0], [0.0, 0.0, 1.0]]).repeat(1, 2, 1, 1)
    return images, poses, K
