"""What a sensor with a polarising filter on each pixel reports of Stokes vectors, and the vectors that follow from it.

The light behind a filter is `core.polarisation.behind_filter`. The way back takes the light of each axis, and in colour
of each colour, from the pixels that have it, by bilinear interpolation, and the vector by least squares.
"""

from __future__ import annotations

from typing import Protocol

import cv2
import numpy as np

from ...core.polarisation import behind_filter
from ...procedural.description.polarisation_camera import PolarisationCamera
from ...procedural.surroundings.colour import luminance
from ..cameras.model import Sensor
from ..cameras.sensor import exposed, noise_variance

#: Channel of each colour of a Bayer mosaic, row by row.
_BAYER = np.array([[0, 1], [1, 2]])


class Filters(Protocol):
    """The filters of a sensor."""

    @property
    def axes(self) -> np.ndarray:
        """Axes of the filters of a cell, (2, 2) [rad]."""
        ...

    @property
    def colour(self) -> bool:
        """Whether each cell lies behind one colour of a Bayer mosaic."""
        ...

    @property
    def extinction_ratio(self) -> float:
        """Light that passes along the axis over light that passes across it."""
        ...


def pixel_axes(filters: Filters, shape: tuple[int, int]) -> np.ndarray:
    """Return the axis of each pixel's filter, (H, W) [rad]; the first pixel is the first one of a cell."""
    return _tiled(filters.axes, shape)


def pixel_channels(filters: Filters, shape: tuple[int, int]) -> np.ndarray:
    """Return the channel that each pixel sees, (H, W): 0, 1, 2 are red, green, blue; 0 everywhere without colours."""
    cells = np.kron(_BAYER, np.ones((2, 2), int)) if filters.colour else np.zeros((1, 1), int)
    return _tiled(cells, shape)


def filtered_light(filters: Filters, stokes: np.ndarray) -> np.ndarray:
    """Return the light behind the filter of each pixel, (H, W).

    Parameters
    ----------
    filters : Filters
        The sensor's.
    stokes : (H, W, 4, 3) float
        Stokes vectors in linear Rec.709; a sensor without colours sees their luminance.
    """
    shape = stokes.shape[:2]
    seen = stokes if filters.colour else luminance(stokes)[..., None]
    light = behind_filter(seen, pixel_axes(filters, shape), filters.extinction_ratio)
    return np.take_along_axis(light, pixel_channels(filters, shape)[..., None], axis=-1)[..., 0]


def reported(device: PolarisationCamera, stokes: np.ndarray, gain: float, rng: np.random.Generator) -> np.ndarray:
    """Return the numbers that a polarisation camera reports, (H, W) uint16.

    Parameters
    ----------
    device : PolarisationCamera
        The camera.
    stokes : (H, W, 4, 3) float
        Stokes vectors, radiance in linear Rec.709.
    gain : float
        Signal for each unit of radiance; a signal of 1 saturates a pixel.
    rng : numpy.random.Generator
        Draws the noise.
    """
    light = np.maximum(filtered_light(device, stokes) * gain, 0.0).astype(np.float32)
    signal = exposed(light, _sensor(device), 1.0, rng)
    top = 2**device.bits - 1
    return np.rint((signal * (1.0 - device.black_level) + device.black_level) * top).astype(np.uint16)


def reported_variance(device: PolarisationCamera, light: np.ndarray) -> np.ndarray:
    """Return the variance of the signal that is reported of a light below saturation."""
    return noise_variance(light, _sensor(device), 1.0)


def signal_of(numbers: np.ndarray, bits: int, black_level: float) -> np.ndarray:
    """Return the signal of reported numbers, float32: 0 is black, 1 saturated."""
    whole = numbers.astype(np.float32) / np.float32(2**bits - 1)
    return (whole - np.float32(black_level)) / np.float32(1.0 - black_level)


def stokes_of_mosaic(filters: Filters, light: np.ndarray) -> np.ndarray:
    """Return the Stokes vectors s0, s1, s2 of a mosaic.

    Exact where the light is the same over the pixels that are interpolated, and without colours where it changes
    linearly. At edges of the picture of things the four axes see different places, and degrees are wrong.

    Parameters
    ----------
    filters : Filters
        The sensor's. Their extinction ratio is corrected.
    light : (H, W) float
        Light behind the filter of each pixel.

    Returns
    -------
    (H, W, 3, channels) float32
        Three channels in colour, else one.
    """
    axes, channels = pixel_axes(filters, light.shape), pixel_channels(filters, light.shape)
    order, across = filters.axes.ravel(), 1.0 / filters.extinction_ratio
    waves = np.stack([np.full(4, 1.0 + across), *((1.0 - across) * f(2.0 * order) for f in (np.cos, np.sin))], axis=1)
    inverse = np.linalg.pinv(0.5 * waves).astype(np.float32)
    reach = 4 if filters.colour else 2
    found = []
    for channel in range(3 if filters.colour else 1):
        planes = [_interpolated(light, (axes == axis) & (channels == channel), reach) for axis in order]
        found.append(np.tensordot(inverse, np.stack(planes), 1))
    return np.moveaxis(np.stack(found, axis=-1), 0, 2)


def _interpolated(light: np.ndarray, known: np.ndarray, reach: int) -> np.ndarray:
    """Return a light that is known at some pixels at every pixel, (H, W) float32, with weights that fall linearly."""
    line = 1.0 - np.abs(np.arange(1 - reach, reach)) / reach
    kernel, values = np.outer(line, line).astype(np.float32), np.where(known, light, 0.0).astype(np.float32)
    sums, weights = (
        cv2.filter2D(x, -1, kernel, borderType=cv2.BORDER_CONSTANT) for x in (values, known.astype(np.float32))
    )
    return sums / np.maximum(weights, np.float32(1e-6))


def _tiled(cells: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    rows, columns = (-(-side // cell) for side, cell in zip(shape, cells.shape, strict=True))
    return np.tile(cells, (rows, columns))[: shape[0], : shape[1]]


def _sensor(device: PolarisationCamera) -> Sensor:
    return Sensor(
        width=1,
        full_well=device.full_well,
        read_noise=device.read_noise,
        bits=device.bits,
        black_level=device.black_level,
    )
