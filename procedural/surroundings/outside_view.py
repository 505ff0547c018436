"""The view through the windows of a room in its place, by direction: sky with clouds, trees and open ground."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..description.surroundings import RoomEnvironment, SkyEnvironment
from .skies import bake_sky

# Rows of the sky's own map [1]; its picture has twice as many, 0.23 degrees each.
_ROWS = 384
# Highest part of the sky whose mean luminance a window's states [rad]: what one sees from inside.
_SEEN = 0.7
# Ranges of the sky's properties [rad], [1], [1], and of the ground's reflectance; the sun is behind clouds.
_ELEVATION, _TURBIDITY, _CLOUDS, _GROUND = (0.3, 1.0), (2.0, 6.0), (0.15, 0.9), (0.08, 0.3)


def bake_outside(room: RoomEnvironment) -> np.ndarray:
    """Return the radiance outside, without ``rotation`` and ``strength``, (h, 2 * h, 3) float32 [kcd/m^2].

    Its mean over the horizon is the ``radiance`` of the first window.
    """
    return _baked(room.seed, next((w.radiance for w in room.windows if w.kind == "window"), (0.0, 0.0, 0.0)))


@lru_cache(maxsize=2)
def _baked(seed: int, mean: tuple[float, float, float]) -> np.ndarray:
    if not max(mean) > 0.0:
        return np.zeros((2, 4, 3), np.float32)
    rng = np.random.Generator(np.random.PCG64(seed))
    grey = rng.uniform(*_GROUND)
    sky = SkyEnvironment(
        sun_elevation=float(rng.uniform(*_ELEVATION)),
        sun_illuminance=0.0,
        sun_radius=0.01,
        turbidity=float(rng.uniform(*_TURBIDITY)),
        cloudiness=float(rng.uniform(*_CLOUDS)),
        ground=(grey, 1.1 * grey, 0.8 * grey),
        seed=int(rng.integers(2**31)),
    )
    # The sky's sun stands at azimuth 0: which windows face it is drawn as well.
    pixels = np.roll(bake_sky(sky, _ROWS), int(rng.integers(4 * _ROWS)), axis=1)
    height = len(pixels)
    above = pixels[int(height * (0.5 - _SEEN / math.pi)) : height // 2]
    pixels = pixels * (np.array(mean) / above.reshape(-1, 3).mean(axis=0)).astype(np.float32)
    pixels.setflags(write=False)
    return pixels
