"""Whether the light of a scene can exist: lamps and suns that no measurement would find are refused by name."""

from __future__ import annotations

import math

import numpy as np

from ...core.errors import InputError
from ..description.scene import Scene
from ..description.surroundings import AreaLight, RoomEnvironment, SkyEnvironment
from ..placement.overlap import ALLOWANCE, Solid, overlap
from ..surroundings.lamps import LAMPS, lamp_flux, lamp_luminance
from ..surroundings.room_places import fits_in_room
from ..surroundings.sun import LARGEST_SUN, SMALLEST_SUN, SOLAR_ILLUMINANCE

#: Relative rounding of figures that are compared with a kind's limits.
ROUNDING = 1e-3
# Thickness that stands for a lamp's own when bodies are tested against it [m]; above twice the allowance of the test.
_THICKNESS = 4.0 * ALLOWANCE
# Least distance of an eye to a lamp [m].
_EYE_DISTANCE = 1e-3


def check_sun(scene: Scene) -> None:
    """Refuse a sun that is smaller than the real one, absurdly large, or brighter than above the atmosphere.

    A description without ``sun_illuminance`` has a soft disc in relative units, of which nothing is known.
    """
    sky = scene.environment
    if not isinstance(sky, SkyEnvironment) or sky.sun_illuminance is None:
        return
    if not SMALLEST_SUN <= sky.sun_radius <= LARGEST_SUN:
        expected = f"the sun's {SMALLEST_SUN:g} rad (0.27 degrees) to {LARGEST_SUN:.4f}"
        raise InputError("environment.sun_radius", expected, f"{sky.sun_radius:.4g} rad")
    level = sky.strength * sky.sun_illuminance
    if level > SOLAR_ILLUMINANCE * (1.0 + ROUNDING):
        expected = f"at most {SOLAR_ILLUMINANCE:g} klx, as above the atmosphere"
        raise InputError("environment.sun_illuminance", expected, f"{level:.4g} klx")


def check_lamp(scene: Scene, number: int, solids: dict[str, Solid]) -> None:
    """Refuse a lamp that its kind cannot be, that is outside its room, or in an object or an eye.

    Parameters
    ----------
    scene : Scene
        The scene.
    number : int
        The lamp's.
    solids : dict of str to Solid
        The bodies of the scene, the table's included, by name.
    """
    light, where = scene.lights[number], f"light {number}"
    if not min(light.size) > 0.0:
        raise InputError(f"{where}, size", "sides above 0 m", " x ".join(f"{side:g}" for side in light.size) + " m")
    if light.kind in LAMPS:
        _check_kind(light, where)
        # A rectangle may stand for anything; what has a kind is a thing in the room.
        if isinstance(scene.environment, RoomEnvironment) and not fits_in_room(scene.environment, light, 0.0):
            expected = "a place in the room, outside its furniture"
            raise InputError(f"{where}, world_T_light", expected, "one beyond a wall or in a block")
    box = _box(light)
    for name, solid in solids.items():
        if overlap(box, solid):
            raise InputError(f"{where}, world_T_light", "a place of its own", f"that it is in {name}")
    for view, camera in enumerate(scene.cameras):
        for pose in (camera.world_T_camera, camera.world_T_right):
            if _distance(light, pose[:3, 3]) < _EYE_DISTANCE:
                raise InputError(f"{where}, world_T_light", "a place of its own", f"an eye of camera {view} in it")


def _check_kind(light: AreaLight, where: str) -> None:
    lamp, luminance, flux = LAMPS[light.kind], lamp_luminance(light), lamp_flux(light)
    what = f"a {light.kind}"
    if luminance > lamp.most_luminance * (1.0 + ROUNDING):
        expected = f"at most the luminance of {what}, {lamp.most_luminance:.4g} cd/m^2"
        raise InputError(f"{where}, radiance", expected, f"{luminance:.4g} cd/m^2")
    if flux > lamp.flux[1] * (1.0 + ROUNDING):
        expected = f"at most the luminous flux of {what}, {lamp.flux[1]:g} lm"
        raise InputError(f"{where}, radiance", expected, f"{flux:.4g} lm")


def _box(light: AreaLight) -> Solid:
    """Return the lamp as a thin closed box in the world."""
    signs = np.array([[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)])
    local = signs * np.array([*light.size, _THICKNESS])
    pose = light.world_T_light
    quads = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    return Solid(local @ pose[:3, :3].T + pose[:3, 3], np.array(faces))


def _distance(light: AreaLight, point: np.ndarray) -> float:
    """Return the distance of a point to a rectangle [m]."""
    local = (point - light.world_T_light[:3, 3]) @ light.world_T_light[:3, :3]
    beyond = np.maximum(np.abs(local[:2]) - 0.5 * np.array(light.size), 0.0)
    return math.hypot(*beyond, local[2])
