"""The depth that a depth camera measured, where a data set has it."""

from __future__ import annotations

import numpy as np

from ..reader import StoredView
from .depth import known_depth


def sensor_depth(view: StoredView) -> np.ndarray | None:
    """Return measured depth, (H, W) float32 [m], 0 where nothing was measured; None without a depth camera."""
    return None if view.depth_camera() is None else known_depth(view.sensor_depth())
