"""Depth as 16-bit pictures in steps of parts of a millimetre."""

from __future__ import annotations

import numpy as np

#: Millimetres of a metre.
MM = 1000.0
#: Steps of the depth picture [mm]: the finer one where all depths of a view fit into 16 bits, as in BOP's own
#: rendered pictures, else the other; what is farther than 65.5 m is 0, unknown.
DEPTH_SCALES = (0.1, 1.0)


def depth_picture(Z: np.ndarray) -> tuple[np.ndarray, float]:
    """Return depth in whole steps, (H, W) uint16, 0 where there is none, and the step [mm]."""
    mm = np.where(np.isfinite(Z), Z, 0.0).astype(np.float64) * MM
    scale = next((scale for scale in DEPTH_SCALES if np.rint(mm.max() / scale) < 1 << 16), DEPTH_SCALES[-1])
    steps = np.rint(mm / scale)
    return np.where(steps < 1 << 16, steps, 0).astype(np.uint16), scale


def known_depth(Z: np.ndarray) -> np.ndarray:
    """Return depth with 0 where there is none, (H, W) float32 [m]."""
    return np.where(np.isfinite(Z), Z, 0.0).astype(np.float32)
