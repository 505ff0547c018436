"""Emitters: environment map and area lights, from the description to Mitsuba."""

from __future__ import annotations

from typing import Protocol, TypeAlias

import numpy as np

from ...procedural.description.scene import Scene
from ...procedural.description.surroundings import AreaLight, Environment
from ...procedural.surroundings.environments import bake_environment
from ...procedural.surroundings.sun_glints import wide_sun
from .._mitsuba import dr, mi
from .spectrum import in_channel

#: Rotation from Mitsuba's equirectangular axes (y up) to ours (z up, azimuth from +x towards +y). Mitsuba's azimuth
#: runs in the opposite direction: the columns of the picture are reversed as well.
_WORLD_T_ENVMAP = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])

#: Bounding sphere for sampling the environment map [m], or the next power of two that contains the scene. Shadow rays
#: only have to end outside the scene; the scene's own radius would be compiled into the kernel as a literal.
_SKY_RADIUS = 64.0


def envmap(environment: Environment, channel: int | None = None) -> dict:
    """Return the Mitsuba dictionary of the environment map, with a `channel` of one colour (`spectrum.in_channel`)."""
    light = in_channel(bake_environment(environment), channel) * np.float32(environment.strength)
    pixels = _rows_for_mitsuba(light)
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


#: Half-width of the footprint of a path in its pixel [px]: about half the distance between the 50 to 100 paths of a
#: pixel of glass. The light is that of a sun averaged over the ellipse, so a wide one moves light: a tumbler of seed
#: 207 full of glints has 5.9 % too little with 0.15 and 15 degrees at most, 2.6 % with 0.08, and 2.4 % with 0.08 and 8
#: degrees (against paths without a footprint or the reference, by hand, standard errors of 1.0 to 1.3 %).
_FOOTPRINT = 0.06

#: Derivatives of a direction by two perpendicular offsets of the path's place in the pixel [1/px].
Spread: TypeAlias = "tuple[mi.Vector3f, mi.Vector3f]"


class SunGlints(Protocol):
    """The sun as paths find it through glass."""

    def __call__(self, radiance: mi.Color3f, direction: mi.Vector3f, spread: Spread | None = None, /) -> mi.Color3f:
        """Return the environment's radiance with a wider disc in place of the sun.

        Parameters
        ----------
        radiance : mi.Color3f
            The environment's radiance.
        direction : mi.Vector3f
            Direction to it.
        spread : Spread, optional
            Of the direction: the disc is stretched by as much.
        """
        ...


def sun_glints(scene: Scene) -> SunGlints | None:
    """Return the sun that paths find through glass (`sun_glints.wide_sun`); None where it is the environment's own."""
    sun = wide_sun(scene.environment, min(1.0 / camera.focal for camera in scene.cameras))
    if sun is None:
        return None
    to_sun, around, light = (mi.Vector3f(*values.tolist()) for values in (sun.direction, sun.around, sun.light))
    core_cos, disc_cos, widest2 = mi.Float(sun.core_cos), mi.Float(sun.disc_cos), mi.Float(sun.widest**2)
    dr.make_opaque(to_sun, around, light, core_cos, disc_cos, widest2)

    def with_wide_sun(radiance: mi.Color3f, direction: mi.Vector3f, spread: Spread | None = None) -> mi.Color3f:
        cos = dr.dot(direction, to_sun)
        sky = dr.select(cos > core_cos, dr.minimum(radiance, mi.Color3f(around)), radiance)
        if spread is None:
            return sky + dr.select(cos > disc_cos, mi.Color3f(light) / (dr.two_pi * (1.0 - disc_cos)), 0.0)
        inside, area = _in_ellipse(direction, to_sun, 1.0 - dr.square(disc_cos), spread, widest2)
        # The ellipse is flat; solid angles are larger by 1 / cos.
        return sky + dr.select(inside & (cos > 0.0), mi.Color3f(light) * (cos / area), 0.0)

    return with_wide_sun


def _in_ellipse(
    direction: mi.Vector3f,
    to_sun: mi.Vector3f,
    radius2: mi.Float,
    spread: Spread,
    widest2: mi.Float,
) -> tuple[mi.Bool, mi.Float]:
    """Return whether the sun is in the ellipse of a disc and a spread around a direction, and its area there [sr].

    In the plane across the direction the ellipse is x^T Q^-1 x < 1, with Q = r^2 I + a a^T + b b^T of the disc's radius
    r and the half-widths a and b of the spread. (For widths that are independent, such matrices add.)
    """
    frame, (a, b) = mi.Frame3f(direction), spread
    size2 = _FOOTPRINT**2 * (dr.squared_norm(a) + dr.squared_norm(b))
    scale = _FOOTPRINT**2 * dr.minimum(widest2 / dr.maximum(size2, 1e-20), 1.0)
    (ax, ay), (bx, by), (x, y) = ((dr.dot(v, frame.s), dr.dot(v, frame.t)) for v in (a, b, to_sun))
    xx, yy = radius2 + scale * (ax * ax + bx * bx), radius2 + scale * (ay * ay + by * by)
    xy = scale * (ax * ay + bx * by)
    det = xx * yy - xy * xy
    return yy * x * x - 2.0 * xy * x * y + xx * y * y < det, dr.pi * dr.sqrt(det)


def area_light(light: AreaLight, channel: int | None = None) -> dict:
    """Return the Mitsuba dictionary of a rectangle that emits along its local +z and is black from behind."""
    radiance = in_channel(np.array(light.radiance), channel).tolist()
    half = np.diag([light.size[0] / 2, light.size[1] / 2, 1.0, 1.0])  # Mitsuba's rectangle spans [-1, 1]^2
    return {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f(light.world_T_light @ half),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}},
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
    }


def make_literals_opaque(scene: mi.Scene) -> None:
    """Make values opaque that Mitsuba compiles into kernels as literals: poses of area lights and the scene's radius.

    All scenes then share their compiled kernels.
    """
    parameters = mi.traverse(scene)
    for shape in scene.shapes():
        if shape.is_emitter() and not shape.is_mesh():
            pose = parameters[f"{shape.id()}.to_world"]
            dr.make_opaque(pose)
            parameters[f"{shape.id()}.to_world"] = pose
    parameters.update()
    corners = np.abs(np.array([scene.bbox().min, scene.bbox().max])).max(axis=0)
    radius = max(_SKY_RADIUS, 2.0 ** np.ceil(np.log2(np.linalg.norm(corners))))
    ball = mi.load_dict({"type": "scene", "ball": {"type": "sphere", "radius": float(radius)}})
    scene.environment().set_scene(ball)
