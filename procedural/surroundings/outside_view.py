"""The view through the windows of a room, by direction."""

from __future__ import annotations

import numpy as np

from ..description.surroundings import RoomEnvironment
from .windows import outside_of


def bake_outside(room: RoomEnvironment) -> np.ndarray:
    """Return the radiance outside, without ``rotation`` and ``strength``, (h, 2 * h, 3) float32 [kcd/m^2]."""
    sky = next((window.radiance for window in room.windows if window.kind == "window"), (0.0, 0.0, 0.0))
    return outside_of(room).level[..., None] * np.array(sky, np.float32)
