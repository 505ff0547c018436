"""Adaptive sampling: more samples for pixels that show glass or polished surfaces.

The denoiser cleans what its guides explain: smooth surfaces, textures, soft shadows. It cannot clean what is seen
through glass, where neighbouring pixels have little in common. Measured on five scenes (docs/performance.md), 80 to
90 % of the remaining error is in the 10 % of the pixels that show glass. Which pixels these are is known from the
geometry before the first sample, so the means stay unbiased.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

#: Minimum number of groups of a pixel [1]: its variance cannot be estimated from fewer.
_MIN_GROUPS = 2


@dataclass(frozen=True)
class SampleWeights:
    """Samples of a pixel over those of a pixel that shows neither glass nor polished surfaces."""

    glass: float
    polished: float

    @property
    def max_factor(self) -> int:
        """The larger of the two, rounded down."""
        return int(max(self.glass, self.polished))


def group_counts(glass: np.ndarray, polished: np.ndarray, weights: SampleWeights, groups: float) -> np.ndarray:
    """Return the number of sample groups of each pixel.

    Parameters
    ----------
    glass, polished : (H, W) bool
        Which pixels show glass, and a polished surface (`guides.trace_guides`).
    weights : SampleWeights
        Relative number of samples; reduced where the other pixels would get too few groups.
    groups : float
        Mean number of groups of a pixel.

    Returns
    -------
    (H W,) int64
        Groups of each pixel. Their sum is ``groups * H * W``, rounded down.
    """
    extra = np.maximum(_dilated(glass) * (weights.glass - 1.0), _dilated(polished) * (weights.polished - 1.0)).ravel()
    mean = extra.mean()
    if mean > 0.0:
        extra *= min(1.0, max(groups / _MIN_GROUPS - 1.0, 0.0) / mean)
    return _rounded((1.0 + extra) / (1.0 + extra.mean()) * groups)


def _dilated(inside: np.ndarray) -> np.ndarray:
    """Return 1 inside and one pixel beyond, else 0: pixels at an outline may show it between the rays of the guides."""
    return cv2.dilate(inside.astype(np.uint8), np.ones((3, 3), np.uint8))


def _rounded(values: np.ndarray) -> np.ndarray:
    """Return whole numbers with the running sum of the values: the rounding error of one is carried to the next."""
    return np.diff(np.floor(np.cumsum(values) + 1e-6), prepend=0.0).astype(np.int64)
