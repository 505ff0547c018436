"""Pictures as other cameras would have taken them.

In the order in which a camera does it: blur of the lens, exposure and white balance on linear light, shot and read
noise, the sRGB curve, 8 bits, JPEG.
"""

from __future__ import annotations

import cv2
import numpy as np

from ...dataset.format.pictures import srgb8
from .settings import AugmentSettings


def augmented(pictures: np.ndarray, settings: AugmentSettings, rng: np.random.Generator) -> np.ndarray:
    """Return the views of a sample as one other camera took them.

    Parameters
    ----------
    pictures : (V, H, W, 3) uint8
        sRGB.
    settings : AugmentSettings
        How much may change. The views share all but a part of the exposure and their noise.
    rng : numpy.random.Generator
        Decides the change.

    Returns
    -------
    (V, H, W, 3) uint8
    """
    if rng.uniform() >= settings.share:
        return pictures
    exposure = rng.uniform(-settings.exposure, settings.exposure)
    red, blue = rng.uniform(-settings.balance, settings.balance, 2)
    gains = exposure + np.array([red, 0.0, blue])
    shot, read = rng.uniform(0.0, settings.shot_noise), rng.uniform(0.0, settings.read_noise)
    blur, quality = rng.uniform(0.0, settings.blur), int(rng.integers(settings.jpeg[0], settings.jpeg[1] + 1))
    changed = []
    for picture in pictures:
        own = rng.uniform(-settings.between, settings.between)
        light = _blurred(linear(picture), blur) * np.exp2(gains + own).astype(np.float32)
        changed.append(_compressed(srgb8(with_noise(light, shot, read, rng), 1.0), quality))
    return np.stack(changed)


def linear(picture: np.ndarray) -> np.ndarray:
    """Return linear values in [0, 1], float32, of 8-bit sRGB (IEC 61966-2-1:1999)."""
    encoded = np.arange(256) / 255.0
    table = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return table.astype(np.float32)[picture]


def with_noise(light: np.ndarray, shot: float, read: float, rng: np.random.Generator) -> np.ndarray:
    """Return linear light with a sensor's noise, of the variance shot^2 x + read^2 at the value x.

    (Foi et al., "Practical Poissonian-Gaussian noise modeling and fitting for single-image raw-data", IEEE TIP 2008,
    eq. 3.)
    """
    deviation = np.sqrt(shot**2 * light + read**2, dtype=np.float32)
    return light + rng.standard_normal(light.shape, np.float32) * deviation


def _blurred(light: np.ndarray, deviation: float) -> np.ndarray:
    # Under a tenth of a pixel a Gaussian of OpenCV's has one weight alone.
    return light if deviation < 0.1 else cv2.GaussianBlur(light, (0, 0), deviation, borderType=cv2.BORDER_REPLICATE)


def _compressed(picture: np.ndarray, quality: int) -> np.ndarray:
    done, data = cv2.imencode(".jpg", np.ascontiguousarray(picture[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, quality])
    read = cv2.imdecode(data, cv2.IMREAD_COLOR) if done else None
    assert read is not None
    return read[..., ::-1]
