"""Adaptive sampling: more samples for pixels that show glass or polished surfaces.

The denoiser cleans what its guides explain: smooth surfaces, textures, soft shadows. It cannot clean what is seen
through glass, where neighbouring pixels have little in common. Measured on five scenes (docs/performance.md), 80 to
90 % of the remaining error is in the 10 % of the pixels that show glass. Which pixels these are is known from the
geometry before the first sample, so the means stay unbiased.

Within glass the noise differs: most of the error is in a twentieth of its pixels, at rims and where the walls mirror
lamps. So a part of the samples comes first and tells where; the rest goes there (`displayed_noise`).
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ...core.images import srgb_curve

#: Minimum number of groups of a pixel [1]: its variance cannot be estimated from fewer.
_MIN_GROUPS = 2
#: Fraction of the samples that comes before the noise is known [1].
_FIRST = 0.4
#: Standard deviation of the window that the noise is averaged in [px], and its half-width.
_NOISE_SIGMA, _NOISE_REACH = 1.5, 3
#: Power of the noise that additional samples are shared out by [1], and the least and greatest number of them over that
#: without knowledge of the noise. The power 1 would be best without a denoiser, which takes much of strong noise. With
#: 0.6 and 1 PSNR is the same within 0.4 dB in nine of ten vessels (seeds 101, 207), with 1 in 5 to 10 % more time.
_NOISE_POWER, _LEAST, _MOST = 0.6, 0.25, 4.0


@dataclass(frozen=True)
class SampleWeights:
    """Samples of a pixel over those of a pixel that shows neither glass nor polished surfaces."""

    glass: float
    polished: float

    @property
    def max_factor(self) -> int:
        """The larger of the two, rounded down."""
        return int(max(self.glass, self.polished))


def group_counts(
    glass: np.ndarray, polished: np.ndarray, weights: SampleWeights, groups: float, noise: np.ndarray | None = None
) -> np.ndarray:
    """Return the number of sample groups of each pixel.

    Parameters
    ----------
    glass, polished : (H, W) bool
        Which pixels show glass, and a polished surface (`guides.trace_guides`).
    weights : SampleWeights
        Relative number of samples; reduced where the other pixels would get too few groups.
    groups : float
        Mean number of groups of a pixel.
    noise : (H, W) float, optional
        Noise by which the additional samples of glass are shared out (`displayed_noise`). Polish keeps its number: its
        samples are cheap, and would be bought with those of glass.

    Returns
    -------
    (H W,) int64
        Groups of each pixel. Their sum is ``groups * H * W``, rounded down.
    """
    extra = np.maximum(_dilated(glass) * (weights.glass - 1.0), _dilated(polished) * (weights.polished - 1.0)).ravel()
    mean = extra.mean()
    if noise is not None:
        inside = _dilated(glass).ravel() > 0
        extra[inside] = _shared_out(extra[inside], noise.ravel()[inside])
    if mean > 0.0:
        extra *= min(1.0, max(groups / _MIN_GROUPS - 1.0, 0.0) / mean)
    return _rounded((1.0 + extra) / (1.0 + extra.mean()) * groups)


def _shared_out(extra: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Return the same number of additional samples, shared out by noise."""
    if not extra.any() or not noise.any():
        return extra
    weight = noise**_NOISE_POWER
    shared = extra * np.clip(weight / np.average(weight, weights=extra), _LEAST, _MOST)
    return shared * (extra.sum() / shared.sum())


def first_counts(counts: np.ndarray) -> np.ndarray:
    """Return how many of the groups of each pixel come before the noise is known."""
    return np.minimum(np.maximum(np.ceil(_FIRST * counts).astype(np.int64), _MIN_GROUPS), counts)


def remaining_counts(counts: np.ndarray, first: np.ndarray, total: int) -> np.ndarray:
    """Return how many groups of each pixel come after the first ones, `total` in all, so that they add up to `counts`.

    Where more came first than the noise asks for, there are fewer elsewhere.
    """
    missing = np.maximum(counts - first, 0).astype(np.float64)
    return _rounded(missing * (total / max(missing.sum(), 1.0)))


def displayed_noise(means: np.ndarray, variance: np.ndarray, glass: np.ndarray, exposure: float) -> np.ndarray:
    """Return the noise of glass in a displayed picture around each pixel, (H, W) in [0, 1].

    A pixel's own samples do not count: if fewer more were taken where the first ones were dark, the mean would be too
    dark.

    Parameters
    ----------
    means, variance : (H, W) float
        Luminance of each pixel and the variance that it has with the intended number of samples.
    glass : (H, W) bool
        Which pixels show glass; others do not count.
    exposure : float
        Factor from radiance to displayed light, of which 1 is white.
    """
    level, noise = exposure * mean_around(means, glass), exposure * np.sqrt(mean_around(variance, glass))
    return 0.5 * (_displayed(level + noise) - _displayed(level - noise))


def _displayed(level: np.ndarray) -> np.ndarray:
    return srgb_curve(np.clip(level, 0.0, 1.0))


def mean_around(values: np.ndarray, glass: np.ndarray) -> np.ndarray:
    """Return the means of values over the pixels of glass around each one, without its own, (H, W) float64.

    Pixels that do not show glass are 0.
    """
    offset = np.arange(-_NOISE_REACH, _NOISE_REACH + 1)
    kernel = np.exp(-0.5 * (offset[:, None] ** 2 + offset[None, :] ** 2) / _NOISE_SIGMA**2)
    kernel[_NOISE_REACH, _NOISE_REACH] = 0.0
    weight = _dilated(glass).astype(np.float64)
    total, count = (cv2.filter2D(x, -1, kernel, borderType=cv2.BORDER_CONSTANT) for x in (values * weight, weight))
    return weight * np.divide(total, count, out=np.zeros_like(total), where=count > 1e-9)


def _dilated(inside: np.ndarray) -> np.ndarray:
    """Return 1 inside and one pixel beyond, else 0: pixels at an outline may show it between the rays of the guides."""
    return cv2.dilate(inside.astype(np.uint8), np.ones((3, 3), np.uint8))


def _rounded(values: np.ndarray) -> np.ndarray:
    """Return whole numbers with the running sum of the values: the rounding error of one is carried to the next."""
    return np.diff(np.floor(np.cumsum(values) + 1e-6), prepend=0.0).astype(np.int64)
