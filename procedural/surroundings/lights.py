"""Random lamps around the table, in photometric units."""

from __future__ import annotations

import math

import numpy as np

from ...core.pose import aimed_frame
from ..description.surroundings import AreaLight, Environment, RoomEnvironment
from .colour import black_body, luminance
from .file_light import is_outdoors
from .lamps import LAMPS
from .room_places import fits_in_room
from .settings import LightSettings

# Places that are tried for a lamp before the room is taken for full.
_TRIES = 64


def draw_lights(
    rng: np.random.Generator, settings: LightSettings, reach: float, environment: Environment, pixels: np.ndarray
) -> tuple[AreaLight, ...]:
    """Draw the lamps that light the table in addition to the environment.

    Every point of a lamp is farther from the table's centre than ``reach`` and the margin: straight lines between two
    points of that ball stay in it, so no lamp occludes the objects. In a room lamps hang inside it, clear of walls,
    furniture and each other. Under an open sky there are none.

    Parameters
    ----------
    rng : numpy.random.Generator
        The stream ``"lights"``.
    settings : LightSettings
        Ranges of the draws.
    reach : float
        Largest distance of a camera from the table's centre [m] (`cameras.reach`).
    environment : Environment
        The surroundings.
    pixels : (h, 2 * h, 3) float
        Its map.

    Returns
    -------
    tuple of AreaLight
        0 to ``settings.max_count`` lamps; radiance in kcd/m^2.
    """
    count = int(rng.integers(settings.max_count + 1))
    if is_outdoors(environment, pixels):
        return ()
    lights: list[AreaLight] = []
    for _ in range(count):
        tries = (_light(rng, settings, reach) for _ in range(_TRIES))
        found = next((light for light in tries if _has_place(light, environment, lights)), None)
        if found is not None:
            lights.append(found)
    return tuple(lights)


def _has_place(light: AreaLight, environment: Environment, others: list[AreaLight]) -> bool:
    if isinstance(environment, RoomEnvironment) and not fits_in_room(environment, light):
        return False
    apart = [0.5 * (math.hypot(*light.size) + math.hypot(*other.size)) for other in others]
    away = [np.linalg.norm(light.world_T_light[:3, 3] - other.world_T_light[:3, 3]) for other in others]
    return all(distance > least for distance, least in zip(away, apart, strict=True))


def _light(rng: np.random.Generator, settings: LightSettings, reach: float) -> AreaLight:
    kind = settings.kinds[int(rng.integers(len(settings.kinds)))]
    lamp = LAMPS[kind]
    length = float(rng.uniform(*lamp.length))
    size = (length, length if lamp.width is None else float(rng.uniform(*lamp.width)))
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
    colour, flux = black_body(rng.uniform(*lamp.temperature)), rng.uniform(*lamp.flux)
    level = 1e-3 * flux / (math.pi * size[0] * size[1])
    red, green, blue = (level * colour / luminance(colour)).tolist()
    return AreaLight(kind=kind, world_T_light=pose, size=size, radiance=(red, green, blue))


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
