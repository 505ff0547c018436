"""How bright the surroundings of an environment map from a file are: its own unit is unknown.

A map is taken for outdoors or indoors by what it shows, and gets an illuminance on the table that such places have.
"""

from __future__ import annotations

import math

import numpy as np

from ..description.surroundings import Environment, PictureEnvironment, SkyEnvironment
from .colour import luminance
from .metering import irradiance
from .sphere import cosine_weights, solid_angles

# An open sky is wide and even: its half of the map has at least 3 times the light of the lower half, and at least 0.4
# of it is brighter than a quarter of its mean. Of twelve maps (Poly Haven) the five with an open sky have 3.9 to 10
# times and 0.46 to 1; a place under a bridge and the indoor ones either less than 3 times or at most 0.3, because
# their light comes from windows and lamps.
_SKY_OVER_GROUND, _BRIGHT, _BRIGHT_FRACTION = 3.0, 0.25, 0.4
# A ceiling with wide windows can be as bright and even, but not as blue. Within 30 degrees of the zenith the blue of
# eight open skies is 1.15 to 5.1 times the red in linear Rec.709 (at least about 1 by daylight of 6500 K, the CIE's
# overcast sky), that of interiors in warm light 0.35 to 0.8 (`interior.exr` 0.73). Where a low sun makes most of the
# sky dark beside it, a blue of twice the red decides (`sunrise.exr` 3.9; studios and halls up to 1.5).
_ZENITH, _LEAST_BLUE, _CLEAR_BLUE = 1 / 6, 0.9, 2.0
# The sun: so much of the table's light [1] comes from the brightest so many steradians (the sun's disc has 7e-5, and
# maps are coarse).
_SUN_FRACTION, _SUN_SOLID_ANGLE = 0.3, 1e-3
# Illuminance on the table [klx]: indoors what EN 12464-1 asks of rooms from corridors to workplaces; outdoors without a
# sun from heavy overcast to bright shade, with it a clear day, the sun 25 to 65 degrees high (`sun.clear_daylight`).
_INDOORS, _OVERCAST, _SUNNY = (0.2, 1.0), (5.0, 25.0), (45.0, 110.0)


def is_outdoors(environment: Environment, pixels: np.ndarray) -> bool:
    """Return whether an environment, baked to a map, has an open sky."""
    if isinstance(environment, PictureEnvironment):
        return shows_open_sky(pixels)
    return isinstance(environment, SkyEnvironment)


def shows_open_sky(pixels: np.ndarray) -> bool:
    """Return whether the upper half of a map, (h, 2 * h, 3), is a wide bright sky."""
    levels, weights = luminance(pixels), solid_angles(len(pixels))
    by_row, middle = weights * levels.sum(axis=1, dtype=np.float64), len(pixels) // 2
    upper = levels[:middle]
    mean = by_row[:middle].sum() / (weights[:middle].sum() * levels.shape[1])
    bright = (upper > _BRIGHT * mean).mean(axis=1) @ weights[:middle] / weights[:middle].sum()
    rows = round(_ZENITH * len(pixels))
    red, _, blue = weights[:rows] @ pixels[:rows].sum(axis=1, dtype=np.float64)
    is_sky = blue >= _LEAST_BLUE * red and (bright >= _BRIGHT_FRACTION or blue >= _CLEAR_BLUE * red)
    return bool(is_sky and by_row[:middle].sum() >= _SKY_OVER_GROUND * by_row[middle:].sum())


def shows_sun(pixels: np.ndarray) -> bool:
    """Return whether much of the light on the table comes from a small part of a map, (h, 2 * h, 3)."""
    levels, height = luminance(pixels), len(pixels)
    light = levels * cosine_weights(height)[:, None]
    order = np.argsort(levels, axis=None)[::-1]
    area = np.cumsum(np.broadcast_to(solid_angles(height)[:, None], levels.shape).ravel()[order])
    brightest = order[: int(np.searchsorted(area, _SUN_SOLID_ANGLE)) + 1]
    return bool(light.ravel()[brightest].sum() >= _SUN_FRACTION * light.sum())


def draw_strength(rng: np.random.Generator, pixels: np.ndarray) -> float:
    """Draw the factor from a map's own unit, (h, 2 * h, 3), to kcd/m^2, by the illuminance of such a place."""
    limits = _INDOORS
    if shows_open_sky(pixels):
        limits = _SUNNY if shows_sun(pixels) else _OVERCAST
    level = math.exp(rng.uniform(math.log(limits[0]), math.log(limits[1])))
    return level / float(luminance(irradiance(pixels, 1.0, ())))
