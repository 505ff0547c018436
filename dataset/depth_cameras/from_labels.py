"""A depth camera's faults painted onto true depth: no second rendering, in milliseconds, and no optics.

What `measure` finds by light and matching is drawn here at random: noise that grows with the square of the distance,
shadows of what is in front, and on glass patches without a depth, patches with that of the background, and patches with
the right one. How large each share is comes from captures; where the patches are, does not.
"""

from __future__ import annotations

import cv2
import numpy as np

from ...procedural.description.camera import Camera
from ...procedural.description.depth_camera import DepthCamera
from ...render.frame import Geometry
from .measure import HIDDEN, MEASURED, NO_MATCH, OUT_OF_RANGE, UNSEEN
from .registration import registered

#: Sub-pixel error of a D400 on real scenes [px] (Intel, librealsense issue 3904).
SUBPIXEL = 0.08
#: Standard deviation of the window over which errors are alike [px]: half of a matched window of 9 px.
_ALIKE = 4.0
#: Of the pixels on glass: fraction without a depth, and fraction of the others with the depth behind the glass. Medians
#: of seven clear plastic objects that a D435 captured (ClearGrasp, `bench/depth_camera.py`): 0.31, and 0.57 behind by
#: more than 20 mm.
MISSING, BEHIND = 0.31, 0.57
#: Standard deviation of the window that patches on glass are smooth over [px].
_PATCH = 6.0


def painted(
    device: DepthCamera, colour: Camera, geometry: Geometry, glass: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return depth with a depth camera's kinds of faults, (H, W) float32 [m], NaN for none; and numbers of `REASONS`.

    Parameters
    ----------
    device : DepthCamera
        Its baseline, focal length, places, range and unit are used.
    colour : Camera
        The colour camera; its left eye.
    geometry : Geometry
        What that eye sees.
    glass : (H, W) bool
        Where the first surface is transparent.
    rng : numpy.random.Generator
        Of noise and patches.
    """
    first, behind = geometry.Z.astype(np.float64), geometry.background_Z.astype(np.float64)
    reason = np.where(np.isfinite(first), MEASURED, NO_MATCH).astype(np.uint16)
    through = glass & (_patches(first.shape, rng) < BEHIND)
    Z = np.where(through, behind, first)
    reason[glass & (_patches(first.shape, rng) < MISSING)] = NO_MATCH
    fb = device.imager.focal * device.baseline
    Z = fb / (fb / Z + SUBPIXEL * _smooth(rng.standard_normal(first.shape), _ALIKE))
    reason[_shadow(first, colour, device.place)] = UNSEEN
    reason[_shadow(first, colour, device.place + device.baseline)] = HIDDEN
    low, high = device.range
    reason[(reason == MEASURED) & ~((low <= Z) & (high >= Z))] = OUT_OF_RANGE
    steps = np.rint(np.where(reason == MEASURED, Z, np.nan) / device.unit)
    return (steps * device.unit).astype(np.float32), reason


def _smooth(noise: np.ndarray, sigma: float) -> np.ndarray:
    """Return noise that is alike over a window, with the variance 1."""
    smooth = cv2.GaussianBlur(noise, (0, 0), sigma, borderType=cv2.BORDER_REFLECT)
    return smooth / max(float(smooth.std()), 1e-12)


def _patches(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Return smooth noise whose values are evenly spread over 0 to 1, (H, W) float."""
    smooth = _smooth(rng.standard_normal(shape), _PATCH)
    ranks = np.empty(smooth.size)
    ranks[np.argsort(smooth, axis=None)] = (np.arange(smooth.size) + 0.5) / smooth.size
    return ranks.reshape(shape)


def _shadow(Z: np.ndarray, colour: Camera, shift: float) -> np.ndarray:
    """Return which pixels an eye at x = `shift` from the colour camera does not see, by the depths of this one."""
    there = registered(np.where(np.isfinite(Z), Z, np.nan).astype(np.float32), colour, colour, -shift)
    rows, columns = np.indices(Z.shape)
    moved = np.rint(columns - colour.fx * shift / Z)
    inside = (moved >= 0) & (moved < Z.shape[1])
    nearest = there[rows, np.where(inside, moved, 0).astype(int)]
    # A pixel's own depth, and those of neighbours on slanted surfaces, hide nothing.
    return np.isfinite(Z) & (~inside | (nearest < Z * 0.98))
