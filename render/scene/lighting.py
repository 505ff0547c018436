"""Environment and area lights: description -> Mitsuba emitters."""

from __future__ import annotations

import numpy as np

from ...procedural.description.surroundings import AreaLight, Environment
from ...procedural.surroundings.environments import bake_environment
from .._mitsuba import dr, mi

#: Our equirectangular axes (z up, azimuth from +x towards +y) seen from Mitsuba's (y up), whose azimuth runs the other
#: way: used with the picture's columns reversed.
_WORLD_T_ENVMAP = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])

#: The sky is sampled as if the scene lay in a ball of this radius, or of the next power of two that holds it [m]. It
#: only has to be so far that shadow rays pass everything; a scene's own radius would stand in the kernel as a literal.
_SKY_RADIUS = 64.0


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


def keep_numbers_out_of_kernels(scene: mi.Scene) -> None:
    """Make what Mitsuba writes into kernels as literals opaque: poses of lamps, and the scene's radius for the sky."""
    parameters = mi.traverse(scene)
    for shape in scene.shapes():
        if shape.is_emitter():
            pose = parameters[f"{shape.id()}.to_world"]
            dr.make_opaque(pose)
            parameters[f"{shape.id()}.to_world"] = pose
    parameters.update()
    corners = np.abs(np.array([scene.bbox().min, scene.bbox().max])).max(axis=0)
    radius = max(_SKY_RADIUS, 2.0 ** np.ceil(np.log2(np.linalg.norm(corners))))
    ball = mi.load_dict({"type": "scene", "ball": {"type": "sphere", "radius": float(radius)}})
    scene.environment().set_scene(ball)
