"""Where bright light comes from: a coarse map of the sky and the lamps, by direction.

Lamps fill little of what a ray through glass may meet, and most of the noise in glass is theirs: one ray in a thousand
is mirrored towards them. `mirrored_share` tosses Fresnel's coin so that more of them are, and each counts less. The map
only steers; the mean stays whatever it holds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...core.randomness import stream
from ...procedural.description.scene import Scene
from ...procedural.description.surroundings import AreaLight
from ...procedural.surroundings.colour import luminance
from ...procedural.surroundings.environments import bake_environment
from ...procedural.surroundings.metering import irradiance
from .._mitsuba import dr, mi

#: Cells along one side of the map: about 3 degrees each, a small lamp's size.
CELLS = 64
#: Directions of a cell that are averaged. They reach half a cell beyond it, so that a cell beside a lamp knows of it.
_DIRECTIONS, _BEYOND = 64, 0.5
#: Rays leave from random points of this box [m]: lamps are so far away that it does not matter much where.
_LOW, _HIGH = (-0.2, -0.2, 0.0), (0.2, 0.2, 0.15)
#: Reflectance that the table is taken to have, seen from above, and the least of a cell's light over the table's.
_GROUND, _LEAST = 0.3, 0.1
#: Weight of the map against Fresnel's own shares. A half keeps the weight of either outcome at 2 or less.
_TRUST = 0.5
#: Paths that count more than this many times are not steered on: coins that fell against the odds again and again would
#: make a firefly of the path that was unlucky.
_HEAVY = 2.0


@dataclass(frozen=True, eq=False)
class Lamp:
    """A rectangle that shines on the side that `across` x `up` points to."""

    centre: mi.Point3f
    across: mi.Vector3f  #: from the centre to the middle of an edge, over the square of that distance [1/m]
    up: mi.Vector3f
    light: mi.Float  #: luminance


@dataclass(frozen=True, eq=False)
class Bright:
    """Light by direction, as far as it is known without looking at the scene."""

    cells: mi.Float  #: (CELLS * CELLS,) luminance by octahedral coordinates, row by row
    lamps: tuple[Lamp, ...]  #: as they are, for those who know where they stand


def bright_map(scene: Scene) -> Bright:
    """Return the map of a scene's sky and lamps."""
    rng = stream(scene.seed, scene.scene_id, "render/light/bright")
    row, column = np.mgrid[:CELLS, :CELLS]
    jitter = rng.uniform(-_BEYOND, 1.0 + _BEYOND, (2, CELLS, CELLS, _DIRECTIONS))
    direction = octahedral((column[..., None] + jitter[0]) / CELLS, (row[..., None] + jitter[1]) / CELLS)
    light = _sky(scene, direction)
    origin = rng.uniform(_LOW, _HIGH, (*direction.shape[:-1], 3))
    for lamp in scene.lights:
        light = np.where(_meets(lamp, origin, direction), float(luminance(np.array(lamp.radiance))), light)
    environment = bake_environment(scene.environment)
    ground = _GROUND * float(luminance(irradiance(environment, scene.environment.strength, scene.lights))) / np.pi
    light = np.where(direction[..., 2] < 0.0, ground, light).mean(-1)
    cells = mi.Float(np.maximum(light, _LEAST * ground).astype(np.float32).ravel())
    dr.make_opaque(cells)
    return Bright(cells, tuple(_lamp(light) for light in scene.lights))


def _lamp(light: AreaLight) -> Lamp:
    pose = light.world_T_light
    across, up = (2.0 / size * pose[:3, axis] for axis, size in enumerate(light.size))
    centre, across, up = (tuple(map(float, vector)) for vector in (pose[:3, 3], across, up))
    shines = mi.Float(float(luminance(np.array(light.radiance))))
    lamp = Lamp(mi.Point3f(*centre), mi.Vector3f(*across), mi.Vector3f(*up), shines)
    dr.make_opaque(lamp.centre, lamp.across, lamp.up, lamp.light)
    return lamp


def octahedral(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return unit vectors of octahedral coordinates in [0, 1]^2 (Cigolle et al. 2014, JCGT 3(2), section 3.1)."""
    x, y = np.clip(2.0 * x - 1.0, -1.0, 1.0), np.clip(2.0 * y - 1.0, -1.0, 1.0)
    z = 1.0 - np.abs(x) - np.abs(y)
    under = np.maximum(-z, 0.0)
    out = np.stack([x - np.copysign(under, x), y - np.copysign(under, y), z], -1)
    return out / np.linalg.norm(out, axis=-1, keepdims=True)


def _sky(scene: Scene, direction: np.ndarray) -> np.ndarray:
    """Return the luminance of the environment by direction."""
    pixels = luminance(bake_environment(scene.environment)) * scene.environment.strength
    height, width = pixels.shape
    theta = np.arccos(np.clip(direction[..., 2], -1.0, 1.0))
    phi = np.arctan2(direction[..., 1], direction[..., 0]) - scene.environment.rotation
    row = np.clip((theta / np.pi * height).astype(int), 0, height - 1)
    return pixels[row, np.floor(phi / (2.0 * np.pi) * width).astype(int) % width]


def _meets(lamp: AreaLight, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Return which rays meet the front of a rectangle."""
    pose, towards = lamp.world_T_light, direction @ lamp.world_T_light[:3, 2]
    t = np.divide((pose[:3, 3] - origin) @ pose[:3, 2], towards, out=np.zeros_like(towards), where=towards < 0.0)
    local = (origin + t[..., None] * direction - pose[:3, 3]) @ pose[:3, :2]
    return (t > 0.0) & (np.abs(local) < 0.5 * np.array(lamp.size)).all(-1)


def light_from(bright: Bright, direction: mi.Vector3f) -> mi.Float:
    """Return the light of the cell that a direction lies in."""
    scale = dr.rcp(dr.abs(direction.x) + dr.abs(direction.y) + dr.abs(direction.z))
    x, y = direction.x * scale, direction.y * scale
    under = direction.z < 0.0
    u = dr.select(under, dr.copysign(1.0 - dr.abs(y), x), x)
    v = dr.select(under, dr.copysign(1.0 - dr.abs(x), y), y)
    column, row = (mi.UInt32(dr.clip((0.5 * c + 0.5) * CELLS, 0.0, CELLS - 1.0)) for c in (u, v))
    return dr.gather(mi.Float, bright.cells, row * CELLS + column)


def light_along(bright: Bright, p: mi.Point3f, direction: mi.Vector3f) -> mi.Float:
    """Return the light that a ray from `p` is likely to meet: of the cell, or of the lamp that stands there."""
    light = light_from(bright, direction)
    for lamp in bright.lamps:
        normal, away = dr.cross(lamp.across, lamp.up), lamp.centre - p
        towards = dr.dot(direction, normal)
        t = dr.dot(away, normal) / towards
        at = t * direction - away
        inside = (dr.abs(dr.dot(at, lamp.across)) < 1.0) & (dr.abs(dr.dot(at, lamp.up)) < 1.0)
        light = dr.select((t > 0.0) & (towards < 0.0) & inside, dr.maximum(light, lamp.light), light)
    return light


def steered(
    bright: Bright, index: mi.Float, counts: mi.Float
) -> Callable[[mi.Vector3f, mi.Normal3f, mi.Float], mi.Float]:
    """Return how often to mirror rays (`dielectric.Odds`) in a medium of an index that count so many times."""

    def odds(wi: mi.Vector3f, facet: mi.Normal3f, reflectance: mi.Float) -> mi.Float:
        share = mirrored_share(bright, wi, facet, index, reflectance)
        return dr.select(counts > _HEAVY, reflectance, share)

    return odds


def mirrored_share(
    bright: Bright, wi: mi.Vector3f, facet: mi.Normal3f, index: mi.Float, reflectance: mi.Float
) -> mi.Float:
    """Return how often an interface should mirror a ray, by the light that waits on either side.

    Where the ray ends is not known. It is taken to leave by a face parallel to this one, as from the wall of a vessel:
    by Snell's law it then has the direction that the same tangential component has in air. The wall's other face
    mirrors once more, so what is refracted here may still find the light on this side.

    Parameters
    ----------
    bright : Bright
        The map.
    wi : mi.Vector3f
        Unit direction to where the ray came from.
    facet : mi.Normal3f
        Normal on the side of `wi`.
    index : mi.Float
        Index of the medium on that side.
    reflectance : mi.Float
        Fresnel's share.
    """
    along = index * (dr.dot(wi, facet) * facet - wi)
    across = dr.safe_sqrt(1.0 - dr.squared_norm(along)) * facet
    near = reflectance * light_from(bright, mi.Vector3f(along + across))
    far = (1.0 - reflectance) * (light_from(bright, mi.Vector3f(along - across)) + near)
    share = dr.lerp(reflectance, near / (near + far), _TRUST)
    return dr.select(reflectance < 1.0, share, 1.0)
