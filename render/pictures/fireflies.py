"""Fireflies: lone pixels that one lucky path made bright.

Light that reaches a pixel by a rare path (a caustic seen in a mirror, a lamp seen through two glasses) comes in few and
bright samples. The mean over all pixels is right, and cutting such samples would darken the picture for good. So the
surplus is not cut but spread over the pixels round it, which the same rare paths reach as well: the mean stays, and the
denoiser gets a picture that it can read. What is bright in every group of samples is real and is left alone.
"""

from __future__ import annotations

import cv2
import numpy as np

#: A pixel is a firefly where its standard error is at least this share of its value. Where one group of samples carries
#: everything it is 1, of however many; where 63 to 70 % of the light is in one group (of sixteen, of four) it is this.
LONE = 0.6
#: ... and where it is this many times brighter than the median of the pixels round it.
STANDS_OUT = 3.0
#: Side of the square that the median is taken over [px].
NEAR = 5
#: The surplus is spread over a square of this share of the picture's width. Wide enough that the denoiser takes it for
#: light and not for a mark. Measured on `bench/quality.py --scenes hdri --spp 16`, 240 px wide: relMSE after denoising
#: 0.036 with a square of 5 px, 0.013 with one of 33; unspread 0.013 too, but the denoiser lost 1.6 % of the light.
SHARE = 1 / 8


def spread_fireflies(radiance: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Return the picture with the surplus of fireflies spread over their surroundings; its mean stays.

    Parameters
    ----------
    radiance : (H, W, 3) float32
        Noisy picture.
    variance : (H, W, 3) float32
        Estimated variance of each value.
    """
    level = radiance.mean(axis=2)
    around = cv2.medianBlur(np.ascontiguousarray(level, np.float32), NEAR)
    # The variance of the mean colour is at most that of fully correlated channels, which a firefly's are.
    error = np.sqrt(variance).mean(axis=2)
    lone = (error >= LONE * level) & (level > STANDS_OUT * around)
    kept = np.divide(around, level, out=np.ones_like(level), where=lone)[..., None]
    surplus = (radiance * (1.0 - kept)).astype(np.float32)
    return (radiance * kept + spread(surplus, SHARE * surplus.shape[1])).astype(np.float32)


def spread(surplus: np.ndarray, width: float) -> np.ndarray:
    """Return a picture averaged over squares; its sum stays.

    Parameters
    ----------
    surplus : (H, W, 3) float32
        What is to be spread.
    width : float
        Of the squares, about [px]. At the edge the share that would fall outside stays inside.
    """
    side = 2 * int(width / 2) + 1
    ones = np.ones(surplus.shape[:2], np.float32)
    inside = cv2.boxFilter(ones, -1, (side, side), borderType=cv2.BORDER_CONSTANT)
    return cv2.boxFilter(surplus / inside[..., None], -1, (side, side), borderType=cv2.BORDER_CONSTANT)
