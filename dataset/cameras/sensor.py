"""The sensor: Bayer mosaic, shot and read noise, converter, and demosaicing."""

from __future__ import annotations

import cv2
import numpy as np

from .model import Sensor

#: Filters of Malvar, He and Cutler, High-Quality Linear Interpolation for Demosaicing, ICASSP 2004, figure 2, in
#: eighths: green at red or blue; a colour at green whose neighbours in the row have it; red at blue or blue at red.
_GREEN = np.array([[0, 0, -1, 0, 0], [0, 0, 2, 0, 0], [-1, 2, 4, 2, -1], [0, 0, 2, 0, 0], [0, 0, -1, 0, 0]], np.float32)
_ROW = np.array(
    [[0, 0, 0.5, 0, 0], [0, -1, 0, -1, 0], [-1, 4, 5, 4, -1], [0, -1, 0, -1, 0], [0, 0, 0.5, 0, 0]], np.float32
)
_ACROSS = np.array(
    [[0, 0, -1.5, 0, 0], [0, 2, 0, 2, 0], [-1.5, 0, 6, 0, -1.5], [0, 2, 0, 2, 0], [0, 0, -1.5, 0, 0]], np.float32
)

#: Electrons from which Poisson's distribution is drawn as a Gaussian one: its skewness is 0.05 there.
_MANY = 400


def mosaic(light: np.ndarray) -> np.ndarray:
    """Return what a sensor behind a Bayer mosaic sees: rows R G, G B; (H, W, 3) to (H, W)."""
    seen = light[..., 1].copy()
    seen[::2, ::2] = light[::2, ::2, 0]
    seen[1::2, 1::2] = light[1::2, 1::2, 2]
    return seen


def summed_pixels(sensor: Sensor, width: int) -> np.ndarray | None:
    """Return how many pixels of the sensor each of red, green and blue of a picture's pixel is the sum of, (3,).

    None where a pixel of the picture covers no whole cell of the mosaic, 2 x 2 pixels: it has one colour then.
    """
    across = sensor.width / width
    return across**2 * np.array([0.25, 0.5, 0.25]) if across >= 2 else None


def noise_variance(signal: np.ndarray, sensor: Sensor, gain: float, pixels: np.ndarray | float = 1.0) -> np.ndarray:
    """Return the variance of `exposed` below saturation (the photon-transfer curve).

    Shot noise, read noise, and the converter's rounding, a twelfth of a step squared.
    """
    full, read = sensor.full_well * pixels / gain, sensor.read_noise * np.sqrt(pixels)
    return signal / full + (read / full) ** 2 + _step(sensor) ** 2 / 12


def exposed(
    light: np.ndarray, sensor: Sensor, gain: float, rng: np.random.Generator, pixels: np.ndarray | float = 1.0
) -> np.ndarray:
    """Return the signal that a sensor reports.

    Parameters
    ----------
    light : (H, W) or (H, W, 3) float32
        Light of each pixel; 1 saturates it.
    sensor : Sensor
        Its photon transfer.
    gain : float
        Analogue gain.
    rng : numpy.random.Generator
        Draws Poisson electrons and Gaussian read noise.
    pixels : float or (3,) float
        Pixels of the sensor of which each value is the sum: n of them hold n times the charge, with sqrt(n) times the
        read noise.

    Returns
    -------
    Same shape, float32
        Signal without the black level, at most 1. Noise below black is kept down to the converter's 0.
    """
    full = np.float32(sensor.full_well / gain) * np.asarray(pixels, np.float32)
    electrons = np.maximum(light, 0) * full
    noise = np.sqrt(electrons + np.float32(sensor.read_noise**2) * np.asarray(pixels, np.float32))
    noise *= rng.standard_normal(light.shape, np.float32)
    few = electrons < _MANY
    read = (sensor.read_noise * np.broadcast_to(np.sqrt(np.asarray(pixels, np.float32)), light.shape))[few]
    noisy = electrons + noise
    noisy[few] = rng.poisson(electrons[few]) + read * rng.standard_normal(len(read), np.float32)
    black, top = sensor.black_level, 2**sensor.bits - 1
    counts = np.clip(np.rint((noisy / full * np.float32(1 - black) + np.float32(black)) * np.float32(top)), 0, top)
    return (counts * np.float32(1 / top) - np.float32(black)) * np.float32(1 / (1 - black))


def demosaiced(signal: np.ndarray) -> np.ndarray:
    """Return three colours at each pixel of a Bayer mosaic, (H, W) to (H, W, 3) float32."""
    green, row, across = (_filtered(signal, kernel) for kernel in (_GREEN, _ROW, _ACROSS))
    column = _filtered(signal, np.ascontiguousarray(_ROW.T))
    picture = np.empty((*signal.shape, 3), np.float32)
    red_row, blue_row = picture[::2], picture[1::2]
    red_row[:, ::2, 0], red_row[:, 1::2, 0] = signal[::2, ::2], row[::2, 1::2]
    red_row[:, ::2, 1], red_row[:, 1::2, 1] = green[::2, ::2], signal[::2, 1::2]
    red_row[:, ::2, 2], red_row[:, 1::2, 2] = across[::2, ::2], column[::2, 1::2]
    blue_row[:, ::2, 0], blue_row[:, 1::2, 0] = column[1::2, ::2], across[1::2, 1::2]
    blue_row[:, ::2, 1], blue_row[:, 1::2, 1] = signal[1::2, ::2], green[1::2, 1::2]
    blue_row[:, ::2, 2], blue_row[:, 1::2, 2] = row[1::2, ::2], signal[1::2, 1::2]
    return picture


def _filtered(signal: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    # Reflected about the border pixel: the mosaic goes on with the right colours.
    return cv2.filter2D(signal, -1, kernel / 8, borderType=cv2.BORDER_REFLECT_101)


def _step(sensor: Sensor) -> float:
    """Return the converter's step, in units of the signal."""
    return 1 / ((2**sensor.bits - 1) * (1 - sensor.black_level))
