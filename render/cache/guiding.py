"""Path guiding at smooth interfaces: reflection is sampled more often where it leads to bright emitters.

Emitters fill a small part of the directions that a ray through glass may take, and cause most of the noise in glass:
one ray in a thousand is reflected towards them. `guided_reflect_probability` raises the probability of reflection there
(importance sampling), and the path's weight compensates it. The guide is a coarse map of the emission of sky and area
lights by direction. The result is unbiased with any map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.randomness import stream
from ...procedural.description.scene import Scene
from ...procedural.description.surroundings import AreaLight
from ...procedural.surroundings.colour import luminance
from ...procedural.surroundings.environments import bake_environment
from ...procedural.surroundings.metering import irradiance
from ...procedural.surroundings.sun_glints import wide_sun
from .._mitsuba import dr, mi
from ..interfaces.dielectric import ReflectProbability

#: Cells along one side of the map [1]: about 3 degrees each, the size of a small lamp.
CELLS = 64
#: Directions averaged in a cell [1], and how far they reach beyond it [cells], so that cells beside a lamp contain a
#: part of it.
_DIRECTIONS, _MARGIN = 64, 0.5
#: How far the sun reaches beyond the disc that paths find through glass [rad], 4 degrees: walls spread a pixel's paths.
_AROUND_SUN = np.radians(4.0)
#: Box of random ray origins [m]: lamps are so far away that their exact position matters little.
_LOW, _HIGH = (-0.2, -0.2, 0.0), (0.2, 0.2, 0.15)
#: Assumed reflectance of the table seen from above [1], and smallest emission of a cell over the table's radiance [1].
_TABLE_REFLECTANCE, _MIN_EMISSION = 0.3, 0.1
#: Weight of the guided probability against the Fresnel reflectance [1]. One half bounds the weight of either lobe by 2.
_GUIDING_WEIGHT = 0.5
#: Throughput above which paths are not guided [1]: repeated events of low probability would make fireflies.
_MAX_GUIDED_THROUGHPUT = 2.0


@dataclass(frozen=True, eq=False)
class Lamp:
    """An area light: a rectangle that emits on the side of `across` x `up`."""

    centre: mi.Point3f
    across: mi.Vector3f  #: from the centre to the middle of an edge, over the square of that distance [1/m]
    up: mi.Vector3f
    luminance: mi.Float


@dataclass(frozen=True, eq=False)
class EmissionMap:
    """Emission by direction, without occlusion by the scene's objects."""

    cells: mi.Float  #: (CELLS * CELLS,) luminance by octahedral coordinates, row by row
    lamps: tuple[Lamp, ...]  #: exact, for lookups from a known position


def emission_map(scene: Scene) -> EmissionMap:
    """Return the emission map of a scene's environment and area lights."""
    rng = stream(scene.seed, scene.scene_id, "render/light/bright")
    row, column = np.mgrid[:CELLS, :CELLS]
    jitter = rng.uniform(-_MARGIN, 1.0 + _MARGIN, (2, CELLS, CELLS, _DIRECTIONS))
    direction = octahedral((column[..., None] + jitter[0]) / CELLS, (row[..., None] + jitter[1]) / CELLS)
    light = _sky(scene, direction)
    origin = rng.uniform(_LOW, _HIGH, (*direction.shape[:-1], 3))
    for lamp in scene.lights:
        light = np.where(hits_lamp(lamp, origin, direction), float(luminance(np.array(lamp.radiance))), light)
    environment = bake_environment(scene.environment)
    ground = (
        _TABLE_REFLECTANCE * float(luminance(irradiance(environment, scene.environment.strength, scene.lights))) / np.pi
    )
    light = np.where(direction[..., 2] < 0.0, ground, light).mean(-1)
    cells = mi.Float(np.maximum(light, _MIN_EMISSION * ground).astype(np.float32).ravel())
    dr.make_opaque(cells)
    return EmissionMap(cells, tuple(_lamp(light) for light in scene.lights))


def _lamp(light: AreaLight) -> Lamp:
    pose = light.world_T_light
    across, up = (2.0 / size * pose[:3, axis] for axis, size in enumerate(light.size))
    centre, across, up = (tuple(map(float, vector)) for vector in (pose[:3, 3], across, up))
    radiance = mi.Float(float(luminance(np.array(light.radiance))))
    lamp = Lamp(mi.Point3f(*centre), mi.Vector3f(*across), mi.Vector3f(*up), radiance)
    dr.make_opaque(lamp.centre, lamp.across, lamp.up, lamp.luminance)
    return lamp


def octahedral(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return unit vectors of octahedral coordinates in [0, 1]^2 (Cigolle et al. 2014, JCGT 3(2), section 3.1)."""
    x, y = np.clip(2.0 * x - 1.0, -1.0, 1.0), np.clip(2.0 * y - 1.0, -1.0, 1.0)
    z = 1.0 - np.abs(x) - np.abs(y)
    under = np.maximum(-z, 0.0)
    out = np.stack([x - np.copysign(under, x), y - np.copysign(under, y), z], -1)
    return out / np.linalg.norm(out, axis=-1, keepdims=True)


def _sky(scene: Scene, direction: np.ndarray) -> np.ndarray:
    """Return the luminance of the environment by direction, with the sun as wide as paths find it through glass."""
    pixels = luminance(bake_environment(scene.environment)) * scene.environment.strength
    height, width = pixels.shape
    sun = wide_sun(scene.environment, min(1.0 / camera.focal for camera in scene.cameras))
    theta = np.arccos(np.clip(direction[..., 2], -1.0, 1.0))
    phi = np.arctan2(direction[..., 1], direction[..., 0]) - scene.environment.rotation
    row = np.clip((theta / np.pi * height).astype(int), 0, height - 1)
    light = pixels[row, np.floor(phi / (2.0 * np.pi) * width).astype(int) % width]
    if sun is not None:
        near = direction @ sun.direction > np.cos(np.arccos(sun.disc_cos) + _AROUND_SUN)
        light = np.where(near, np.maximum(light, luminance(sun.light) / (2.0 * np.pi * (1.0 - sun.disc_cos))), light)
    return light


def hits_lamp(lamp: AreaLight, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Return which rays hit the front of an area light, bool by ray."""
    pose, towards = lamp.world_T_light, direction @ lamp.world_T_light[:3, 2]
    t = np.divide((pose[:3, 3] - origin) @ pose[:3, 2], towards, out=np.zeros_like(towards), where=towards < 0.0)
    local = (origin + t[..., None] * direction - pose[:3, 3]) @ pose[:3, :2]
    return (t > 0.0) & (np.abs(local) < 0.5 * np.array(lamp.size)).all(-1)


def emission_from(emission: EmissionMap, direction: mi.Vector3f) -> mi.Float:
    """Return the luminance of the cell that contains a direction."""
    scale = dr.rcp(dr.abs(direction.x) + dr.abs(direction.y) + dr.abs(direction.z))
    x, y = direction.x * scale, direction.y * scale
    under = direction.z < 0.0
    u = dr.select(under, dr.copysign(1.0 - dr.abs(y), x), x)
    v = dr.select(under, dr.copysign(1.0 - dr.abs(x), y), y)
    column, row = (mi.UInt32(dr.clip((0.5 * c + 0.5) * CELLS, 0.0, CELLS - 1.0)) for c in (u, v))
    return dr.gather(mi.Float, emission.cells, row * CELLS + column)


def emission_along(emission: EmissionMap, p: mi.Point3f, direction: mi.Vector3f) -> mi.Float:
    """Return the expected luminance of a ray from `p`: that of its cell, or of the area light that it hits."""
    light = emission_from(emission, direction)
    for lamp in emission.lamps:
        normal, away = dr.cross(lamp.across, lamp.up), lamp.centre - p
        towards = dr.dot(direction, normal)
        t = dr.dot(away, normal) / towards
        at = t * direction - away
        inside = (dr.abs(dr.dot(at, lamp.across)) < 1.0) & (dr.abs(dr.dot(at, lamp.up)) < 1.0)
        light = dr.select((t > 0.0) & (towards < 0.0) & inside, dr.maximum(light, lamp.luminance), light)
    return light


def path_guide(emission: EmissionMap, index: mi.Float, throughput: mi.Float) -> ReflectProbability:
    """Return the guide of paths with a given throughput in a medium of the given index, for `dielectric.scatter`."""

    def reflect_probability(wi: mi.Vector3f, facet: mi.Normal3f, reflectance: mi.Float) -> mi.Float:
        guided = guided_reflect_probability(emission, wi, facet, index, reflectance)
        return dr.select(throughput > _MAX_GUIDED_THROUGHPUT, reflectance, guided)

    return reflect_probability


def guided_reflect_probability(
    emission: EmissionMap, wi: mi.Vector3f, facet: mi.Normal3f, index: mi.Float, reflectance: mi.Float
) -> mi.Float:
    """Return the probability of reflection at an interface, by the emission that either lobe leads to.

    The end of the ray is unknown. It is assumed to leave by a face parallel to this one, as from the wall of a vessel:
    by Snell's law it then has the direction with the same tangential component in air. The wall's other face reflects
    as well, so a refracted ray may still reach the emission on this side.

    Parameters
    ----------
    emission : EmissionMap
        The map.
    wi : mi.Vector3f
        Unit direction to where the ray came from.
    facet : mi.Normal3f
        Normal on the side of `wi`.
    index : mi.Float
        Index of the medium on that side.
    reflectance : mi.Float
        Fresnel reflectance.
    """
    along = index * (dr.dot(wi, facet) * facet - wi)
    across = dr.safe_sqrt(1.0 - dr.squared_norm(along)) * facet
    near = reflectance * emission_from(emission, mi.Vector3f(along + across))
    far = (1.0 - reflectance) * (emission_from(emission, mi.Vector3f(along - across)) + near)
    guided = dr.lerp(reflectance, near / (near + far), _GUIDING_WEIGHT)
    return dr.select(reflectance < 1.0, guided, 1.0)
