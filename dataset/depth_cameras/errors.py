"""What a depth camera gets wrong on an object: five numbers, as they are measured on real captures."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

#: Error up to which a depth is right, and from which it is in front or behind [m].
RIGHT, FAR = 0.010, 0.020
#: Width of an object's rim [px].
RIM = 7
#: Pixels below which an object has no numbers [1].
FEWEST = 100


class DepthErrors(NamedTuple):
    """Fractions of an object's pixels, and of those with a depth; NaN where there are too few."""

    missing: float  #: without a depth
    right: float  #: of those with one: at most `RIGHT` off
    behind: float  #: ... more than `FAR` behind the first surface
    front: float  #: ... more than `FAR` in front of it
    rim: float  #: missing within `RIM` px of the silhouette, over missing inside of that


def depth_errors(reported: np.ndarray, Z: np.ndarray, mask: np.ndarray) -> DepthErrors:
    """Return the errors of a depth camera on an object.

    Parameters
    ----------
    reported : (H, W) float
        Its depth [m]; NaN where there is none.
    Z : (H, W) float
        The depth of first surfaces [m].
    mask : (H, W) bool
        Where the object is the first surface.
    """
    count = np.count_nonzero(mask)
    if count < FEWEST:
        return DepthErrors(*[np.nan] * 5)
    missing = ~np.isfinite(reported)
    error = (reported - Z)[mask & ~missing & np.isfinite(Z)]
    inside = cv2.erode(mask.astype(np.uint8), np.ones((2 * RIM + 1, 2 * RIM + 1), np.uint8)) > 0
    rim, inner = (_mean(missing, part) for part in (mask & ~inside, inside))
    return DepthErrors(
        missing=float(missing[mask].mean()),
        right=_fraction(np.abs(error) <= RIGHT),
        behind=_fraction(error > FAR),
        front=_fraction(error < -FAR),
        rim=rim / inner if inner > 0.0 else np.nan,
    )


def _fraction(which: np.ndarray) -> float:
    return float(which.mean()) if which.size else np.nan


def _mean(values: np.ndarray, mask: np.ndarray) -> float:
    return float(values[mask].mean()) if mask.any() else np.nan
