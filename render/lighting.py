"""Environment and area lights: description -> Mitsuba emitters."""

from __future__ import annotations

import mitsuba as mi
import numpy as np

from ..procedural.surroundings.description import AreaLight, Environment
from ..procedural.surroundings.environments import bake_environment

#: Our equirectangular axes (z up, azimuth from +x towards +y) seen from Mitsuba's (y up), whose azimuth runs the other
#: way: used with the picture's columns reversed.
_WORLD_T_ENVMAP = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def envmap(environment: Environment) -> dict:
    """Return the dictionary of the environment's emitter."""
    pixels = _rows_for_mitsuba(bake_environment(environment) * np.float32(environment.strength))
    cos, sin = np.cos(environment.rotation), np.sin(environment.rotation)
    world_T_env = np.eye(4)
    world_T_env[:3, :3] = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ _WORLD_T_ENVMAP
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(pixels[:, ::-1], dtype=np.float32)),
        "to_world": mi.ScalarTransform4f(world_T_env),
    }


def _rows_for_mitsuba(pixels: np.ndarray) -> np.ndarray:
    """Resample rows from centres at (r + 1/2)/H to Mitsuba's at r/(H' - 1), both shares of pi.

    With H' = 2H + 1 every old centre is a new row and every other new row lies half-way between two old ones, so the
    bilinear picture stays the same. (Mitsuba 3.9.1, measured: columns are centred at (c + 1/2)/W, rows are not.)
    """
    middle = np.concatenate([pixels[:1], (pixels[:-1] + pixels[1:]) * np.float32(0.5), pixels[-1:]])
    rows = np.empty((2 * len(pixels) + 1, *pixels.shape[1:]), np.float32)
    rows[0::2], rows[1::2] = middle, pixels
    return rows


def area_light(light: AreaLight) -> dict:
    """Return the dictionary of a rectangle that shines along its local +z, black from behind."""
    half = np.diag([light.size[0] / 2, light.size[1] / 2, 1.0, 1.0])  # Mitsuba's rectangle spans [-1, 1]^2
    return {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f(light.world_T_light @ half),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": list(light.radiance)}},
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
    }
