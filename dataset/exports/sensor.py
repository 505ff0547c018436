"""The depth that a depth camera measured, where a data set has it."""

from __future__ import annotations

import cv2
import numpy as np

from ...core.errors import InputError
from ...core.silence import quiet
from ..reader import StoredView
from .depth import MM

#: The file of a view: 16 bits in whole millimetres, aligned with the left picture; 0 where nothing was measured.
SENSOR_DEPTH = "sensor_depth.png"


def sensor_depth(view: StoredView) -> np.ndarray | None:
    """Return measured depth, (H, W) float32 [m], 0 where nothing was measured; None where the view has no file."""
    path = view.folder / SENSOR_DEPTH
    if not path.is_file():
        return None
    with quiet():
        steps = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if steps is None or steps.dtype != np.uint16 or steps.ndim != 2:
        raise InputError(path, "a whole PNG file of 16 bits", "another, or a damaged one")
    return (steps / MM).astype(np.float32)
