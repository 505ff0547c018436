"""The sun as glass mirrors it: a wider disc of the same light, for paths that come from the camera through glass.

A wine glass mirrors the sun as a glint of a tenth of a millimetre, a hundredth of a pixel. One path in a hundred finds
it, a thousand times too bright, and nothing tells such a firefly from noise. A wider sun makes the glint as large as a
pixel: the pixel gets the same light, with little noise (path space regularization: Kaplanyan and Dachsbacher,
"Path Space Regularization for Holistic and Robust Light Transport", Computer Graphics Forum 32(2), 2013). What the sun
lights, and the sun itself where it is in view, keep its real size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..description.surroundings import Environment
from .colour import luminance
from .environments import bake_environment
from .file_light import is_outdoors, shows_sun
from .sphere import solid_angles, texel_directions

#: Angular radius of the wide disc over the angle of a pixel [1]: a wall curved to a radius of 3 cm, 0.6 m away, mirrors
#: it as a spot of one pixel in diameter. And its largest value [rad], 4 degrees.
_RADIUS_OVER_PIXEL, _MAX_RADIUS = 20.0, math.radians(4.0)
#: Largest spread of a pixel's paths by which the disc is widened further [rad], 8 degrees: the light of a sun that wide
#: still comes from about there. With 15 degrees a beaker of seed 207 has 2.0 % more light than with none, with 8 0.7 %
#: (standard error 1.0 %). A low sun is not spread below the horizon.
_WIDEST = math.radians(8.0)
# The sun of a map: what is brighter, within this angle of its brightest texel, than the mean of the ring around it, as
# wide again [rad]. Suns of maps from files are blurred over a degree or two.
_CORE = math.radians(2.5)


@dataclass(frozen=True, eq=False)
class WideSun:
    """The sun of an environment, and the disc that stands for it; world frame, radiance with the map's strength."""

    direction: np.ndarray  #: (3,) unit vector to its centre
    core_cos: float  #: cosine of the angle within which the map shows the sun
    around: np.ndarray  #: (3,) linear Rec.709 radiance of the sky around it: the map within the core, without the sun
    disc_cos: float  #: cosine of the wide disc's radius
    widest: float  #: largest spread of a pixel's paths that widens it further [rad]
    light: np.ndarray  #: (3,) linear Rec.709 radiance times solid angle [sr] of the disc


def wide_sun(environment: Environment, pixel_angle: float) -> WideSun | None:
    """Return the wide disc of an environment's sun; None where it has no sun, or one that is as wide.

    Parameters
    ----------
    environment : Environment
        The surroundings.
    pixel_angle : float
        Angle of a pixel [rad].
    """
    pixels = bake_environment(environment)
    if not (is_outdoors(environment, pixels) and shows_sun(pixels)):
        return None
    directions, weights = texel_directions(len(pixels)), solid_angles(len(pixels))
    centre = directions.reshape(-1, 3)[int(np.argmax(luminance(pixels)))].astype(np.float64)
    cosine = directions @ centre
    core, ring = cosine > math.cos(_CORE), (cosine > math.cos(2.0 * _CORE)) & (cosine <= math.cos(_CORE))
    around = pixels[ring].mean(axis=0, dtype=np.float64)
    area = np.broadcast_to(weights[:, None], core.shape)[core]
    light = (np.maximum(pixels[core] - around, 0.0) * area[:, None]).sum(axis=0, dtype=np.float64)
    widest = min(_WIDEST, math.asin(max(centre[2], 0.0)))
    disc_cos = math.cos(min(_RADIUS_OVER_PIXEL * pixel_angle, _MAX_RADIUS))
    if area[luminance(pixels[core]) > 0.5 * luminance(pixels[core]).max()].sum() > 2.0 * math.pi * (1.0 - disc_cos):
        return None
    cos, sin = math.cos(environment.rotation), math.sin(environment.rotation)
    world_R_map = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    strength = environment.strength
    return WideSun(world_R_map @ centre, math.cos(_CORE), around * strength, disc_cos, widest, light * strength)
