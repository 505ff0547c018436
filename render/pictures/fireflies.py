"""The firefly filter: the excess of pixels that a single path made bright is spread over pixels with noise like it.

Light that reaches a pixel by rare paths (a lamp seen through two glasses) arrives in few bright samples. The mean over
all pixels is right, and clamping such samples would darken the picture (bias). So the excess is not clamped but spread
over the pixels around it that the same rare paths reach: those that show the same kind of surface and have noise. The
mean stays, and the denoiser can handle the result. Pixels that are bright in every group of samples are not changed.
In glass the same is done within an object, and within its outline. But a firefly whose light would bleach the pixels
around it more than it spoils its own stays in its place as a glint, and is kept from the denoiser.
"""

from __future__ import annotations

import cv2
import numpy as np

from ...core.images import srgb_curve
from .guides import Guides, inner_parts

#: Smallest relative standard error of a firefly [1]. It is 1 where one group of samples carries all light, for any
#: number of groups, and 0.6 where 63 to 70 % of the light is in one group (of sixteen, of four).
MIN_RELATIVE_ERROR = 0.6
#: Smallest ratio of a firefly to the median of its neighbourhood [1].
MIN_CONTRAST = 3.0
#: Side of the square that the median is taken over [px].
MEDIAN_SIDE = 5
#: Radius that the excess is spread over, as a fraction of the picture's width [1]: so wide that the denoiser does not
#: take it for a detail. Measured on `bench/quality.py --scenes hdri --spp 16`, 240 px wide, with a square of that
#: half-width: relMSE after denoising 0.036 with one of 2 px, 0.013 with one of 16; without the filter 0.013 as well,
#: but the denoiser lost 1.6 % of the light.
SPREAD = 1 / 16
#: Differences of the guides at which a pixel's weight falls to exp(-1/2) [1]: of normals, and of albedo.
_NORMAL_WIDTH, _ALBEDO_WIDTH = 0.25, 0.15
#: Relative standard error at which a pixel has half of its weight [1]. Pixels without noise get no light.
_NOISE_SCALE = 0.02
#: Fireflies that are spread at once [1]: a bound on memory.
_CHUNK = 256


def spread_fireflies(
    radiance: np.ndarray, variance: np.ndarray, guides: Guides, exposure: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the picture with the excess of fireflies spread, its variance, and glints that are part of neither.

    The sum of the picture and its glints is that of the noisy picture.

    Parameters
    ----------
    radiance : (H, W, 3) float32
        Noisy picture.
    variance : (H, W, 3) float32
        Estimated variance of each value.
    guides : Guides
        What pixels show.
    exposure : float
        Factor from radiance to displayed light, of which 1 is white.

    Returns
    -------
    picture, variance, glints : (H, W, 3) float32
        Glints are the excess of fireflies that would bleach what is around them (`_bleaches`).
    """
    is_firefly, kept, error = _fireflies(radiance, variance)
    if not is_firefly.any():
        return radiance, variance, np.zeros_like(radiance)
    level = radiance.mean(axis=2)
    noisy = error / (error + _NOISE_SCALE * np.maximum(level, 1e-12))
    rest = radiance * kept
    excess = (radiance - rest).astype(np.float64)
    spread, glints = _spread(excess, np.argwhere(is_firefly), noisy, guides, exposure * rest.mean(axis=2), exposure)
    return (rest + spread).astype(np.float32), (variance * kept**2).astype(np.float32), glints.astype(np.float32)


def _fireflies(radiance: np.ndarray, variance: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return which pixels are fireflies (H, W), what part of each pixel is no excess (H, W, 1), and errors (H, W)."""
    level = radiance.mean(axis=2)
    around = cv2.medianBlur(np.ascontiguousarray(level, np.float32), MEDIAN_SIDE)
    # The variance of the mean colour is at most that of fully correlated channels, as those of a firefly are.
    error = np.sqrt(variance).mean(axis=2)
    is_firefly = (error >= MIN_RELATIVE_ERROR * level) & (level > MIN_CONTRAST * around)
    kept = np.divide(around, level, out=np.ones_like(level), where=is_firefly)
    return is_firefly, kept[..., None], error


def _spread(
    excess: np.ndarray,
    fireflies: np.ndarray,
    noisy: np.ndarray,
    guides: Guides,
    displayed: np.ndarray,
    exposure: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the light of the fireflies, (n, 2) rows and columns, given to the pixels around them, and the glints."""
    height, width = noisy.shape
    radius = max(2, round(SPREAD * width))
    offset = np.arange(-radius, radius + 1)
    # A biweight kernel: it has no border.
    distance2 = (offset[:, None] ** 2 + offset[None, :] ** 2) / (radius + 1.0) ** 2
    kernel = np.maximum(1.0 - distance2, 0.0) ** 2
    result, glints = np.zeros((height * width, 3)), np.zeros_like(excess)
    for first in range(0, len(fireflies), _CHUNK):
        centre = fireflies[first : first + _CHUNK]
        row, column = centre[:, 0, None, None] + offset[:, None], centre[:, 1, None, None] + offset[None, :]
        inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
        at = np.clip(row, 0, height - 1) * width + np.clip(column, 0, width - 1)
        here = centre[:, 0] * width + centre[:, 1]
        weight = kernel * inside * noisy.ravel()[at] * _likeness(guides, here, at)
        # (A firefly has noise itself, so the sum is above 0.)
        weight /= weight.sum(axis=(1, 2), keepdims=True)
        light = excess[centre[:, 0], centre[:, 1]]
        stays = _bleaches(displayed.ravel(), exposure * light.mean(axis=1), weight, here, at)
        glints[centre[stays, 0], centre[stays, 1]] = light[stays]
        given = weight[~stays, ..., None] * light[~stays, None, None, :]
        for channel in range(3):
            result[:, channel] += np.bincount(at[~stays].ravel(), given[..., channel].ravel(), height * width)
    return result.reshape(height, width, 3), glints


def _bleaches(
    displayed: np.ndarray, light: np.ndarray, weight: np.ndarray, here: np.ndarray, at: np.ndarray
) -> np.ndarray:
    """Return which fireflies change the displayed picture more where they are spread than where they are, bool.

    By squared errors of sRGB values, as if all of the light were wrong: in its own pixel it is cut off at white, spread
    it is not.
    """
    alone = _shown(displayed[here] + light) - _shown(displayed[here])
    around = _shown(displayed[at] + weight * light[:, None, None]) - _shown(displayed[at])
    return np.square(around).sum(axis=(1, 2)) > np.square(alone)


def _shown(displayed: np.ndarray) -> np.ndarray:
    return srgb_curve(np.clip(displayed, 0.0, 1.0))


def _likeness(guides: Guides, centre: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return by how much pixels show the same kind of surface as a firefly, (n, side, side) in [0, 1].

    Glass is like the glass of the same object, its outline like its outline: what it shows changes from pixel to pixel.
    Other surfaces have normals and albedos alike.
    """
    glass, part = guides.glass.ravel(), inner_parts(guides.instance).ravel()
    normal, albedo = (x.reshape(-1, 3).astype(np.float64) for x in (guides.normal, guides.albedo))
    from_glass, to_glass = glass[centre][:, None, None], glass[at]
    same = from_glass & to_glass & (part[at] == part[centre][:, None, None])
    apart = ((normal[at] - normal[centre][:, None, None]) ** 2).sum(-1) / _NORMAL_WIDTH**2
    apart += ((albedo[at] - albedo[centre][:, None, None]) ** 2).sum(-1) / _ALBEDO_WIDTH**2
    return np.where(from_glass, same, np.exp(-0.5 * apart) * ~to_glass)
