"""Colour of a camera: the sensor's primaries or sensitivities, white balance, and the tone curve."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ...core.images import srgb_curve
from .model import ColourCamera, SensorColour

#: From linear Rec.709 to CIE XYZ (IEC 61966-2-1:1999).
_RGB_TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
#: From CIE XYZ to the sharpened cones of the chromatic adaptation CAT02 (CIE 159:2004, eq. 5.1).
_CAT02 = np.array([[0.7328, 0.4296, -0.1624], [-0.7036, 1.6975, 0.0061], [0.0030, 0.0136, 0.9834]])
#: Least signal of a cone in a light of the scene, over daylight's [1]: half of what it is in illuminant A (0.34 for the
#: short wavelengths). A matrix that gives less was not made for that light.
_LEAST_CONE = 0.17
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


def to_sensor(camera: ColourCamera, sensor: SensorColour | None = None) -> np.ndarray:
    """Return the matrix from linear Rec.709 to the sensor's red, green and blue, (3, 3); white gives green 1.

    With measured sensitivities it is that from their raw responses, which replace the camera's primaries.
    """
    if sensor is not None:
        return np.diag(sensor.white)
    if camera.xyz_to_sensor is None:
        return np.eye(3)
    matrix = np.array(camera.xyz_to_sensor) @ _RGB_TO_XYZ
    return matrix / matrix[1].sum()


def from_sensor(camera: ColourCamera, sensor: SensorColour | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return what takes the sensor's colours back: gains of red, green, blue for daylight (D65), and the matrix after.

    The rows of the matrix sum to 1, so that what the gains make neutral stays so.
    """
    gains = 1 / to_sensor(camera, sensor).sum(axis=1)
    if sensor is not None:
        return gains, np.array(sensor.matrix)
    return gains, np.linalg.inv(gains[:, None] * to_sensor(camera))


def balanced_matrix(camera: ColourCamera, gains: np.ndarray, sensor: SensorColour | None = None) -> np.ndarray:
    """Return the colour matrix behind white balance by some gains, (3, 3); rows sum to 1.

    Gains alone are von Kries' adaptation in the sensor's channels. Those of measured sensitivities overlap, so that
    this is wrong by twice as much as CAT02 (docs/cameras.md): the matrix turns gains into that. It undoes them, goes to
    XYZ as in daylight, and scales cones from the light that the gains make neutral to D65 (Li et al., CIC 2002).
    """
    daylight, matrix = from_sensor(camera, sensor)
    if sensor is None:
        return matrix
    light = daylight / gains  # raw response to the light that is balanced
    seen = _RGB_TO_XYZ @ matrix @ (light / light[1])
    cones, neutral = _CAT02 @ seen, _CAT02 @ _RGB_TO_XYZ.sum(axis=1) * seen[1]
    if not (cones > _LEAST_CONE * neutral).all():
        return matrix
    adapted = np.linalg.inv(_CAT02) @ np.diag(neutral / cones) @ _CAT02
    return np.linalg.inv(_RGB_TO_XYZ) @ adapted @ _RGB_TO_XYZ @ matrix @ np.diag(light / light[1]) / seen[1]


def balance(
    camera: ColourCamera, signal: np.ndarray, rng: np.random.Generator, sensor: SensorColour | None = None
) -> np.ndarray:
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
    sensor : SensorColour, optional
        Of measured sensitivities. The error is one of red and blue of the picture then, not of the raw channels.
    """
    gains, _ = from_sensor(camera, sensor)
    error = camera.white_balance_error * rng.standard_normal(2)
    some = np.clip(signal[::_EVERY, ::_EVERY].reshape(-1, 3), 0, None)
    some = some[(some < _SATURATED).all(axis=1)]
    white = (some.astype(np.float64) ** _NORM).mean(axis=0) ** (1 / _NORM) * gains if len(some) else np.zeros(3)
    colour = np.zeros(3)
    if (white > 0).all():
        colour = np.clip(np.log(white / white[1]), -np.log(_MOST), np.log(_MOST))
    error = np.array([error[0], 0, error[1]])
    if sensor is None:
        return gains * np.exp(-camera.white_balance * colour + error)
    return gains / _mistaken(np.exp(camera.white_balance * colour), error, np.array(sensor.matrix))


def _mistaken(light: np.ndarray, error: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Return the raw response to a light that is off by logarithms of red, green and blue of the picture, (3,).

    Errors of gains would grow with the overlap of the sensor's channels, which a camera is calibrated for.
    """
    other = np.linalg.solve(matrix, np.exp(-error) * (matrix @ light))
    return other / other[1] if (other > 0).all() else light * np.exp(-error)


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
