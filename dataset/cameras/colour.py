"""Colour of a camera: the sensor's primaries, white balance, and the tone curve."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ...core.images import srgb_curve
from .model import ColourCamera

#: From linear Rec.709 to CIE XYZ (IEC 61966-2-1:1999).
_RGB_TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
#: Largest factor between two channels of white that is taken for the colour of the light: red against green of CIE
#: illuminant A, an incandescent lamp, in linear Rec.709 (1.845 / 0.826).
_MOST = 2.23
#: Norm by which the light's colour is estimated: 6 was best in Finlayson and Trezzi, Shades of Gray and Colour
#: Constancy, CIC 2004.
_NORM = 6
#: Pixels from which it is estimated are those below saturation, every fourth in each direction.
_SATURATED, _EVERY = 0.95, 4
#: Entries of the tone curve's table; two are closer than a step of the 8-bit picture everywhere.
_ENTRIES = 1 << 14


def to_sensor(camera: ColourCamera) -> np.ndarray:
    """Return the matrix from linear Rec.709 to the sensor's red, green and blue, (3, 3); white gives green 1."""
    if camera.xyz_to_sensor is None:
        return np.eye(3)
    matrix = np.array(camera.xyz_to_sensor) @ _RGB_TO_XYZ
    return matrix / matrix[1].sum()


def from_sensor(camera: ColourCamera) -> tuple[np.ndarray, np.ndarray]:
    """Return what takes the sensor's colours back: gains of red, green, blue for daylight (D65), and the matrix after.

    The rows of the matrix sum to 1, so that what the gains make neutral stays so.
    """
    gains = 1 / to_sensor(camera).sum(axis=1)
    return gains, np.linalg.inv(gains[:, None] * to_sensor(camera))


def balance(camera: ColourCamera, signal: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return the gains of red, green and blue that auto white balance sets, (3,) with green at daylight's.

    The light's colour is the channels' norm over the picture ("shades of grey"), taken against daylight's and no
    farther from it than an incandescent lamp's. The camera balances a part of it (`white_balance`), with an error.

    Parameters
    ----------
    camera : ColourCamera
        The camera.
    signal : (H, W, 3) float32
        Demosaiced colours of the sensor.
    rng : numpy.random.Generator
        Draws the error.
    """
    gains, _ = from_sensor(camera)
    error = camera.white_balance_error * rng.standard_normal(2)
    some = np.clip(signal[::_EVERY, ::_EVERY].reshape(-1, 3), 0, None)
    some = some[(some < _SATURATED).all(axis=1)]
    white = (some.astype(np.float64) ** _NORM).mean(axis=0) ** (1 / _NORM) * gains if len(some) else np.zeros(3)
    colour = np.zeros(3)
    if (white > 0).all():
        colour = np.clip(np.log(white / white[1]), -np.log(_MOST), np.log(_MOST))
    return gains * np.exp(-camera.white_balance * colour + [error[0], 0, error[1]])


def encoded(linear: np.ndarray, contrast: float) -> np.ndarray:
    """Return the 8-bit picture of linear Rec.709, (H, W, 3) float32 to uint8.

    The sRGB curve, then the smooth step 3 y^2 - 2 y^3 (Brooks et al., CVPR 2019) by the fraction `contrast`.
    """
    index = np.clip(linear, 0, 1)
    index *= _ENTRIES - 1
    index += 0.5
    return _table(contrast)[index.astype(np.uint16)]


@lru_cache(maxsize=8)
def _table(contrast: float) -> np.ndarray:
    y = srgb_curve(np.linspace(0, 1, _ENTRIES))
    return np.rint(255 * (y + contrast * (y * y * (3 - 2 * y) - y))).astype(np.uint8)
