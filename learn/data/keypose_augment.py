"""KeyPose's own augmentation of windows: an occluder, noise, gamma, blur, hue, saturation, contrast, brightness.

(Ranges of the released code.) The pixels of its ranges are those of a window 180 px wide, and scale with the width.
"""

from __future__ import annotations

import cv2
import numpy as np

#: Width of the windows that the ranges in pixels are for [px].
_WIDTH = 180.0
#: Radius of the occluder over that of a circle with the object's area; its grey value.
_OCCLUDER, _GREY = 0.4, 128
#: Greatest amplitude of a noise [8-bit values], and how often it is added.
_NOISE, _NOISES = 2.0, 2
_GAMMA, _SATURATION, _CONTRAST = (0.8, 1.2), (0.6, 1.2), (0.7, 1.2)
#: Greatest standard deviation of the blur at 180 px [px], turn of hues [turns], and change of brightness.
_BLUR, _HUE, _BRIGHTNESS = 4.0, 0.1, 32.0 / 255.0


def window_augmented(pictures: np.ndarray, area: float, rng: np.random.Generator) -> np.ndarray:
    """Return the windows of both eyes as another camera would take them, something in front of the object.

    Parameters
    ----------
    pictures : (2, h, w, 3) uint8
        Windows.
    area : float
        Pixels of the object, from which the size of the occluder follows.
    rng : numpy.random.Generator
        Random generator; the occluder is at the same place in both eyes, the rest is drawn for each.
    """
    height, width = pictures.shape[1:3]
    radius = _OCCLUDER * np.sqrt(area / np.pi)
    centre = rng.uniform(0.0, 1.0, 2) * (width, height)
    axes, angle = radius * rng.uniform(0.5, 1.0, 2), rng.uniform(0.0, 180.0)
    found = []
    for picture in pictures:
        occluded = np.ascontiguousarray(picture)
        box = (tuple(map(float, centre)), tuple(float(2.0 * side) for side in axes), float(angle))
        cv2.ellipse(occluded, box, (_GREY, _GREY, _GREY), -1)
        found.append(_retaken(occluded.astype(np.float32) / 255.0, width / _WIDTH, rng))
    return np.stack(found)


def _retaken(image: np.ndarray, scale: float, rng: np.random.Generator) -> np.ndarray:
    for _ in range(_NOISES):
        amplitude = rng.uniform(0.0, _NOISE) / 255.0
        image = image + amplitude * rng.standard_normal(image.shape, np.float32)
    image = np.clip(image, 0.0, 1.0) ** np.float32(rng.uniform(*_GAMMA))
    deviation = scale * rng.uniform(0.0, _BLUR)
    if deviation > 0.1:  # a smaller Gaussian has a single weight
        image = cv2.GaussianBlur(image, (0, 0), deviation, borderType=cv2.BORDER_REPLICATE)
    hsv = cv2.cvtColor(image.astype(np.float32), cv2.COLOR_RGB2HSV)
    hsv[..., 0] = (hsv[..., 0] + 360.0 * rng.uniform(-_HUE, _HUE)) % 360.0
    hsv[..., 1] = np.clip(hsv[..., 1] * rng.uniform(*_SATURATION), 0.0, 1.0)
    image = cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)
    mean = image.mean(axis=(0, 1), keepdims=True)
    image = (image - mean) * rng.uniform(*_CONTRAST) + mean + rng.uniform(-_BRIGHTNESS, _BRIGHTNESS)
    return np.rint(np.clip(image, 0.0, 1.0) * 255.0).astype(np.uint8)
