"""Firefly filter: isolated pixels that a single path made bright are spread over their neighbourhood.

Light that reaches a pixel by rare paths (a caustic seen in a mirror, a lamp seen through two glasses) arrives in few
bright samples. The mean over all pixels is right, and clamping such samples would darken the picture (bias). So the
excess is not clamped but spread over the surrounding pixels, which the same rare paths reach as well: the mean stays,
and the denoiser can handle the result. Pixels that are bright in every group of samples are not changed.
"""

from __future__ import annotations

import cv2
import numpy as np

#: Smallest relative standard error of a firefly [1]. It is 1 where one group of samples carries all light, for any
#: number of groups, and 0.6 where 63 to 70 % of the light is in one group (of sixteen, of four).
MIN_RELATIVE_ERROR = 0.6
#: Smallest ratio of a firefly to the median of its neighbourhood [1].
MIN_CONTRAST = 3.0
#: Side of the square that the median is taken over [px].
MEDIAN_SIDE = 5
#: Side of the square that the excess is spread over, as a fraction of the picture's width [1]: so wide that the
#: denoiser does not take it for a detail. Measured on `bench/quality.py --scenes hdri --spp 16`, 240 px wide: relMSE
#: after denoising 0.036 with a square of 5 px, 0.013 with one of 33; without the filter 0.013 as well, but the denoiser
#: lost 1.6 % of the light.
SPREAD = 1 / 8


def spread_fireflies(radiance: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Return the picture with the excess of fireflies spread over their neighbourhood; its mean stays.

    Parameters
    ----------
    radiance : (H, W, 3) float32
        Noisy picture.
    variance : (H, W, 3) float32
        Estimated variance of each value.
    """
    level = radiance.mean(axis=2)
    around = cv2.medianBlur(np.ascontiguousarray(level, np.float32), MEDIAN_SIDE)
    # The variance of the mean colour is at most that of fully correlated channels, as those of a firefly are.
    error = np.sqrt(variance).mean(axis=2)
    is_firefly = (error >= MIN_RELATIVE_ERROR * level) & (level > MIN_CONTRAST * around)
    kept = np.divide(around, level, out=np.ones_like(level), where=is_firefly)[..., None]
    excess = (radiance * (1.0 - kept)).astype(np.float32)
    return (radiance * kept + box_filtered(excess, SPREAD * excess.shape[1])).astype(np.float32)


def box_filtered(image: np.ndarray, width: float) -> np.ndarray:
    """Return a picture filtered with a box whose weights are normalised inside the picture; its sum stays.

    Parameters
    ----------
    image : (H, W, 3) float32
        The picture.
    width : float
        Side of the box [px], rounded to an odd number.
    """
    side = 2 * int(width / 2) + 1
    ones = np.ones(image.shape[:2], np.float32)
    inside = cv2.boxFilter(ones, -1, (side, side), borderType=cv2.BORDER_CONSTANT)
    return cv2.boxFilter(image / inside[..., None], -1, (side, side), borderType=cv2.BORDER_CONSTANT)
