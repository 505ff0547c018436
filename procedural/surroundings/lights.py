"""Random area lights around the table."""

from __future__ import annotations

import math

import numpy as np

from ...core.pose import aimed_frame
from ..description.surroundings import AreaLight
from .colour import black_body
from .metering import form_factor
from .settings import LightSettings


def draw_lights(
    rng: np.random.Generator, settings: LightSettings, reach: float, ambient: float
) -> tuple[AreaLight, ...]:
    """Draw the rectangular lights that light the table in addition to the environment.

    Every point of a light is farther from the table's centre than ``reach`` and the margin: straight lines between two
    points of that ball stay in it, so no light occludes the objects.

    Parameters
    ----------
    rng : numpy.random.Generator
        The stream ``"lights"``.
    settings : LightSettings
        Ranges of the draws.
    reach : float
        Largest distance of a camera from the table's centre [m] (`cameras.reach`).
    ambient : float
        Luminance of the environment's irradiance at the table's centre (`metering.irradiance`); a light adds a
        drawn multiple of it.

    Returns
    -------
    tuple of AreaLight
        0 to ``settings.max_count`` lights.
    """
    return tuple(_light(rng, settings, reach, ambient) for _ in range(int(rng.integers(settings.max_count + 1))))


def _light(rng: np.random.Generator, settings: LightSettings, reach: float, ambient: float) -> AreaLight:
    size = rng.uniform(*settings.size, size=2)
    elevation, azimuth = rng.uniform(*settings.elevation), rng.uniform(0.0, 2.0 * math.pi)
    distance = reach + settings.margin + 0.5 * math.hypot(*size) + rng.uniform(0.0, settings.spread)
    flat = math.cos(elevation)
    centre = distance * np.array([flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)])
    aim_angle = rng.uniform(0.0, 2.0 * math.pi)
    # The square root spreads the points evenly over the disc.
    # Half the distance keeps the centre of the table in front of the light.
    aim_radius = min(settings.aim, 0.5 * distance) * math.sqrt(rng.uniform())
    aim = aim_radius * np.array([math.cos(aim_angle), math.sin(aim_angle), 0.0])
    pose = aimed(centre, aim, rng.uniform(0.0, 2.0 * math.pi))
    colour, illuminance_ratio = black_body(rng.uniform(*settings.temperature)), rng.uniform(*settings.share)
    unlit = AreaLight(world_T_light=pose, size=tuple(size), radiance=(0.0, 0.0, 0.0))
    radiance = colour * illuminance_ratio * ambient / (math.pi * form_factor(unlit))
    return unlit.model_copy(update={"radiance": tuple(map(float, radiance))})


def aimed(centre: np.ndarray, target: np.ndarray, turn: float) -> np.ndarray:
    """Return the pose of a rectangle at a point whose +z axis points at a target.

    Parameters
    ----------
    centre, target : (3,) float
        World frame [m], at different places.
    turn : float
        Turn about the local +z axis [rad].

    Returns
    -------
    (4, 4) float64
        ``world_T_light``.
    """
    ahead = (target - centre) / np.linalg.norm(target - centre)
    # The axis farthest from `ahead` defines the frame before the turn.
    axis = np.eye(3)[int(np.argmin(np.abs(ahead)))]
    return aimed_frame(centre, ahead, np.cross(axis, ahead), turn)
