"""Depth errors by the protocol of ClearGrasp: RMSE, MAE, REL, delta accuracy.

(Sajjan et al., "ClearGrasp: 3D Shape Estimation of Transparent Objects for Manipulation", ICRA 2020, section VI; the
deltas are those of Eigen et al., NeurIPS 2014, section 4.) Over the pixels of a mask with known true depth t and
predicted depth p: RMSE = sqrt(mean (p - t)^2), MAE = mean |p - t|, REL = mean |p - t| / t, and delta 1.05 = the
fraction with max(p / t, t / p) < 1.05, and so on. The errors of a data set are means over its images.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

#: Height and width at which ClearGrasp, and MVTrans after it, compares depth [px].
CLEARGRASP_SIZE = (144, 256)
#: Width of the bins of a histogram of depths [m], and their number: up to 10 m.
BIN, DEPTH_BINS = 1e-3, 10_000


@dataclass(frozen=True)
class DepthErrors:
    """Errors of one image, or their means."""

    rmse: float  #: [m]
    mae: float  #: [m]
    rel: float
    delta_105: float  #: fraction, 0 to 1
    delta_110: float
    delta_125: float


def depth_errors(predicted: np.ndarray, true: np.ndarray, mask: np.ndarray) -> DepthErrors | None:
    """Return the errors over a mask; None where it has no pixel with a known depth.

    Parameters
    ----------
    predicted, true : (H, W) float
        Depths [m]; true depths of 0 and infinity are unknown. Predicted depths of 0 or less are within no delta.
    mask : (H, W) bool
        The compared pixels.
    """
    valid = mask & (true > 0.0) & np.isfinite(true)
    if not valid.any():
        return None
    p, t = predicted[valid].astype(np.float64), true[valid].astype(np.float64)
    error = np.abs(p - t)
    ratio = np.where(p > 0.0, np.maximum(p / t, t / np.where(p > 0.0, p, 1.0)), np.inf)
    deltas = [float((ratio < bound).mean()) for bound in (1.05, 1.10, 1.25)]
    return DepthErrors(float(np.sqrt((error**2).mean())), float(error.mean()), float((error / t).mean()), *deltas)


def depth_histogram(true: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return how many pixels of a mask have a true depth in each of `DEPTH_BINS`, int64; farther ones in the last."""
    known = true[mask & (true > 0.0) & np.isfinite(true)].astype(np.float64)
    bins = np.minimum((known / BIN).astype(np.int64), DEPTH_BINS - 1)
    return np.bincount(bins, minlength=DEPTH_BINS)


def constant_errors(images: Sequence[np.ndarray]) -> tuple[float, DepthErrors] | None:
    """Return the best constant depth [m] for a set of images, and its errors; None where no pixel is known.

    It is the median over all images, each with the same weight: of all constants that of the least mean absolute error.
    A network that does not beat it has learnt nothing.

    Parameters
    ----------
    images : sequence of (DEPTH_BINS,) int
        Of `depth_histogram`; depths count as the middles of their bins.
    """
    weights = [counts / counts.sum() for counts in images if counts.any()]
    if not weights:
        return None
    middles = (np.arange(DEPTH_BINS) + 0.5) * BIN
    constant = float(middles[np.searchsorted(np.cumsum(np.mean(weights, axis=0)), 0.5)])
    error, ratio = np.abs(middles - constant), np.maximum(middles / constant, constant / middles)
    columns = [error, error / middles, *(ratio < bound for bound in (1.05, 1.10, 1.25))]
    rmse = float(np.mean([np.sqrt(weight @ error**2) for weight in weights]))
    return constant, DepthErrors(rmse, *(float(np.mean([weight @ column for weight in weights])) for column in columns))


def cleargrasp_errors(predicted: np.ndarray, true: np.ndarray, mask: np.ndarray) -> DepthErrors | None:
    """Return the errors after nearest-neighbour resizing of all three to `CLEARGRASP_SIZE`."""
    return depth_errors(*(resized_nearest(values, CLEARGRASP_SIZE) for values in (predicted, true, mask)))


def mean_errors(images: Sequence[DepthErrors | None]) -> DepthErrors | None:
    """Return the means over the images that have errors; None where none has."""
    known = [errors for errors in images if errors is not None]
    if not known:
        return None
    return DepthErrors(*(float(np.mean([getattr(row, field.name) for row in known])) for field in fields(DepthErrors)))


def resized_nearest(values: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return a map, (H, W), at another height and width by nearest neighbours."""
    rows, columns = (np.arange(new) * old // new for new, old in zip(size, values.shape, strict=True))
    return values[rows[:, None], columns]
