"""Emitters: environment map and area lights, from the description to Mitsuba."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from ...procedural.description.scene import Scene
from ...procedural.description.surroundings import AreaLight, Environment
from ...procedural.surroundings.environments import bake_environment
from ...procedural.surroundings.sun_glints import wide_sun
from .._mitsuba import dr, mi

#: Rotation from Mitsuba's equirectangular axes (y up) to ours (z up, azimuth from +x towards +y). Mitsuba's azimuth
#: runs in the opposite direction: the columns of the picture are reversed as well.
_WORLD_T_ENVMAP = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])

#: Bounding sphere for sampling the environment map [m], or the next power of two that contains the scene. Shadow rays
#: only have to end outside the scene; the scene's own radius would be compiled into the kernel as a literal.
_SKY_RADIUS = 64.0


def envmap(environment: Environment) -> dict:
    """Return the Mitsuba dictionary of the environment map."""
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
    """Resample rows from polar angles (r + 1/2)/H pi to Mitsuba's r/(H' - 1) pi.

    With H' = 2H + 1 every old centre is a new row and every other new row lies half-way between two old ones, so
    bilinear interpolation gives the same values. (Mitsuba 3.9.1, measured: columns are centred at (c + 1/2)/W, rows are
    not.)
    """
    middle = np.concatenate([pixels[:1], (pixels[:-1] + pixels[1:]) * np.float32(0.5), pixels[-1:]])
    rows = np.empty((2 * len(pixels) + 1, *pixels.shape[1:]), np.float32)
    rows[0::2], rows[1::2] = middle, pixels
    return rows


#: (radiance of the environment, direction to it) -> its radiance with the wide disc in place of the sun.
SunGlints: TypeAlias = "Callable[[mi.Color3f, mi.Vector3f], mi.Color3f]"


def sun_glints(scene: Scene) -> SunGlints | None:
    """Return the sun that paths find through glass (`sun_glints.wide_sun`); None where it is the environment's own."""
    sun = wide_sun(scene.environment, min(1.0 / camera.focal for camera in scene.cameras))
    if sun is None:
        return None
    to_sun, around, disc = (mi.Vector3f(*values.tolist()) for values in (sun.direction, sun.around, sun.disc))
    core_cos, disc_cos = mi.Float(sun.core_cos), mi.Float(sun.disc_cos)
    dr.make_opaque(to_sun, around, disc, core_cos, disc_cos)

    def with_wide_sun(radiance: mi.Color3f, direction: mi.Vector3f) -> mi.Color3f:
        cos = dr.dot(direction, to_sun)
        sky = dr.select(cos > core_cos, dr.minimum(radiance, mi.Color3f(around)), radiance)
        return sky + dr.select(cos > disc_cos, mi.Color3f(disc), 0.0)

    return with_wide_sun


def area_light(light: AreaLight) -> dict:
    """Return the Mitsuba dictionary of a rectangle that emits along its local +z and is black from behind."""
    half = np.diag([light.size[0] / 2, light.size[1] / 2, 1.0, 1.0])  # Mitsuba's rectangle spans [-1, 1]^2
    return {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f(light.world_T_light @ half),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": list(light.radiance)}},
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
    }


def make_literals_opaque(scene: mi.Scene) -> None:
    """Make values opaque that Mitsuba compiles into kernels as literals: poses of area lights and the scene's radius.

    All scenes then share their compiled kernels.
    """
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
