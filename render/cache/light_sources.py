"""Where photons start: emitters and the spheres around glass that photons are aimed at.

Caustics come from light that glass has refracted or reflected, so light paths are only started towards glass. The glass
bodies are covered by spheres (`targets_of`). A photon of the environment is a line through the disc of a sphere, a
photon of an area light a direction within the cone of a sphere. Where spheres overlap, the densities of all spheres
that a line or direction hits are added (one-sample multiple importance sampling, Veach 1997, section 9.2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.scene import GlassBody, Scene
from ...procedural.description.surroundings import AreaLight
from ...procedural.surroundings.colour import luminance
from ...procedural.surroundings.environments import bake_environment
from .._mitsuba import dr, mi, syntax
from ..pictures.sampler import SobolSampler, sample_4d
from ..scene.emitters import Emitters
from ..scene.room_emitter import radiance_towards, shell_point

#: Smallest probability of an emitter [1]: an estimate of its light that is far too low must not starve it.
_MIN_PROBABILITY = 0.05
#: Distance at which photons start off an area light [m].
_CLEARANCE = 1e-4
#: Sets of the sampler: choices and the position on a sphere's disc; the position or direction of the emitter.
_TARGET_SET, _EMITTER_SET = 0, 1


@dataclass(frozen=True, eq=False)
class Targets:
    """Spheres that cover the glass of a scene."""

    centre: np.ndarray  #: (n, 3) [m]
    radius: np.ndarray  #: (n,) [m]

    @property
    def area(self) -> float:
        """Sum of the areas of the spheres' discs [m^2]."""
        return float(np.pi * (self.radius**2).sum())


@dataclass(frozen=True, eq=False)
class LightSources:
    """Emitters and targets as opaque Dr.Jit arrays. The environment is emitter 0, area lights follow."""

    probability: mi.Float  #: by emitter
    cumulative: mi.Float  #: by emitter: sum of the probabilities up to and including it
    emitters: mi.UInt32
    lamp_centre: mi.Float  #: by emitter, 3 each [m]; the row of the environment is not read
    lamp_across: mi.Float  #: from the centre to the middle of an edge, 3 each [m]
    lamp_up: mi.Float
    lamp_radiance: mi.Float  #: 3 each, linear Rec.709
    sphere: mi.Float  #: by sphere: centre and radius [m], 4 each
    sphere_cumulative: mi.Float  #: by sphere: sum of the probabilities, which are proportional to the disc's area
    spheres: mi.UInt32
    disc_area: mi.Float  #: `Targets.area`
    reach: mi.Float  #: distance at which photons of the environment start, outside the scene [m]


@dataclass(frozen=True, eq=False)
class Emission:
    """Photons as they leave their emitters, one entry a photon."""

    ray: mi.Ray3f
    power: mi.Color3f  #: flux over the number of photons is this over the number of photons [radiance unit * sr * m^2]


def targets_of(scene: Scene) -> Targets:
    """Return spheres that cover the glass bodies; long bodies get several along their longest axis."""
    spheres = [sphere for body in scene.objects if isinstance(body, GlassBody) for sphere in _covering(body)]
    centre = np.array([centre for centre, _ in spheres]).reshape(-1, 3)
    return Targets(centre, np.array([radius for _, radius in spheres]))


def _covering(body: GlassBody) -> list[tuple[np.ndarray, float]]:
    """Return the spheres around one body, world frame.

    The body lies in a cylinder about the longest axis of its bounding box. It is cut into pieces about as long as they
    are wide, and a sphere is put around each.
    """
    vertices = np.concatenate([interface.mesh.vertices for interface in body.interfaces]).astype(np.float64)
    low, high = vertices.min(0), vertices.max(0)
    middle, extent = 0.5 * (low + high), high - low
    axis = int(np.argmax(extent))
    across = np.delete(vertices - middle, axis, axis=1)
    width = float(np.linalg.norm(across, axis=1).max())
    pieces = max(1, round(extent[axis] / (2.0 * width)))
    half = 0.5 * extent[axis] / pieces
    # A thousandth more than exact: float32 rounding of a body must not leave its sphere.
    radius = 1.001 * float(np.hypot(width, half))
    centres = np.tile(middle, (pieces, 1))
    centres[:, axis] += (2.0 * np.arange(pieces) + 1.0 - pieces) * half
    pose = body.world_T_object
    return [(pose[:3, :3] @ centre + pose[:3, 3], radius) for centre in centres]


def light_sources(scene: Scene, mi_scene: mi.Scene) -> LightSources:
    """Return the emitters and targets of a scene that has glass."""
    targets = targets_of(scene)
    weight = _emitter_weights(scene, targets)
    probability = (1.0 - _MIN_PROBABILITY) * weight / weight.sum() + _MIN_PROBABILITY / len(weight)
    centre, across, up, radiance = (np.zeros((len(weight), 3)) for _ in range(4))
    for row, lamp in enumerate(scene.lights, start=1):
        pose = lamp.world_T_light
        centre[row], radiance[row] = pose[:3, 3], lamp.radiance
        across[row], up[row] = 0.5 * lamp.size[0] * pose[:3, 0], 0.5 * lamp.size[1] * pose[:3, 1]
    corners = np.abs(np.array([mi_scene.bbox().min, mi_scene.bbox().max])).max(axis=0)
    area = targets.radius**2
    return LightSources(
        probability=_opaque(probability),
        cumulative=_opaque(_cumulative(probability)),
        emitters=dr.opaque(mi.UInt32, len(weight)),
        lamp_centre=_opaque(centre),
        lamp_across=_opaque(across),
        lamp_up=_opaque(up),
        lamp_radiance=_opaque(radiance),
        sphere=_opaque(np.concatenate([targets.centre, targets.radius[:, None]], axis=1)),
        sphere_cumulative=_opaque(_cumulative(area / area.sum())),
        spheres=dr.opaque(mi.UInt32, len(area)),
        disc_area=dr.opaque(mi.Float, targets.area),
        reach=dr.opaque(mi.Float, 2.0 * float(np.linalg.norm(corners))),
    )


def _opaque(values: np.ndarray) -> mi.Float:
    array = mi.Float(np.ascontiguousarray(values, np.float32).ravel())
    dr.make_opaque(array)
    return array


def _cumulative(probability: np.ndarray) -> np.ndarray:
    total = np.cumsum(probability)
    total[-1] = np.inf  # a random number rounded up must not fall off the end
    return total


def _emitter_weights(scene: Scene, targets: Targets) -> np.ndarray:
    """Return the flux of each emitter that reaches the targets, unoccluded: irradiance times the area of the discs."""
    pixels = luminance(bake_environment(scene.environment)) * scene.environment.strength
    rows = np.sin((np.arange(len(pixels)) + 0.5) / len(pixels) * np.pi)
    weights = [4.0 * np.pi * float(np.average(pixels.mean(axis=1), weights=rows)) * targets.area]
    weights += [_lamp_flux(lamp, targets) for lamp in scene.lights]
    return np.maximum(np.array(weights), 1e-12 * max(*weights, 1e-12))


def _lamp_flux(lamp: AreaLight, targets: Targets) -> float:
    """Return the flux of an area light through the discs of all spheres, by the inverse square law."""
    away = targets.centre - lamp.world_T_light[:3, 3]
    distance = np.linalg.norm(away, axis=1)
    cos = np.maximum(away @ lamp.world_T_light[:3, 2] / distance, 0.0)
    intensity = float(luminance(np.array(lamp.radiance))) * lamp.size[0] * lamp.size[1]
    return float((intensity * cos * np.pi * (targets.radius / distance) ** 2).sum())


def emit(sources: LightSources, emitters: Emitters, sampler: SobolSampler) -> Emission:
    """Sample an emitter, a target, and a photon from the one to the other."""
    u_emitter, u_sphere, u, v = sample_4d(sampler, mi.UInt32(_TARGET_SET))
    a, b, *_ = sample_4d(sampler, mi.UInt32(_EMITTER_SET))
    emitter, probability = _chosen_emitter(sources, u_emitter)
    x, y, z, radius = dr.gather(
        mi.Vector4f, sources.sphere, _chosen(sources.sphere_cumulative, sources.spheres, u_sphere)
    )
    sphere = mi.Point3f(x, y, z), radius
    from_surroundings = _from_environment if emitters.room is None else _from_room
    sky = from_surroundings(sources, emitters, sphere, (u, v), mi.Point2f(a, b))
    lamp = _from_lamp(sources, emitter, sphere, (u, v), (a, b))
    is_sky = emitter == 0
    power = dr.select(is_sky, sky.power, lamp.power) / probability
    origin, direction = (
        dr.select(is_sky, one, other) for one, other in ((sky.ray.o, lamp.ray.o), (sky.ray.d, lamp.ray.d))
    )
    return Emission(mi.Ray3f(origin, direction), power)


def _chosen_emitter(sources: LightSources, u: mi.Float) -> tuple[mi.UInt32, mi.Float]:
    emitter = _chosen(sources.cumulative, sources.emitters, u)
    return emitter, dr.gather(mi.Float, sources.probability, emitter)


@syntax
def _chosen(cumulative: mi.Float, count: mi.UInt32, u: mi.Float) -> mi.UInt32:
    """Return the first entry whose cumulative probability is above a random number."""
    entry, searching = mi.UInt32(0), mi.Bool(True)
    while dr.hint(searching, exclude=[cumulative, count, u]):
        searching = (dr.gather(mi.Float, cumulative, entry) <= u) & (entry + 1 < count)
        entry += dr.select(searching, mi.UInt32(1), mi.UInt32(0))
    return entry


def _from_environment(
    sources: LightSources,
    emitters: Emitters,
    sphere: tuple[mi.Point3f, mi.Float],
    disc: tuple[mi.Float, mi.Float],
    u_direction: mi.Point2f,
) -> Emission:
    """Return photons that come from the environment through the disc of a sphere.

    The density of parallel lines by area is the sum over the spheres that a line hits of the sphere's probability over
    its disc's area, which is the number of spheres hit over the area of all discs.
    """
    centre, radius = sphere
    at = dr.zeros(mi.Interaction3f, dr.width(radius))
    at.p = centre
    ds, arriving = emitters.scene.environment().sample_direction(at, u_direction)
    direction = -ds.d
    x, y = _disc_point(disc)
    frame = mi.Frame3f(direction)
    through = centre + radius * (x * frame.s + y * frame.t)
    hits = _spheres_hit(sources, through, direction)[0]
    power = dr.select(ds.pdf > 0.0, mi.Color3f(arriving) * sources.disc_area / dr.maximum(hits, 1.0), 0.0)
    return Emission(mi.Ray3f(through - sources.reach * direction, direction), power)


def _from_room(
    sources: LightSources,
    emitters: Emitters,
    sphere: tuple[mi.Point3f, mi.Float],
    cone: tuple[mi.Float, mi.Float],
    u_direction: mi.Point2f,
) -> Emission:
    """Return photons from a point of the room's shell within the cone that a sphere fills.

    The room's map chooses the point. What the line to the sphere meets last before it, a wall, a cupboard or the view
    outside, sends the photon.
    """
    room = emitters.room
    assert room is not None
    centre, radius = sphere
    ds, _ = emitters.scene.environment().sample_direction(dr.zeros(mi.Interaction3f, dr.width(radius)), u_direction)
    origin, normal, area = shell_point(room, ds.d)
    direction, pdf = _towards_sphere(sources, origin, sphere, cone)
    near = origin + dr.maximum(dr.dot(centre - origin, direction) - radius, 0.0) * direction
    radiance, distance = radiance_towards(room, near, -direction)
    flux = radiance * dr.abs(dr.dot(normal, direction))
    density = ds.pdf / area * pdf
    back = dr.select(dr.isfinite(distance), distance, dr.norm(near - origin)) - _CLEARANCE
    return Emission(mi.Ray3f(near - back * direction, direction), dr.select(density > 0.0, flux / density, 0.0))


def _towards_sphere(
    sources: LightSources, origin: mi.Point3f, sphere: tuple[mi.Point3f, mi.Float], cone: tuple[mi.Float, mi.Float]
) -> tuple[mi.Vector3f, mi.Float]:
    """Return a direction from a point within the cone that a sphere fills, and its density over all spheres."""
    centre, radius = sphere
    axis = centre - origin
    distance = dr.norm(axis)
    versine = _cone_versine(distance, radius) * cone[0]  # 1 - cos
    sin, turn = dr.safe_sqrt(versine * (2.0 - versine)), dr.two_pi * cone[1]
    frame = mi.Frame3f(dr.select(distance > 0.0, axis / distance, mi.Vector3f(0.0, 0.0, 1.0)))
    direction = (1.0 - versine) * frame.n + sin * (dr.cos(turn) * frame.s + dr.sin(turn) * frame.t)
    return direction, _spheres_hit(sources, origin, direction)[1]


def _from_lamp(
    sources: LightSources,
    emitter: mi.UInt32,
    sphere: tuple[mi.Point3f, mi.Float],
    cone: tuple[mi.Float, mi.Float],
    position: tuple[mi.Float, mi.Float],
) -> Emission:
    """Return photons from a uniform point of an area light, uniform within the cone that a sphere fills."""
    lamp_centre, across, up = (
        mi.Vector3f(dr.gather(mi.Point3f, values, emitter))
        for values in (sources.lamp_centre, sources.lamp_across, sources.lamp_up)
    )
    origin = mi.Point3f(lamp_centre + (2.0 * position[0] - 1.0) * across + (2.0 * position[1] - 1.0) * up)
    direction, pdf = _towards_sphere(sources, origin, sphere, cone)
    area = dr.cross(2.0 * across, 2.0 * up)  # its length is the lamp's area
    radiance = dr.gather(mi.Color3f, sources.lamp_radiance, emitter)
    flux = radiance * dr.maximum(dr.dot(area, direction), 0.0)
    start = origin + _CLEARANCE * direction  # not to hit the lamp itself
    return Emission(mi.Ray3f(start, direction), dr.select(pdf > 0.0, flux / pdf, 0.0))


def _disc_point(u: tuple[mi.Float, mi.Float]) -> tuple[mi.Float, mi.Float]:
    point = mi.warp.square_to_uniform_disk_concentric(mi.Point2f(*u))
    return point.x, point.y


def _cone_versine(distance: mi.Float, radius: mi.Float) -> mi.Float:
    """Return 1 - cos of the half angle of a sphere's cone, accurate for small angles; 2 from inside: all directions."""
    sin2 = dr.square(radius / distance)
    return dr.select(sin2 < 1.0, sin2 / (1.0 + dr.safe_sqrt(1.0 - sin2)), 2.0)


@syntax
def _spheres_hit(sources: LightSources, origin: mi.Point3f, direction: mi.Vector3f) -> tuple[mi.Float, mi.Float]:
    """Return how many spheres lines hit, and the density by solid angle of rays that are aimed at the spheres."""
    hits, pdf, k = mi.Float(0.0), mi.Float(0.0), mi.UInt32(0)
    while dr.hint(k < sources.spheres, exclude=[sources, origin, direction]):
        x, y, z, radius = dr.gather(mi.Vector4f, sources.sphere, k)
        away = mi.Point3f(x, y, z) - origin
        along = dr.dot(away, direction)
        inside = dr.squared_norm(away - along * direction) <= dr.square(radius)
        versine = _cone_versine(dr.norm(away), radius)
        aimed = inside & ((along > 0.0) | (versine == 2.0))
        hits += dr.select(inside, 1.0, 0.0)
        solid_angle = dr.two_pi * versine
        pdf += dr.select(aimed, dr.pi * dr.square(radius) / sources.disc_area / solid_angle, 0.0)
        k += 1
    return hits, pdf
