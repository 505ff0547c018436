"""The heatmap of objects: a bivariate Gaussian over the visible pixels of each one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from .labels import ObjectLabel

#: Factor from the covariance of an object's pixels to that of its Gaussian (from the released code; the paper gives
#: none).
CONCENTRATION = 0.8
#: Variance of a uniform distribution over a pixel [px^2]. Added to the covariance of pixel centres it gives that of
#: pixel areas, so a single row of pixels has a width as well.
PIXEL_VARIANCE = 1.0 / 12.0
#: Least number of visible pixels of an object with heat [px]: a quarter of a cell of the networks' fields, 8 x 8 px.
MIN_PIXELS = 16
#: Cells with less heat have no target, and less hot peaks are no objects (from the released code).
HEAT_THRESHOLD = 0.3
#: Search radius of the hottest pixel around the mean of a Gaussian, in rows and columns [px].
_SEARCH_RADIUS = 4


@dataclass(frozen=True, eq=False)
class Gaussian:
    """A bivariate Gaussian over the image."""

    mean: np.ndarray  #: (2,) float64, (x, y) [px]
    covariance: np.ndarray  #: (2, 2) float64 [px^2]


def gaussian_of(mask: np.ndarray) -> Gaussian:
    """Return the Gaussian of an object's visible pixels, (H, W) bool with at least one pixel.

    Its mean is that of the pixels, its covariance that of the pixels times `CONCENTRATION`.
    """
    y, x = np.nonzero(mask)
    pixels = np.stack([x, y], axis=1).astype(np.float64)
    mean = pixels.mean(0)
    covariance = (pixels - mean).T @ (pixels - mean) / len(pixels)
    return Gaussian(mean, CONCENTRATION * (covariance + PIXEL_VARIANCE * np.eye(2)))


def is_detectable(visible: int, corners: np.ndarray) -> bool:
    """Return whether an object has heat: enough visible pixels, and its whole box in front of the camera.

    Parameters
    ----------
    visible : int
        Pixels where it is the first surface.
    corners : (8, 3) float
        Corners of its box, camera frame [m].
    """
    return visible >= MIN_PIXELS and bool((corners[:, 2] > 0.0).all())


def log_heat(gaussians: list[Gaussian], size: tuple[int, int], stride: int = 1) -> np.ndarray:
    """Return the logarithm of each Gaussian, scaled to 1 at its mean.

    -1/2 (p - m)^T C^-1 (p - m): the density of the paper, scaled to a peak of 1.

    Parameters
    ----------
    gaussians : list of Gaussian
        Of n objects.
    size : (int, int)
        Height and width of the image [px].
    stride : int
        Step between the computed rows and columns [px].

    Returns
    -------
    (n, ceil(H / stride), ceil(W / stride)) float32
    """
    height, width = size
    y, x = np.arange(0, height, stride, dtype=np.float32), np.arange(0, width, stride, dtype=np.float32)
    maps = np.empty((len(gaussians), len(y), len(x)), np.float32)
    for index, gaussian in enumerate(gaussians):
        (a, b), (_, d) = np.linalg.inv(gaussian.covariance).astype(np.float32)
        right, down = x - np.float32(gaussian.mean[0]), (y - np.float32(gaussian.mean[1]))[:, None]
        maps[index] = -0.5 * (a * right * right + (2.0 * b * down) * right + d * down * down)
    return maps


def heatmap(gaussians: list[Gaussian], size: tuple[int, int]) -> np.ndarray:
    """Return the largest heat of any object at each pixel, (H, W) float32 in [0, 1]; 0 without objects."""
    if not gaussians:
        return np.zeros(size, np.float32)
    return np.exp(log_heat(gaussians, size).max(axis=0))


def view_heatmap(ids: np.ndarray, objects: Iterable[ObjectLabel]) -> np.ndarray:
    """Return the heatmap of the objects of a view that networks are to detect (`is_detectable`).

    Parameters
    ----------
    ids : (H, W) integer
        Instance ids of the first surface.
    objects : iterable of ObjectLabel
        The objects.

    Returns
    -------
    (H, W) float32
        In [0, 1].
    """
    wanted = [item.id for item in objects if is_detectable(item.pixels.visible, np.asarray(item.box3d))]
    return heatmap([gaussian_of(ids == number) for number in wanted], (ids.shape[0], ids.shape[1]))


def peak_pixel(gaussian: Gaussian, size: tuple[int, int]) -> np.ndarray:
    """Return the hottest pixel (x, y) of a Gaussian in an image of (height, width), (2,) int.

    Usually the pixel that contains the mean, but a thin oblique object can have a hotter one along its length. Of
    equals the first in row order, as in `decoding.peaks`.
    """
    height, width = size
    low = np.maximum(np.floor(gaussian.mean).astype(int) - _SEARCH_RADIUS, 0)
    high = np.minimum(np.floor(gaussian.mean).astype(int) + _SEARCH_RADIUS + 2, [width, height])
    y, x = np.mgrid[low[1] : high[1], low[0] : high[0]]
    shift = np.stack([x, y], axis=-1) - gaussian.mean
    distance = np.einsum("...i,ij,...j->...", shift, np.linalg.inv(gaussian.covariance), shift)  # Mahalanobis, squared
    row, column = np.unravel_index(distance.argmin(), distance.shape)
    return low + np.array([column, row])
