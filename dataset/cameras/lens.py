"""The lens: distortion by Brown and Conrady, its inverse, and the light's fall-off to the corners."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from ...core.errors import InputError
from .model import Coefficients, Distortion

#: Focal lengths and principal point (fx, fy, cx, cy) [px].
Lens = tuple[float, float, float, float]
#: Steps of Newton's method; its error is squared by each, and lenses of 45 degrees need 6.
_STEPS = 12
#: Largest error of an inverse [focal lengths]: a thousandth of a pixel in pictures of 1000 px.
_RESIDUAL = 1e-6
#: Points of each line from the centre to the border at which a distortion is checked for folds.
_ALONG = 64
#: Halvings by which the strongest distortion that does not fold is found, to a thousandth.
_HALVINGS = 10

#: Weight of pixels that were not rendered in one that is resampled, from which it counts as one of them.
_MOSTLY = 0.5


@dataclass(frozen=True, eq=False)
class Warp:
    """Where each pixel of a picture is found in another, (H, W) float32 each, and whether that is inside, bool."""

    x: np.ndarray
    y: np.ndarray
    inside: np.ndarray

    def applied(self, picture: np.ndarray) -> np.ndarray:
        """Return the picture resampled (bilinear); pixels from outside are those of its border."""
        return cv2.remap(picture, self.x, self.y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


@dataclass(frozen=True, eq=False)
class Warps:
    """From pinhole to lens and back."""

    distort: Warp  #: for each pixel of the lens' picture, where the pinhole's has it
    rectify: Warp  #: for each pixel of the pinhole's picture, where the lens' has it
    outside: np.ndarray  #: pixels of the lens' picture that the pinhole's does not have, (H, W) bool
    lost: np.ndarray  #: pixels of the rectified picture that the lens' does not have, (H, W) bool


def distorted(points: np.ndarray, lens: Distortion) -> np.ndarray:
    """Return where a lens puts points.

    Parameters
    ----------
    points : (..., 2) float64
        Slopes x / z, y / z of rays: image coordinates of a pinhole of focal length 1.
    lens : Distortion
        Brown, Decentering Distortion of Lenses, 1966, eq. 13, with OpenCV's order and signs of p1 and p2.

    Returns
    -------
    (..., 2) float64
        Distorted coordinates, focal length 1.
    """
    x, y = points[..., 0], points[..., 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))
    across = x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x)
    down = y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y
    return np.stack([across, down], axis=-1)


def undistorted(points: np.ndarray, lens: Distortion) -> np.ndarray:
    """Return the slopes of the rays that a lens puts at given points, (..., 2); NaN where Newton's method fails."""
    found = points.astype(np.float64, copy=True)
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            error = distorted(found, lens) - points
            a, b, d = _jacobian(found, lens)
            step = np.stack([d * error[..., 0] - b * error[..., 1], a * error[..., 1] - b * error[..., 0]], axis=-1)
            found -= step / (a * d - b * b)[..., None]
        wrong = ~(np.abs(distorted(found, lens) - points).max(axis=-1) < _RESIDUAL)
    found[wrong] = np.nan
    return found


def folds(lens: Distortion, optics: Lens, width: int, height: int) -> bool:
    """Return whether a distortion maps two rays to one point within the picture, or leaves a point of it without one.

    The determinant of the Jacobian has to be positive along each line from the principal point to the border: that of
    the pinhole's picture, and that of the lens'.
    """
    border = _slopes(_border(width, height), optics)
    ends = np.concatenate([border, undistorted(border, lens)])
    if not np.isfinite(ends).all():
        return True
    a, b, d = _jacobian(ends * np.linspace(0, 1, _ALONG)[:, None, None], lens)
    return not bool(((a * d - b * b > 0) & (a + d > 0)).all())


def check_distortion(lens: Distortion, optics: Lens, width: int, height: int, where: str) -> None:
    """Raise InputError where a distortion folds over inside the picture, with the fraction of it that does not."""
    if lens.absent or not folds(lens, optics, width, height):
        return
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if folds(lens.scaled(middle), optics, width, height) else (middle, high)
    expected = f"a distortion that does not fold over inside pictures of {width} x {height} px with fx {optics[0]:.4g}"
    nearest = f"{np.floor(low * 100) / 100:.2f} times all its coefficients"
    raise InputError(f"{where}: distortion", f"{expected}, such as {nearest}", f"k1 {lens.k1:g}, k2 {lens.k2:g}")


def warps(lens: Distortion, optics: Lens, width: int, height: int) -> Warps:
    """Return the maps between the pictures of a pinhole and of a lens with the same intrinsics."""
    return _warps(lens.coefficients, optics, width, height)


def falloff(lens: Distortion, optics: Lens, width: int, height: int) -> np.ndarray:
    """Return the cosine of the angle between each pixel's ray and the optical axis, (H, W, 1) float32.

    Its fourth power is the natural fall-off of illumination (Born and Wolf, Principles of Optics, section 4.8.1).
    """
    return _falloff(lens.coefficients, optics, width, height)


# All views of a data set have the same maps.
@lru_cache(maxsize=4)
def _warps(coefficients: Coefficients, optics: Lens, width: int, height: int) -> Warps:
    lens = Distortion.of(coefficients)
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
    slopes = _slopes(pixels, optics)
    distort = _warp(undistorted(slopes, lens), optics)
    rectify = _warp(distorted(slopes, lens), optics)
    outside = ~distort.inside
    lost = ~rectify.inside | (rectify.applied(outside.astype(np.float32)) > _MOSTLY)
    return Warps(distort, rectify, outside, lost)


@lru_cache(maxsize=4)
def _falloff(coefficients: Coefficients, optics: Lens, width: int, height: int) -> np.ndarray:
    lens = Distortion.of(coefficients)
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
    slopes = undistorted(_slopes(pixels, optics), lens)
    return (1 / np.sqrt(1 + (slopes**2).sum(axis=-1, keepdims=True))).astype(np.float32)


def _jacobian(points: np.ndarray, lens: Distortion) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the derivatives of `distorted`: across by x, across by y (which is down by x), down by y."""
    x, y = points[..., 0], points[..., 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))
    slope = 2 * (lens.k1 + r2 * (2 * lens.k2 + r2 * 3 * lens.k3))
    a = radial + x * x * slope + 2 * lens.p1 * y + 6 * lens.p2 * x
    b = x * y * slope + 2 * lens.p1 * x + 2 * lens.p2 * y
    d = radial + y * y * slope + 6 * lens.p1 * y + 2 * lens.p2 * x
    return a, b, d


def _slopes(pixels: np.ndarray, optics: Lens) -> np.ndarray:
    fx, fy, cx, cy = optics
    return (pixels - np.array([cx, cy])) / np.array([fx, fy])


def _border(width: int, height: int) -> np.ndarray:
    across, down = np.arange(width), np.arange(height)
    rows = [np.stack([across, np.full(width, y)], axis=-1) for y in (0, height - 1)]
    columns = [np.stack([np.full(height, x), down], axis=-1) for x in (0, width - 1)]
    return np.concatenate([*rows, *columns])


def _warp(slopes: np.ndarray, optics: Lens) -> Warp:
    height, width = slopes.shape[:2]
    fx, fy, cx, cy = optics
    x, y = slopes[..., 0] * fx + cx, slopes[..., 1] * fy + cy
    # A pixel covers half a pixel around its centre; there the border pixels' own values count.
    inside = (x >= -0.5) & (x <= width - 0.5) & (y >= -0.5) & (y <= height - 0.5)
    return Warp(x.astype(np.float32), y.astype(np.float32), inside)
