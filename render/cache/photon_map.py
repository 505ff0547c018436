"""Photon map: light that reaches opaque surfaces through glass (caustics), traced from the emitters.

Paths from a surface find a small lamp behind glass by chance: one path in a thousand carries all of the light. Traced
from the lamp, all photons carry the same (Jensen 1996, "Global Illumination using Photon Maps"). A photon is refracted
and reflected by glass until it lands on an opaque surface, at the cache point that represents the place. Photons that
land without meeting glass are dropped: that is direct light, which emitter sampling finds.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import numpy as np

from ...procedural.description.scene import TABLE_ID
from .._mitsuba import dr, mi, syntax
from ..interfaces.dielectric import scatter
from ..pictures.integrator import interface_hit, path_dimensions
from ..pictures.sampler import SobolSampler, hashed_seed, sobol_sampler
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.surfaces import registry_id, surface_media
from .cache_points import CachePoints, Lookup, interpolation_weights, lookup_of, point_areas
from .light_sources import LightSources, emit, light_sources
from .lobes import schlick

#: Photons of one pass [1]. Each holds 60 bytes of results, so a pass stays near 130 MB.
PHOTONS_PER_PASS = 1 << 21
#: Surfaces that photons meet in each round [1]; between the rounds the ones in flight are compacted. Most photons have
#: ended after a few surfaces, and one that total reflection keeps in glass would hold the other lanes of its packet.
ROUNDS = (1, 3, 8, 1 << 20)
#: Largest correction of an interpolated normal [1] (`_adjoint_factor`), which grows without bound at grazing angles.
_MAX_CORRECTION = 4.0
#: Surfaces of glass that a photon meets before Russian roulette begins [1]: what lands then has nearly equal power.
_RR_DEPTH = 2
#: Maximum survival probability of Russian roulette [1]: photons that total reflection keeps in lossless glass end after
#: some twenty more surfaces. (Paths from the camera survive with 0.99; photons are more, and each carries less.)
_MAX_SURVIVAL = 0.95


@dataclass(frozen=True, eq=False)
class _Photons:
    """Photons between two surfaces, one entry a photon."""

    origin: mi.Point3f
    direction: mi.Vector3f
    power: mi.Color3f  #: when emitted
    beta: mi.Color3f  #: fraction of it that is left
    depth: mi.UInt32  #: surfaces met
    index: mi.UInt32  #: number of the photon
    active: mi.Bool


@dataclass(frozen=True, eq=False)
class _Landed:
    """Photons on opaque surfaces, one entry a photon."""

    si: mi.SurfaceInteraction3f
    uv: mi.Point2f  #: barycentric coordinates
    direction: mi.Vector3f  #: of the photon
    power: mi.Color3f
    valid: mi.Bool


def photon_moments(loaded: LoadedScene, points: CachePoints, photons: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the light that reaches the cache points through glass, by two halves of the photons.

    Parameters
    ----------
    loaded : LoadedScene
        The scene, loaded for the cache.
    points : CachePoints
        The cache points.
    photons : int
        Number of photons.
    seed : int
        32-bit seed.

    Returns
    -------
    even, odd : (count, 12) float64
        Moments as `irradiance_cache.IrradianceCache.moments`, directions not yet divided by the irradiance. Each is all
        of the light; the mean of both has the least noise.
    """
    moments = np.zeros((2, points.count, 12))
    if not loaded.description.vessels or photons == 0:
        return moments[0], moments[1]
    sources, lookup = light_sources(loaded.description, loaded.mi_scene), lookup_of(points)
    for first in range(0, photons, PHOTONS_PER_PASS):
        numbers = slice(first, min(first + PHOTONS_PER_PASS, photons))
        for index, odd, values in _trace_pass(loaded, sources, lookup, numbers, photons, seed):
            # In float64 and in the order of the photons: the sum depends on no thread.
            for half in (0, 1):
                for k in range(12):
                    moments[half, :, k] += np.bincount(index[odd == half], values[k][odd == half], points.count)
    moments /= 0.5 * photons * point_areas(points)[:, None]
    return moments[0], moments[1]


def _trace_pass(
    loaded: LoadedScene, sources: LightSources, lookup: Lookup, numbers: slice, photons: int, seed: int
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield cache point, parity of the number and moments of the photons that land, (n,), (n,) and (12, n)."""
    index = dr.arange(mi.UInt32, numbers.stop - numbers.start) + dr.opaque(mi.UInt32, numbers.start)
    sampler = sobol_sampler(dr.zeros(mi.UInt32, dr.width(index)), index, photons, seed)
    emission = emit(sources, loaded.emitters, sampler)
    state = _Photons(
        origin=emission.ray.o,
        direction=emission.ray.d,
        power=emission.power,
        beta=mi.Color3f(1.0),
        depth=mi.UInt32(0),
        index=index,
        active=dr.any(emission.power > 0.0),
    )
    for surfaces in ROUNDS:
        state, landed = _through_glass(loaded, state, sampler, surfaces)
        yield _at_cache_points(loaded, lookup, landed, state)
        remaining = dr.compress(state.active)
        if dr.width(remaining) == 0:
            return
        state = _Photons(*(dr.gather(type(value), value, remaining) for value in _values(state)))
        sampler = replace(sampler, pixel=dr.zeros(mi.UInt32, dr.width(remaining)), index=state.index)


def _values(state: _Photons) -> tuple:
    return tuple(getattr(state, field.name) for field in fields(state))


def _at_cache_points(
    loaded: LoadedScene, lookup: Lookup, landed: _Landed, state: _Photons
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return cache point, parity and moments of each photon that has landed; evaluates the photons' state too."""
    on_table = dr.gather(mi.UInt32, loaded.surfaces.instance, registry_id(landed.si.shape), landed.valid) == TABLE_ID
    index, weight = interpolation_weights(lookup, landed.si, landed.uv, -landed.direction, on_table)
    moments = _moments(landed)
    dr.eval(index, weight, moments, landed.valid, _values(state))
    valid = np.array(landed.valid)
    # A cache point stands for the places that it is nearest to, as for the paths of `fill_cache`.
    weights, indices = np.stack([np.array(w) for w in weight]), np.stack([np.array(i) for i in index])
    nearest = np.take_along_axis(indices, np.argmax(weights, axis=0)[None], axis=0)[0]
    parity = np.array(state.index)[valid] % 2
    return nearest[valid].astype(np.int64), parity, np.stack([np.array(m)[valid].astype(np.float64) for m in moments])


def _moments(landed: _Landed) -> list[mi.Float]:
    """Return what a photon adds to E, to E weighted with f, and to the directions of both, times the point's area."""
    si, towards = landed.si, -landed.direction
    sign = dr.select(dr.dot(si.n, towards) < 0.0, mi.Float(-1.0), mi.Float(1.0))
    cos, cos_face = sign * dr.dot(si.sh_frame.n, towards), sign * dr.dot(si.n, towards)
    # Irradiance is by the shading normal, the photons' density by the face.
    correction = dr.clip(cos / dr.maximum(cos_face, 1e-6), 0.0, _MAX_CORRECTION)
    E = dr.select(landed.valid, correction * landed.power, 0.0)
    f = schlick(cos)
    mean = mi.luminance(E) * towards
    return [*E, *(f * E), *mean, *(f * mean)]


@syntax
def _through_glass(
    loaded: LoadedScene, state: _Photons, sampler: SobolSampler, surfaces: int
) -> tuple[_Photons, _Landed]:
    """Follow photons through at most `surfaces` surfaces of glass; return those in flight, and those that landed."""
    scene, table, picture = loaded.mi_scene, loaded.surfaces, loaded.description.picture
    offset, max_depth = dr.opaque(mi.Float, loaded.offset), dr.opaque(mi.UInt32, picture.max_depth)
    limit = state.depth + dr.opaque(mi.UInt32, surfaces)
    # (Copies: the loop must not change the caller's arrays.)
    ray, beta = mi.Ray3f(state.origin, state.direction), mi.Color3f(state.beta)
    depth, active, landed = mi.UInt32(state.depth), mi.Bool(state.active), mi.Bool(False)
    pi = dr.zeros(mi.PreliminaryIntersection3f)

    while dr.hint(active & (depth < limit), exclude=[table, scene, sampler]):
        # (Not coherent: neighbouring photons start anywhere, and Embree takes three times as long if told otherwise.)
        pi = scene.ray_intersect_preliminary(ray, False, active)
        si = pi.compute_surface_interaction(ray, mi.RayFlags.ShadingFrame, active)
        hit = active & si.is_valid()
        surface = surface_media(table, si, ray, hit)
        beta *= table.transmittance(surface, si.wavelengths, active)
        landed = hit & surface.opaque & (depth > 0)
        active = hit & ~surface.opaque

        if dr.hint(active, exclude=[table, scene, sampler]):
            u = path_dimensions(sampler, depth)
            interface = interface_hit(table, surface, ray, si.wavelengths, u.u_lobe, hashed_seed(sampler, depth))
            event = scatter(interface)
            # Power is not scaled by eta^2, as radiance is.
            beta *= event.weight * event.eta_squared
            beta *= _adjoint_factor(surface.n, surface.ns, -ray.d, event.direction)
            ray = leave(si, event.direction, offset)
            depth += 1
            survival = dr.select(depth >= _RR_DEPTH, dr.minimum(dr.max(beta), _MAX_SURVIVAL), 1.0)
            active = dr.any(beta > 0.0) & (depth < max_depth) & (u.u_rr < survival)
            beta *= dr.rcp(survival)

    end = pi.compute_surface_interaction(ray, mi.RayFlags.All, landed)
    is_body = dr.gather(mi.UInt32, table.instance, registry_id(end.shape), landed) > 0  # not an area light
    flying = replace(state, origin=ray.o, direction=ray.d, beta=beta, depth=depth, active=active)
    return flying, _Landed(end, pi.prim_uv, ray.d, state.power * beta, landed & is_body)


def _adjoint_factor(n: mi.Normal3f, ns: mi.Normal3f, wi: mi.Vector3f, wo: mi.Vector3f) -> mi.Float:
    """Return the correction of light paths for interpolated normals (Veach 1997, eq. 5.19).

    Paths from the eye and from the light carry the same light along the same points only with it.
    """
    above = dr.abs(dr.dot(wo, n) * dr.dot(wi, ns))
    below = dr.abs(dr.dot(wo, ns) * dr.dot(wi, n))
    return dr.select(below > 0.0, dr.minimum(above / below, _MAX_CORRECTION), 1.0)
