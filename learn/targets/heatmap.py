"""Where objects are: a bivariate normal over each one's visible pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: How much narrower than its object a peak is, as a share of the covariance (the released code's value; the paper gives
#: none).
CONCENTRATION = 0.8
#: Variance of a place that is uniform over a pixel [px^2]. It is added to the covariance of the pixels' centres, which
#: makes it that of their area: a row of pixels has a width as well.
PIXEL_VARIANCE = 1.0 / 12.0
#: Cells whose heat is below are no part of an object, and peaks below are none (the released code's value).
THRESHOLD = 0.3
#: How far from its mean the hottest pixel of a normal is looked for, in rows and columns [px].
_AROUND = 4


@dataclass(frozen=True, eq=False)
class Normal:
    """A normal over the picture."""

    mean: np.ndarray  #: (2,) float64, (x, y) [px]
    covariance: np.ndarray  #: (2, 2) float64 [px^2]


def normal_of(mask: np.ndarray) -> Normal:
    """Return the normal of an object's visible pixels, (H, W) bool with at least one pixel.

    Its mean is that of the pixels, its covariance theirs times `CONCENTRATION`.
    """
    y, x = np.nonzero(mask)
    pixels = np.stack([x, y], axis=1).astype(np.float64)
    mean = pixels.mean(0)
    spread = (pixels - mean).T @ (pixels - mean) / len(pixels)
    return Normal(mean, CONCENTRATION * (spread + PIXEL_VARIANCE * np.eye(2)))


def log_heat(normals: list[Normal], size: tuple[int, int], stride: int = 1) -> np.ndarray:
    """Return the logarithm of each normal's density over that at its mean.

    -1/2 (p - m)^T C^-1 (p - m): the paper's density, scaled to a peak of 1.

    Parameters
    ----------
    normals : list of Normal
        Of n objects.
    size : (int, int)
        Height and width of the picture [px].
    stride : int
        Only every so many pixels of rows and columns are computed.

    Returns
    -------
    (n, ceil(H / stride), ceil(W / stride)) float32
    """
    height, width = size
    y, x = np.arange(0, height, stride, dtype=np.float32), np.arange(0, width, stride, dtype=np.float32)
    maps = np.empty((len(normals), len(y), len(x)), np.float32)
    for index, normal in enumerate(normals):
        (a, b), (_, d) = np.linalg.inv(normal.covariance).astype(np.float32)
        right, down = x - np.float32(normal.mean[0]), (y - np.float32(normal.mean[1]))[:, None]
        maps[index] = -0.5 * (a * right * right + (2.0 * b * down) * right + d * down * down)
    return maps


def heatmap(normals: list[Normal], size: tuple[int, int]) -> np.ndarray:
    """Return the largest heat of any object at each pixel, (H, W) float32 in [0, 1]; 0 without objects."""
    if not normals:
        return np.zeros(size, np.float32)
    return np.exp(log_heat(normals, size).max(axis=0))


def hottest_pixel(normal: Normal, size: tuple[int, int]) -> np.ndarray:
    """Return the pixel (x, y) of a normal's peak in a picture of (height, width), (2,) int.

    Most often the pixel that its mean lies in, but a thin sloping object has a hotter one along its length. Among
    equals the first in the order of rows, as `decoding.peaks` takes it.
    """
    height, width = size
    low = np.maximum(np.floor(normal.mean).astype(int) - _AROUND, 0)
    high = np.minimum(np.floor(normal.mean).astype(int) + _AROUND + 2, [width, height])
    y, x = np.mgrid[low[1] : high[1], low[0] : high[0]]
    shift = np.stack([x, y], axis=-1) - normal.mean
    away = np.einsum("...i,ij,...j->...", shift, np.linalg.inv(normal.covariance), shift)
    row, column = np.unravel_index(away.argmin(), away.shape)
    return low + np.array([column, row])
