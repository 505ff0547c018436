"""The 8-bit picture that a radiance and a camera say, by formulas of docs/format.md, apart from the writer's."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from ...procedural.description.camera import Camera

#: Where highlights begin to be compressed, and the largest ratio of two channels of a grey-world mean [1].
KNEE, MOST_BALANCE = 0.7, 4.0
#: Weights of linear Rec.709 in luminance (ITU-R BT.709-6).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def encoded(light: np.ndarray, camera: Camera, gains: np.ndarray) -> np.ndarray:
    """Return the 8-bit values of a radiance, (H, W, 3) float32, not yet rounded.

    Float32 is off by some 1e-5 of a step.
    """
    factors = (camera.exposure * gains).astype(np.float32)
    value = np.maximum(light.astype(np.float32, copy=False) * factors, 0.0)
    if camera.tone.white > 1.0:
        high = value > KNEE
        value[high] = _shoulder(np.minimum(value[high], camera.tone.white), camera.tone.white)
    value = np.minimum(value, 1.0)
    # The sRGB curve, IEC 61966-2-1:1999.
    power = np.power(value, np.float32(1.0 / 2.4))
    return np.where(value > 0.0031308, 269.025 * power - 14.025, 3294.6 * value).astype(np.float32, copy=False)


def gains_of(left: np.ndarray, camera: Camera) -> np.ndarray:
    """Return the factors on red, green and blue, (3,): of both eyes, for a grey world those of the left picture."""
    if camera.tone.balance != "grey-world":
        return np.array(camera.tone.balance)
    mean = np.minimum(np.maximum(left.astype(np.float64) * camera.exposure, 0.0), 1.0).mean(axis=(0, 1))
    inverse = 1.0 / np.maximum(mean, mean.max() / MOST_BALANCE)
    return inverse / float(LUMINANCE @ inverse)


def _shoulder(value: np.ndarray, white: float) -> np.ndarray:
    """Return k + (1 - k) log(1 + a t) / log(1 + a), t from 0 at the knee k to 1 at white, with slope 1 at the knee."""
    span = (white - KNEE) / (1.0 - KNEE)
    a = brentq(lambda x: x / np.log1p(x) - span, 1e-9, 1e6)
    return KNEE + (1.0 - KNEE) * np.log1p(a * (value - KNEE) / (white - KNEE)) / np.log1p(a)
