"""Exposure and colour of pictures as a photographer sets them: highlights of the table kept, the light balanced."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.images import KNEE, Tone, balance_of
from ..description.camera import Camera
from ..description.material import VertexColours
from ..description.surroundings import AreaLight, Environment, RoomEnvironment, Table
from ..patterns.bake import bake_material
from .camera_settings import CameraSettings
from .colour import luminance
from .metering import exposure, form_factor, irradiance, polygon_form_factor
from .room_bodies import world_T_room
from .room_geometry import ALONG, WALL_FACES
from .table import outline

#: Linear value that is white with a soft shoulder [1]: three stops over a white sheet in the meter's light, as colour
#: negative film and cameras with a highlight mode keep. A window over it, in a room, is 10 to 30 times as bright.
SOFT_WHITE = 12.0
# Share of the table's top that may be brighter than the level that highlights are metered for [1].
_BRIGHTEST = 0.02
# Texels that stand for a top with prints on it [1].
_SAMPLES = 20_000
# Places along each side of the table at which its light is worked out.
_PLACES = 7
# Mean level of a window or a lamp over its radiance [1]: land below the horizon, and a lamp's rim.
_MEAN_LEVEL = 0.7


def camera_exposure(
    table: Table, environment: Environment, pixels: np.ndarray, lights: Sequence[AreaLight]
) -> tuple[float, np.ndarray]:
    """Return the exposure of a scene, and the light that falls on the middle of its table.

    An incident-light meter sets the exposure (`metering.exposure`). Where the brightest part of the table's top in its
    strongest light would then be above the knee of the tone curve, the exposure is lower, so that it is there.

    Parameters
    ----------
    table : Table
        Its top's reflectance counts.
    environment : Environment
        The surroundings.
    pixels : (h, 2 * h, 3) float
        Their map.
    lights : sequence of AreaLight
        The lamps.

    Returns
    -------
    exposure : float
        Factor from radiance to the linear value that sRGB encodes.
    light : (3,) float64
        Irradiance, linear Rec.709.
    """
    light = irradiance(pixels, environment.strength, lights)
    metered = exposure(light)
    strongest = luminance(light) + max(_gain(environment, lights, place) for place in _places(table))
    brightest = _reflectance(table) * metered * strongest / np.pi
    return metered * min(1.0, KNEE / max(float(brightest), 1e-9)), light


def toned_cameras(settings: CameraSettings, cameras: tuple[Camera, ...], light: np.ndarray) -> tuple[Camera, ...]:
    """Return cameras whose 8-bit pictures have the white balance and the highlights of the settings."""
    white = SOFT_WHITE if settings.highlights == "soft" else 1.0
    balance: Tone = {
        "off": Tone(),
        "grey-world": Tone(balance="grey-world"),
        "light": Tone(balance=balance_of(light)),
    }[settings.white_balance]
    changes = {"balance": balance.balance, "white": white}
    return tuple(camera.model_copy(update=changes) for camera in cameras)


def _reflectance(table: Table) -> float:
    """Return the luminance of the reflectance that all but the brightest part of the table's top has."""
    if isinstance(table.material.base_colour, VertexColours):
        return 1.0
    seen = luminance(bake_material(table.material)[0])
    if table.prints:
        seen = _with_prints(seen.reshape(-1), table)
    return float(np.quantile(seen, 1.0 - _BRIGHTEST))


def _with_prints(own: np.ndarray, table: Table) -> np.ndarray:
    """Return luminances of a top and its prints, (n,), as many of each as it has of the area."""
    area = table.size[0] * table.size[1]
    parts = [(own, max(0.0, 1.0 - sum(item.size[0] * item.size[1] for item in table.prints) / area))]
    for item in table.prints:
        seen = luminance(bake_material(item.material)[0]).reshape(-1)
        parts.append((seen, item.size[0] * item.size[1] / area))
    places = [np.linspace(0, len(seen) - 1, round(_SAMPLES * fraction)).astype(int) for seen, fraction in parts]
    return np.concatenate([seen[place] for (seen, _), place in zip(parts, places, strict=True)])


def _places(table: Table) -> np.ndarray:
    """Return places on the table's top, (n, 3) [m]."""
    low, high = outline(table).min(axis=0), outline(table).max(axis=0)
    x, y = (np.linspace(0.9 * low[k], 0.9 * high[k], _PLACES) for k in range(2))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return np.column_stack([grid, np.zeros(len(grid))])


def _gain(environment: Environment, lights: Sequence[AreaLight], place: np.ndarray) -> float:
    """Return how much more light lamps and windows throw on a place than on the table's middle, in luminance."""
    found = 0.0
    for light in lights:
        pose = light.world_T_light.copy()
        pose[:3, 3] -= place
        moved = light.model_copy(update={"world_T_light": pose})
        found += np.pi * float(luminance(np.array(light.radiance))) * (form_factor(moved) - form_factor(light))
    if isinstance(environment, RoomEnvironment) and not environment.at_infinity:
        for corners, level in _openings(environment):
            more = polygon_form_factor(corners - place) - polygon_form_factor(corners)
            found += np.pi * _MEAN_LEVEL * environment.strength * level * more
    return found


def _openings(room: RoomEnvironment) -> list[tuple[np.ndarray, float]]:
    """Return the corners of windows and lamps in the world, and their luminance."""
    pose, found = world_T_room(room), []
    for window in room.windows:
        axis, side = divmod(WALL_FACES[window.wall], 2)
        corners = np.empty((4, 3))
        corners[:, axis] = 0.0 if side else room.size[axis]
        signs = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
        corners[:, ALONG[axis]] = np.array(window.centre) + signs * np.array(window.size)
        found.append((corners @ pose[:3, :3].T + pose[:3, 3], float(luminance(np.array(window.radiance)))))
    return found
