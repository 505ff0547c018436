"""The lens: distortion by Brown and Conrady, its inverse, and the light's fall-off to the corners."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import cv2
import numpy as np

from ...core.errors import InputError
from ...core.margin import NO_MARGIN, Sides, pixel_grid
from .model import Coefficients, Distortion

#: Focal lengths and principal point (fx, fy, cx, cy) [px].
Lens = tuple[float, float, float, float]
#: Steps of Newton's method; its error is squared by each, and lenses of 45 degrees need 6.
_STEPS = 12
#: Largest error of an inverse [focal lengths]: a thousandth of a pixel in pictures of 1000 px.
_RESIDUAL = 1e-6
#: Points of each line from the centre to the border at which a distortion is checked for folds.
_ALONG = 64
#: Halvings by which the strongest distortion that does not fold is found, to a thousandth of it.
_HALVINGS = 10
#: Digits of what an error line suggests.
_DIGITS = 3
#: Pixels of the lens' picture around one that is resampled which have a part in it: a neighbour of the bilinear
#: filter, and two for its demosaicing.
_BESIDE = 3
#: Most pixels of the pinhole's picture that each of them may take [px]: more only at a fold.
_MOST = 8

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
    """From pinhole to lens and back; (H, W) are those of the frame, and of each picture with its margin."""

    distort: Warp  #: for each pixel of the lens' picture, where the pinhole's has it
    rectify: Warp  #: for each pixel of the pinhole's picture, where the lens' has it
    outside: np.ndarray  #: pixels of the lens' picture that the pinhole's does not have, bool
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
    """Raise InputError where a distortion folds over inside the picture, with what does not.

    That is a fraction of all coefficients, and focal lengths that many times as long, which see less of the lens.
    """
    if lens.absent or not folds(lens, optics, width, height):
        return

    def longer(factor: float) -> Lens:
        return factor * optics[0], factor * optics[1], optics[2], optics[3]

    weaker = _largest(lambda factor: not folds(lens.scaled(factor), optics, width, height))
    shorter = _largest(lambda factor: not folds(lens, longer(1 / factor), width, height))
    expected = f"a distortion that does not fold over inside pictures of {width} x {height} px with fx {optics[0]:.4g}"
    nearest = f"{_rounded(weaker, np.floor)} times all its coefficients, or {_rounded(1 / shorter, np.ceil)} times fx"
    raise InputError(f"{where}: distortion", f"{expected}, such as {nearest}", f"k1 {lens.k1:g}, k2 {lens.k2:g}")


def _largest(fits: Callable[[float], bool]) -> float:
    """Return the largest factor below 1 that fits, to a thousandth of itself; all smaller ones fit as well."""
    low = 0.5
    while not fits(low):
        low /= 2
    high = 2 * low
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low


def _rounded(value: float, towards: Callable[[float], float]) -> str:
    """Return a number of `_DIGITS` digits that lies on one side of a value."""
    step = 10.0 ** (np.floor(np.log10(value)) - _DIGITS + 1)
    return f"{towards(value / step) * step:.{_DIGITS}g}"


def margins(lens: Distortion, rectified: bool, optics: Lens, width: int, height: int) -> tuple[Sides, Sides]:
    """Return the margins that the pictures of a pinhole and of a lens need so that none of the frame's pixels is lost.

    A rectified picture needs all that its own pixels are resampled from; the picture that keeps its distortion is the
    frame, and needs the pinhole's picture as far as its border sees. The margins of the lens' picture are even: its
    mosaic begins with the same colour.

    Parameters
    ----------
    lens : Distortion
        One that does not fold over inside the frame (`check_distortion`).
    rectified : bool
        Whether the picture is resampled to the pinhole's.
    optics : Lens
        Of the frame.
    width, height : int
        Of the frame [px].

    Returns
    -------
    rendered, sensed : Sides
        Of the pinhole's picture, and of the lens' [px].
    """
    return _margins(lens.coefficients, rectified, optics, width, height)


def warps(
    lens: Distortion,
    optics: Lens,
    width: int,
    height: int,
    rendered: Sides = NO_MARGIN,
    sensed: Sides = NO_MARGIN,
) -> Warps:
    """Return the maps between the pictures of a pinhole and of a lens with the same intrinsics.

    Parameters
    ----------
    lens : Distortion
        The lens.
    optics : Lens
        Of the frame.
    width, height : int
        Of the frame, which the rectified picture is [px].
    rendered, sensed : Sides
        Margins of the pinhole's and of the lens' picture around it.
    """
    return _warps(lens.coefficients, optics, width, height, rendered, sensed)


def falloff(lens: Distortion, optics: Lens, width: int, height: int, sensed: Sides = NO_MARGIN) -> np.ndarray:
    """Return the cosine of the angle between each pixel's ray and the optical axis, (H, W, 1) float32.

    Its fourth power is the natural fall-off of illumination (Born and Wolf, Principles of Optics, section 4.8.1).
    `sensed` is the margin of the lens' picture, which is returned with it.
    """
    return _falloff(lens.coefficients, optics, width, height, sensed)


# All views of a data set have the same maps.
@lru_cache(maxsize=4)
def _margins(coefficients: Coefficients, rectified: bool, optics: Lens, width: int, height: int) -> tuple[Sides, Sides]:
    lens = Distortion.of(coefficients)
    if lens.absent:
        return NO_MARGIN, NO_MARGIN
    border = _slopes(_border(width, height), optics)
    if not rectified:
        return _reach(_pixels(undistorted(border, lens), optics), width, height), NO_MARGIN
    ends = _pixels(distorted(border, lens), optics)
    around = [ends + np.array([x, y]) for x in (-_BESIDE, 0, _BESIDE) for y in (-_BESIDE, 0, _BESIDE)]
    sensed = tuple(side + side % 2 for side in _reach(np.concatenate(around), width, height))
    needed = [_pixels(undistorted(_slopes(points, optics), lens), optics) for points in around]
    rendered = tuple(min(side, _MOST * _BESIDE) for side in _reach(np.concatenate(needed), width, height))
    return cast(Sides, rendered), cast(Sides, sensed)


@lru_cache(maxsize=4)
def _warps(coefficients: Coefficients, optics: Lens, width: int, height: int, rendered: Sides, sensed: Sides) -> Warps:
    lens = Distortion.of(coefficients)
    rays = undistorted(_slopes(pixel_grid(width, height, sensed), optics), lens)
    distort = _warp(_pixels(rays, optics), width, height, rendered)
    seen = distorted(_slopes(pixel_grid(width, height, NO_MARGIN), optics), lens)
    rectify = _warp(_pixels(seen, optics), width, height, sensed)
    outside = ~distort.inside
    lost = ~rectify.inside | (rectify.applied(outside.astype(np.float32)) > _MOSTLY)
    return Warps(distort, rectify, outside, lost)


@lru_cache(maxsize=4)
def _falloff(coefficients: Coefficients, optics: Lens, width: int, height: int, sensed: Sides) -> np.ndarray:
    slopes = undistorted(_slopes(pixel_grid(width, height, sensed), optics), Distortion.of(coefficients))
    cosine = 1 / np.sqrt(1 + (slopes**2).sum(axis=-1, keepdims=True))
    # Corners of a margin that no ray reaches; none of the frame's pixels is resampled from them.
    return np.nan_to_num(cosine, nan=1.0).astype(np.float32)


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


def _pixels(slopes: np.ndarray, optics: Lens) -> np.ndarray:
    fx, fy, cx, cy = optics
    return slopes * np.array([fx, fy]) + np.array([cx, cy])


def _reach(points: np.ndarray, width: int, height: int) -> Sides:
    """Return how many pixels the farthest of points (..., 2) lie beyond each border; those that are NaN are nowhere."""
    (left, top), (right, bottom) = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    beyond = np.ceil(np.array([-left, -top, right - (width - 1), bottom - (height - 1)]))
    return cast(Sides, tuple(int(side) for side in np.maximum(beyond, 0)))


def _warp(points: np.ndarray, width: int, height: int, margin: Sides) -> Warp:
    """Return the map to points, (H, W, 2) in the frame's pixels, of a picture with a margin."""
    left, top, right, bottom = margin
    x, y = points[..., 0] + left, points[..., 1] + top
    # A pixel covers half a pixel around its centre; there the border pixels' own values count.
    inside = (x >= -0.5) & (x <= left + width + right - 0.5) & (y >= -0.5) & (y <= top + height + bottom - 0.5)
    x, y = (np.nan_to_num(values, nan=-1.0).astype(np.float32) for values in (x, y))
    return Warp(x, y, inside)
