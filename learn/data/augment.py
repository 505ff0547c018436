"""Image augmentation that simulates other cameras.

In the order of a camera: blur of the lens, hue, exposure and white balance on linear light, shot and read noise, the
sRGB curve, 8 bits, JPEG.
"""

from __future__ import annotations

import cv2
import numpy as np

from ...core.images import srgb8
from .settings import AugmentSettings


def augmented(images: np.ndarray, settings: AugmentSettings, rng: np.random.Generator) -> np.ndarray:
    """Return the images of a sample as another camera would take them.

    Parameters
    ----------
    images : (V, H, W, 3) uint8
        sRGB.
    settings : AugmentSettings
        Ranges. All views share one draw, but for a part of the exposure and their noise.
    rng : numpy.random.Generator
        Random generator.

    Returns
    -------
    (V, H, W, 3) uint8
    """
    if rng.uniform() >= settings.probability:
        return images
    exposure = rng.uniform(-settings.exposure, settings.exposure)
    red, blue = rng.uniform(-settings.balance, settings.balance, 2)
    gains = exposure + np.array([red, 0.0, blue])
    turn = hue_turn(rng.uniform(-settings.hue, settings.hue))
    shot, read = rng.uniform(0.0, settings.shot_noise), rng.uniform(0.0, settings.read_noise)
    blur, quality = rng.uniform(0.0, settings.blur), int(rng.integers(settings.jpeg[0], settings.jpeg[1] + 1))
    changed = []
    for image in images:
        view_exposure = rng.uniform(-settings.view_exposure, settings.view_exposure)
        light = np.maximum(_blurred(linear(image), blur) @ turn.T, 0.0) * np.exp2(gains + view_exposure).astype(
            np.float32
        )
        changed.append(_jpeg(srgb8(with_noise(light, shot, read, rng), 1.0), quality))
    return np.stack(changed)


def hue_turn(angle: float) -> np.ndarray:
    """Return the matrix that turns linear colours about the grey axis, (3, 3) float32: grey stays, hues change.

    Rodrigues' formula about (1, 1, 1) / sqrt(3): cos I + (1 - cos) / 3 + sin / sqrt(3) [1]_x.
    """
    cosine, sine = np.cos(angle), np.sin(angle) / np.sqrt(3.0)
    cross = np.array([[0.0, -1.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])
    return (cosine * np.eye(3) + (1.0 - cosine) / 3.0 + sine * cross).astype(np.float32)


def linear(image: np.ndarray) -> np.ndarray:
    """Return linear values in [0, 1], float32, of 8-bit sRGB (IEC 61966-2-1:1999)."""
    encoded = np.arange(256) / 255.0
    table = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return table.astype(np.float32)[image]


def with_noise(light: np.ndarray, shot: float, read: float, rng: np.random.Generator) -> np.ndarray:
    """Return linear light with sensor noise of the variance shot^2 x + read^2 at the value x.

    (Foi et al., "Practical Poissonian-Gaussian noise modeling and fitting for single-image raw-data", IEEE TIP 2008,
    eq. 3.)
    """
    deviation = np.sqrt(shot**2 * light + read**2, dtype=np.float32)
    return light + rng.standard_normal(light.shape, np.float32) * deviation


def _blurred(light: np.ndarray, deviation: float) -> np.ndarray:
    # Below a tenth of a pixel OpenCV's Gaussian has a single weight.
    return light if deviation < 0.1 else cv2.GaussianBlur(light, (0, 0), deviation, borderType=cv2.BORDER_REPLICATE)


def _jpeg(image: np.ndarray, quality: int) -> np.ndarray:
    done, data = cv2.imencode(".jpg", np.ascontiguousarray(image[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, quality])
    read = cv2.imdecode(data, cv2.IMREAD_COLOR) if done else None
    assert read is not None
    return read[..., ::-1]
