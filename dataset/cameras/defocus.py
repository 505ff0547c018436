"""Defocus of a thin lens, by the depth of each pixel's first surface."""

from __future__ import annotations

import cv2
import numpy as np

#: Circles that differ by less are blurred alike [px].
_STEP = 0.5
#: Most layers of depth.
_LAYERS = 16
#: Circles of less than a pixel's width stay inside of it [px].
_LEAST = 1.0
#: Samples across a pixel by which its part of a circle is found.
_FINE = 9
#: Part of the picture, in each direction, on whose median depth autofocus sets the lens.
_MIDDLE = 1 / 3


def circle(Z: np.ndarray, aperture: float, focus: float, focal: float) -> np.ndarray:
    """Return the signed diameter of the circle of confusion: positive behind the plane in focus.

    From the thin-lens equation, with the distance of the image plane f v / (v - f) as K's focal length: the diameter is
    aperture * focal * |1 / focus - 1 / Z|, exactly.

    Parameters
    ----------
    Z : (H, W) float
        Planar depth [m]; +inf where there is nothing.
    aperture, focus : float
        Diameter of the entrance pupil and distance in focus [m].
    focal : float
        Focal length of K [px].

    Returns
    -------
    (H, W) float32
        [px]
    """
    return (aperture * focal * (1 / focus - 1 / Z)).astype(np.float32)


def focused_at(Z: np.ndarray) -> float:
    """Return the distance that autofocus sets: the median depth of the picture's middle [m]; +inf without a surface."""
    height, width = Z.shape
    top, side = int(height * _MIDDLE), int(width * _MIDDLE)
    middle = Z[top : height - top, side : width - side]
    seen = middle[np.isfinite(middle)]
    return float(np.median(seen)) if seen.size else np.inf


def defocused(light: np.ndarray, diameter: np.ndarray) -> np.ndarray:
    """Return a picture with each pixel's light spread over its circle of confusion.

    Pixels are sorted into layers by their circles. Each layer's light and coverage are spread over its mean circle, and
    nearer layers cover farther ones by their coverage. What a nearer edge uncovers of the layers behind it is not in
    the picture: there the light that arrives is divided by its coverage.

    Parameters
    ----------
    light : (H, W, 3) float32
        Linear radiance.
    diameter : (H, W) float32
        From `circle` [px].

    Returns
    -------
    (H, W, 3) float32
    """
    low, high = float(diameter.min()), float(diameter.max())
    if max(abs(low), abs(high)) < _LEAST:
        return light
    count = min(_LAYERS, max(1, int(np.ceil((high - low) / _STEP))))
    layer = np.minimum((diameter - low) * (count / max(high - low, 1e-9)), count - 1).astype(np.uint8)
    total = np.zeros((*diameter.shape, 4), np.float32)
    for number in reversed(range(count)):  # from far to near
        inside = layer == number
        if inside.any():
            spread = _spread(light, inside, float(diameter[inside].mean()))
            total = spread + total * (1 - np.minimum(spread[..., 3:], 1))
    return total[..., :3] / np.maximum(total[..., 3:], 1e-6)


def disc(diameter: float) -> np.ndarray:
    """Return how much of a disc's light each pixel gets, (n, n) float32 with n odd and sum 1."""
    reach = int(np.ceil(max(diameter, 1.0) / 2 - 0.5))
    size = 2 * reach + 1
    fine = (np.arange(size * _FINE) + 0.5) / _FINE - size / 2
    inside = np.hypot(fine[:, None], fine[None, :]) <= max(diameter, 1e-3) / 2
    kernel = inside.reshape(size, _FINE, size, _FINE).mean(axis=(1, 3))
    return (kernel / kernel.sum() if kernel.any() else _point(size)).astype(np.float32)


def right_depth(Z: np.ndarray, shift: float) -> np.ndarray:
    """Return the depth of the right picture, from the left one's.

    Each pixel is moved by its disparity, and the nearest that arrives at a pixel counts. Pixels that the left camera
    does not see get the farther of their neighbours in the row.

    Parameters
    ----------
    Z : (H, W) float32
        Planar depth of the left camera [m].
    shift : float
        Focal length times baseline [px m].

    Returns
    -------
    (H, W) float32
    """
    height, width = Z.shape
    disparity = (shift / Z).astype(np.float32)
    across = np.rint(np.arange(width) - disparity).astype(np.int64)
    rows = np.broadcast_to(np.arange(height)[:, None], Z.shape)
    kept = (across >= 0) & (across < width)
    found = np.full(Z.shape, -1, np.float32)
    np.maximum.at(found.reshape(-1), (rows * width + across)[kept], disparity[kept])
    filled = np.where(found >= 0, found, np.minimum(_carried(found), _carried(found[:, ::-1])[:, ::-1]))
    with np.errstate(divide="ignore"):
        return shift / np.where(np.isfinite(filled), filled, 0)


def _carried(found: np.ndarray) -> np.ndarray:
    """Return rows in which the last known value is carried on; +inf before the first."""
    last = np.maximum.accumulate(np.where(found >= 0, np.arange(found.shape[1]), -1), axis=1)
    return np.where(last >= 0, np.take_along_axis(found, np.maximum(last, 0), axis=1), np.inf)


def _spread(light: np.ndarray, inside: np.ndarray, diameter: float) -> np.ndarray:
    """Return light and coverage of a layer, spread over a circle, (H, W, 4) float32."""
    part = np.dstack([light, np.ones(light.shape[:2], np.float32)]) * inside[..., None].astype(np.float32)
    kernel = disc(abs(diameter))
    return part if kernel.size == 1 else cv2.filter2D(part, -1, kernel, borderType=cv2.BORDER_REFLECT_101)


def _point(size: int) -> np.ndarray:
    kernel = np.zeros((size, size))
    kernel[size // 2, size // 2] = 1
    return kernel
