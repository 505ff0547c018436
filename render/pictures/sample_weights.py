"""Where the samples of a picture go: most to the pixels that show glass, more to those that show polish.

The denoiser cleans what its guides explain: even surfaces, textures, soft shadows. What it cannot know is what glass
shows, where one pixel's light has little to do with the next one's. Measured on five scenes (docs/performance.md), four
fifths to nine tenths of the error that is left lies in the tenth of the pixels that show glass. Which pixels those are
is known from the geometry before the first sample, so the means stay what they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

#: Groups that every pixel gets at least, to tell its noise.
_FEWEST = 2


@dataclass(frozen=True)
class SampleWeights:
    """Samples of a pixel over those of one that shows neither glass nor polish."""

    glass: float
    polished: float

    @property
    def most(self) -> int:
        """The most that any pixel gets."""
        return int(max(self.glass, self.polished))


def group_counts(glass: np.ndarray, polished: np.ndarray, worth: SampleWeights, groups: float) -> np.ndarray:
    """Share out groups of samples.

    Parameters
    ----------
    glass, polished : (H, W) bool
        Which pixels show glass, and a polished surface (`guides.trace_guides`).
    worth : SampleWeights
        How many samples they get over the others; less where the others would else get too few groups.
    groups : float
        Groups of a pixel, on the average.

    Returns
    -------
    (H W,) int64
        Groups of each pixel; together as many as asked for, rounded down to a whole number.
    """
    extra = np.maximum(_near(glass) * (worth.glass - 1.0), _near(polished) * (worth.polished - 1.0)).ravel()
    mean = extra.mean()
    if mean > 0.0:
        extra *= min(1.0, max(groups / _FEWEST - 1.0, 0.0) / mean)
    return _rounded((1.0 + extra) / (1.0 + extra.mean()) * groups)


def _near(inside: np.ndarray) -> np.ndarray:
    """Return 1 inside and beside it, else 0: a pixel at the outline may show between its rays what they look for."""
    return cv2.dilate(inside.astype(np.uint8), np.ones((3, 3), np.uint8))


def _rounded(shares: np.ndarray) -> np.ndarray:
    """Return whole numbers whose running sum follows that of the shares: what is cut from one goes to the next."""
    return np.diff(np.floor(np.cumsum(shares) + 1e-6), prepend=0.0).astype(np.int64)
