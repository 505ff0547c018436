"""Integrator that reads the irradiance cache: the ray loop behind pictures with ``picture.light: shared``.

It estimates the same radiance as `integrator.trace`, faster for three reasons. Opaque surfaces are shaded from the
cache, so paths are short. Reflection and refraction are sampled by path guiding (`guiding`), with one number per path
that is well distributed over the samples of a pixel together with the position in the pixel. And wavefronts stay dense:
the loop handles glass alone, the surfaces behind it are shaded once for all rays, and the few paths that stay in glass
or are reflected by glossy surfaces are compacted for another pass.

RGB variants only: no polarisation, no dispersion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...procedural.description.picture import Picture
from .._mitsuba import dr, mi, syntax
from ..interfaces.dielectric import Scattered, scatter
from ..pictures.integrator import (
    MAX_SURVIVAL,
    Bounce,
    PathDimensions,
    PathOrigin,
    Radiance,
    emitter_hit,
    interface_hit,
    opaque_event,
    path_dimensions,
)
from ..pictures.picture import Tracer
from ..pictures.sample_weights import SampleWeights
from ..pictures.sampler import SobolSampler, hashed_seed, sample_4d
from ..scene.emitters import ends_paths
from ..scene.lighting import Spread, SunGlints, sun_glints
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.surfaces import (
    broken_continuity,
    medium_after_bounce,
    medium_after_interface,
    medium_at_end,
    registry_id,
    surface_media,
)
from .footprint import Footprint, NormalDerivatives, followed, normal_derivatives
from .guiding import EmissionMap, emission_map, path_guide
from .irradiance_cache import CachedShader, IrradianceCache, TracedSurfaces, cached_shader, shade
from .path_state import PathState, camera_state, compacted, values_of
from .stored_caustics import stored_caustics

#: Adaptive sampling: with the cache, most noise is in glass and in reflections of polished surfaces (docs/design.md).
CACHED_WEIGHTS = SampleWeights(glass=16.0, polished=6.0)
#: Surfaces that paths meet in the first pass [1]; paths that are left are compacted and followed to their ends. (More
#: passes before that save as much time as they cost.)
FIRST_PASS_SURFACES = 6
#: Number of paths below which all are followed to their ends in one kernel [1]: a pass takes 10 ms for any number of
#: paths, and polished surfaces reflect paths up to thirty times.
MIN_PATHS_PER_PASS = 1 << 17
#: Paths are traced as coherent rays up to this depth [1]: Embree is a third faster so for the first three surfaces, and
#: slower for later ones.
_COHERENT_DEPTH = 4
#: Length of the interval of a path's number below which it is replaced by a new one [1]: a float32 has 24 bits.
_MIN_INTERVAL = 2.0**-12


@dataclass(frozen=True, eq=False)
class CachedTracing:
    """What stays the same along all paths of a trace."""

    loaded: LoadedScene
    sampler: SobolSampler
    picture: Picture
    shader: CachedShader
    emission: EmissionMap
    glints: SunGlints | None  #: the sun as paths find it through glass; None: as it is
    derivatives: NormalDerivatives | None = None  #: of glass, where footprints are followed for `glints`

    def of_paths(self, state: PathState) -> CachedTracing:
        """Return the same for compacted paths, whose lanes differ."""
        return replace(self, sampler=replace(self.sampler, pixel=state.pixel, index=state.index))


def cached_tracer(loaded: LoadedScene, cache: IrradianceCache, traced: tuple[int, ...] = ()) -> Tracer:
    """Return the tracer that reads the irradiance cache of a scene.

    Objects with the ids `traced` are path traced; only their caustics are read.
    """
    emission, glints = emission_map(loaded.description), sun_glints(loaded.description)
    derivatives = None if glints is None else normal_derivatives(loaded)
    shader = cached_shader(loaded, cache, emission, _traced_surfaces(loaded, cache, traced) if traced else None)

    def trace(
        loaded: LoadedScene, ray: mi.Ray3f, weight: mi.UnpolarizedSpectrum, sampler: SobolSampler, picture: Picture
    ) -> Radiance:
        return trace_cached(CachedTracing(loaded, sampler, picture, shader, emission, glints, derivatives), ray)

    return Tracer(trace, CACHED_WEIGHTS)


def _traced_surfaces(loaded: LoadedScene, cache: IrradianceCache, ids: tuple[int, ...]) -> TracedSurfaces:
    rows = mi.Bool(np.isin(np.array(loaded.surfaces.instance), ids))
    dr.make_opaque(rows)
    caustics = np.zeros(cache.moments.shape) if cache.caustics is None else cache.caustics
    return TracedSurfaces(rows, stored_caustics(loaded, cache.points, caustics))


def trace_cached(tracing: CachedTracing, ray: mi.Ray3f) -> Radiance:
    """Trace one path for every camera ray (`picture.camera_paths`); return their radiance, evaluated."""

    def advanced(state: PathState, surfaces: int = tracing.picture.max_depth) -> PathState:
        return _advanced(tracing, state, surfaces)

    state = advanced(camera_state(ray, tracing.sampler, tracing.derivatives), FIRST_PASS_SURFACES)
    dr.eval(state)
    found = state.L, state.violations, state.depth
    remaining = dr.compress(state.active)
    while dr.width(remaining) > 0:
        rest = compacted(state, remaining)
        state = advanced(rest) if dr.width(remaining) > MIN_PATHS_PER_PASS else _to_the_end(rest, advanced)
        dr.eval(state)
        for result, value in zip(found, (state.L, state.violations, state.depth), strict=True):
            dr.scatter(result, value, state.lane, mode=dr.ReduceMode.Permute)
        remaining = dr.compress(state.active)
    light, violations, segments = found
    violations = dr.minimum(violations, 1)
    dr.eval(light, violations, segments)
    return Radiance(light, violations, segments)


@syntax
def _to_the_end(first: PathState, advanced: Callable[[PathState], PathState]) -> PathState:
    """Follow paths until all have ended, in one kernel."""
    state, active = values_of(first), mi.Bool(first.active)
    while dr.hint(active, exclude=[first, advanced]):
        found = advanced(PathState(*state))
        state, active = values_of(found), mi.Bool(found.active)
    return PathState(*state)


def _advanced(tracing: CachedTracing, state: PathState, surfaces: int) -> PathState:
    """Follow paths through at most `surfaces` surfaces, and shade where they leave the glass."""
    tracing = tracing.of_paths(state)
    return _shaded(tracing, *_through_glass(tracing, state, surfaces))


@syntax
def _through_glass(
    tracing: CachedTracing, state: PathState, surfaces: int
) -> tuple[PathState, mi.PreliminaryIntersection3f, mi.Bool]:
    """Follow paths until they hit an opaque surface or nothing, end, or have met `surfaces` surfaces.

    Returns
    -------
    state : PathState
        The paths, with their last segments.
    pi : mi.PreliminaryIntersection3f
        The ends of the segments.
    outside : mi.Bool
        Which paths hit an opaque surface or nothing.
    """
    loaded, sampler, picture, emission = tracing.loaded, tracing.sampler, tracing.picture, tracing.emission
    scene, table = loaded.mi_scene, loaded.surfaces
    offset, limit = dr.opaque(mi.Float, loaded.offset), state.depth + dr.opaque(mi.UInt32, surfaces)
    rr_depth, max_depth = dr.opaque(mi.UInt32, picture.rr_depth), dr.opaque(mi.UInt32, picture.max_depth)
    ray, beta = mi.Ray3f(state.origin, state.direction), mi.Color3f(state.beta)
    # (Copies: the loop must not change the caller's arrays.)
    floats = state.eta_scale, state.pdf, state.u_rescaled, state.u_interval
    eta_scale, pdf, u_rescaled, u_interval = (mi.Float(x) for x in floats)
    medium, depth, violations = (mi.UInt32(x) for x in (state.medium, state.depth, state.violations))
    footprint = None if state.footprint is None else replace(state.footprint)
    delta, active, through_glass = (mi.Bool(x) for x in (state.delta, state.active, state.through_glass))
    outside, pi, traced = mi.Bool(False), dr.zeros(mi.PreliminaryIntersection3f), mi.Bool(bool(tracing.shader.traced))

    while dr.hint(active & (depth < limit), exclude=[table, scene, sampler, emission, tracing]):
        pi = scene.ray_intersect_preliminary(ray, depth < _COHERENT_DEPTH, active)
        si = pi.compute_surface_interaction(ray, mi.RayFlags.ShadingFrame, active)
        hit = active & si.is_valid()
        surface = surface_media(table, si, ray, hit)
        violations += broken_continuity(surface, medium)
        beta *= table.transmittance(surface, si.wavelengths, active)
        outside, active, medium = ~hit | surface.opaque, hit & ~surface.opaque, medium_at_end(surface, medium)

        if dr.hint(active, exclude=[table, scene, sampler, emission, tracing]):
            bits = hashed_seed(sampler, depth)
            interface = interface_hit(table, surface, ray, si.wavelengths, u_rescaled, bits)
            interface = replace(interface, u_facet=_facet_sample(sampler, depth, interface.alpha))
            index = dr.gather(mi.Float, table.eta_d, surface.before)
            event = scatter(interface, path_guide(emission, index, dr.max(beta) * eta_scale))
            beta, eta_scale = beta * event.weight, eta_scale * event.eta_squared
            medium = medium_after_interface(medium, surface, event.transmitted)
            triangle = pi.prim_index, dr.sign(dr.dot(si.n, surface.n))
            footprint = followed(footprint, tracing.derivatives, triangle, surface, ray.d, event, interface.eta)
            u_rescaled, u_interval = rescaled_sample(u_rescaled, u_interval, event.probability, event.transmitted, bits)
            ray, pdf, delta, through_glass = (*_left(si, event, offset), through_glass | traced)
            beta, active = _russian_roulette(beta, eta_scale, depth + 1 >= rr_depth, bits)
        depth += 1
        active &= depth < max_depth

    end = replace(
        state,
        origin=ray.o,
        direction=ray.d,
        beta=beta,
        eta_scale=eta_scale,
        pdf=pdf,
        delta=delta,
        through_glass=through_glass,
        footprint=footprint,
        medium=medium,
        u_rescaled=u_rescaled,
        u_interval=u_interval,
        depth=depth,
        violations=violations,
        active=active,
    )
    return end, pi, outside


def _left(si: mi.SurfaceInteraction3f, event: Scattered, offset: mi.Float) -> tuple[mi.Ray3f, mi.Float, mi.Bool]:
    """Return the ray after an interface, and its density: one direction."""
    return leave(si, event.direction, offset), mi.Float(1.0), mi.Bool(True)


@syntax
def _facet_sample(sampler: SobolSampler, depth: mi.UInt32, alpha: mi.Float) -> mi.Point3f:
    """Return the sample for the first facet of rough interfaces: the set that glossy surfaces use at this depth."""
    sample = mi.Point3f(0.0)
    if dr.hint(alpha > 0.0, exclude=[sampler]):
        u, v, u_lobe, _ = sample_4d(sampler, 2 + 2 * depth)
        sample = mi.Point3f(u, v, u_lobe)
    return sample


@syntax
def _shaded(tracing: CachedTracing, state: PathState, pi: mi.PreliminaryIntersection3f, outside: mi.Bool) -> PathState:
    """Add the radiance of what paths hit outside the glass, and continue those with a glossy bounce."""
    sampler, picture, scene, shader = tracing.sampler, tracing.picture, tracing.loaded.mi_scene, tracing.shader
    offset = dr.opaque(mi.Float, tracing.loaded.offset)
    rr_depth, max_depth = dr.opaque(mi.UInt32, picture.rr_depth), dr.opaque(mi.UInt32, picture.max_depth)
    ray, beta, depth = mi.Ray3f(state.origin, state.direction), mi.Color3f(state.beta), mi.UInt32(state.depth)
    pdf, delta, active, eta_scale = mi.Float(state.pdf), mi.Bool(state.delta), mi.Bool(state.active), state.eta_scale
    medium = mi.UInt32(state.medium)
    si = pi.compute_surface_interaction(ray, mi.RayFlags.All, outside)
    previous = dr.zeros(mi.Interaction3f)
    previous.p = ray.o
    # A direction that only glass or the camera can have, and another surface behind: the path comes through glass.
    through = delta & (depth > 1)
    origin, glints = PathOrigin(previous, pdf, delta), _glints_of(tracing.glints, state.footprint)
    found = emitter_hit(tracing.loaded.emitters, pi, si, ray, origin, outside, glints, through)
    glossy, through_glass, any_traced = (
        mi.Color3f(state.glossy),
        mi.Bool(state.through_glass),
        shader.traced is not None,
    )
    if any_traced:
        found *= dr.select(through_glass, glossy, 1.0)
    L = state.L + beta * found

    shaded = outside & si.is_valid() & ~ends_paths(tracing.loaded.emitters, si, outside)
    if dr.hint(shaded, exclude=[scene, sampler, tracing]):
        before = depth - 1  # the surface's own depth: the loop has counted it
        bounce, fraction = _opaque_bounce(
            tracing, si, pi.prim_uv, ray, offset, path_dimensions(sampler, before), before == 0
        )
        L += beta * bounce.radiance
        if any_traced:
            glossy, through_glass = fraction, mi.Bool(False)
        beta *= bounce.weight
        ray, pdf, delta = leave(si, bounce.direction, offset), bounce.mis_pdf, bounce.delta
        medium = medium_after_bounce(medium, si, bounce.direction)
        beta, active = _russian_roulette(beta, eta_scale, depth >= rr_depth, hashed_seed(sampler, before))
        active &= depth < max_depth

    return replace(
        state,
        origin=ray.o,
        direction=ray.d,
        beta=beta,
        L=L,
        pdf=pdf,
        delta=delta,
        glossy=glossy,
        through_glass=through_glass,
        medium=medium,
        depth=depth,
        active=active,
    )


def _glints_of(glints: SunGlints | None, footprint: Footprint | None) -> SunGlints | None:
    """Return the sun as paths of a footprint find it."""
    if glints is None or footprint is None:
        return glints
    spread = footprint.d_u, footprint.d_v

    def of_footprint(radiance: mi.Color3f, direction: mi.Vector3f, _spread: Spread | None = None) -> mi.Color3f:
        return glints(radiance, direction, spread)

    return of_footprint


def _opaque_bounce(
    tracing: CachedTracing,
    si: mi.SurfaceInteraction3f,
    barycentric: mi.Point2f,
    ray: mi.Ray3f,
    offset: mi.Float,
    u: PathDimensions,
    direct: mi.Bool,
) -> tuple[Bounce, mi.Color3f]:
    """Shade opaque surfaces from the cache, and those that are path traced by emitter and BSDF sampling.

    The second value is `PathState.glossy`.
    """
    shader = tracing.shader
    cached = shade(shader, si, barycentric, ray, offset, u, direct)
    if shader.traced is None:  # the usual case has a kernel without the second kind
        return cached, mi.Color3f(1.0)
    return _traced_bounce(tracing.loaded, si, barycentric, ray, offset, u, direct, cached, shader.traced)


@syntax
def _traced_bounce(
    loaded: LoadedScene,
    si: mi.SurfaceInteraction3f,
    barycentric: mi.Point2f,
    ray: mi.Ray3f,
    offset: mi.Float,
    u: PathDimensions,
    direct: mi.Bool,
    cached: Bounce,
    surfaces: TracedSurfaces,
) -> tuple[Bounce, mi.Color3f]:
    """Replace the bounces of surfaces that are path traced."""
    bounce, glossy = cached, mi.Color3f(1.0)
    traced = dr.gather(mi.Bool, surfaces.rows, registry_id(si.shape))
    if dr.hint(traced, exclude=[loaded, surfaces]):
        bounce = opaque_event(loaded.emitters, si, ray, offset, u, loaded.surfaces, direct)
        stored, glossy = surfaces.caustics.shade(si, barycentric, ray, bounce)
        bounce.radiance = bounce.radiance + stored
    return bounce, glossy


def _russian_roulette(
    beta: mi.Color3f, eta_scale: mi.Float, applies: mi.Bool, bits: mi.UInt32
) -> tuple[mi.Color3f, mi.Bool]:
    """Apply Russian roulette where it `applies`; return the throughput of the survivors, and which paths survive."""
    survival = dr.select(applies, dr.minimum(dr.max(beta) * eta_scale, MAX_SURVIVAL), 1.0)
    return beta * dr.rcp(survival), dr.any(beta > 0.0) & (_hashed_number(bits, 1) < survival)


def rescaled_sample(
    u_rescaled: mi.Float, u_interval: mi.Float, probability: mi.Float, transmitted: mi.Bool, bits: mi.UInt32
) -> tuple[mi.Float, mi.Float]:
    """Return a path's number after it has sampled a lobe, rescaled to be uniform again, and its interval's length.

    Sample reuse: within the interval of the sampled lobe the number is uniform. An interval that is too short for
    float32 is replaced by a new number.
    """
    within = dr.select(transmitted, u_rescaled - (1.0 - probability), u_rescaled) / probability
    u_interval = u_interval * probability
    renew = u_interval < _MIN_INTERVAL
    within = dr.select(renew, _hashed_number(bits, 2), dr.clip(within, 0.0, 1.0 - 2.0**-24))
    return within, dr.select(renew, 1.0, u_interval)


def _hashed_number(bits: mi.UInt32, which: int) -> mi.Float:
    """Return one of the numbers in [0, 1) that follow from a hash (Wellons' triple32 without its last round)."""
    x = bits + mi.UInt32(which * 0x9E3779B9 & 0xFFFFFFFF)
    x = (x ^ (x >> 17)) * 0xED5AD4BB
    x = (x ^ (x >> 11)) * 0xAC4C1B51
    return mi.Float((x ^ (x >> 15)) >> 8) * 2.0**-24
