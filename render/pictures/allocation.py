"""Where the samples of a picture go: most to the pixels that show glass.

The denoiser cleans what its guides explain: even surfaces, textures, soft shadows. What it cannot know is what glass
shows, where one pixel's light has little to do with the next one's. Measured on five scenes (docs/performance.md), four
fifths to nine tenths of the error that is left lies in the tenth of the pixels that show glass. Which pixels those are
is known from the geometry before the first sample, so the means stay what they are.
"""

from __future__ import annotations

import cv2
import numpy as np

#: Groups that every pixel gets at least, to tell its noise.
_FEWEST = 2


def group_counts(glass: np.ndarray, spp: int, size: int, ratio: float) -> np.ndarray:
    """Share out groups of samples.

    Parameters
    ----------
    glass : (H, W) bool
        Which pixels show glass (`guides.trace_guides`).
    spp : int
        Samples of a pixel, on the average.
    size : int
        Samples of a group.
    ratio : float
        Samples of a pixel that shows glass over those of one that does not; less where the others would else get too
        few groups.

    Returns
    -------
    (H W,) int64
        Groups of each pixel; together as many as `spp` asks for, rounded down to whole groups.
    """
    # A pixel at the outline may show glass between the rays that looked for it.
    near = cv2.dilate(glass.astype(np.uint8), np.ones((3, 3), np.uint8)).ravel()
    groups, share = spp / size, near.mean()
    most = 1.0 + max(groups / _FEWEST - 1.0, 0.0) / share if share > 0.0 else ratio
    weights = np.where(near > 0, min(ratio, most), 1.0)
    return _rounded(weights / weights.mean() * groups)


def _rounded(shares: np.ndarray) -> np.ndarray:
    """Return whole numbers whose running sum follows that of the shares: what is cut from one goes to the next."""
    return np.diff(np.floor(np.cumsum(shares) + 1e-6), prepend=0.0).astype(np.int64)
