"""Path tracer with next-event estimation, MIS and Russian roulette; glass by the surface table, the rest by BSDFs.

Next-event estimation is called emitter sampling in Mitsuba. A path that hits an emitter by BSDF sampling and one that
samples it are combined by multiple importance sampling (MIS) with the balance heuristic (Veach 1997, eq. 9.8). A
segment is attenuated by the medium on the near side of the surface at its end (Beer-Lambert). In polarised variants all
spectra are Mueller matrices (`mueller`), and emitters are unpolarised. Stored caustics are for RGB variants only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from ...procedural.description.picture import Picture
from .._mitsuba import dr, mi, syntax
from ..interfaces.dielectric import InterfaceHit, Scattered, scatter
from ..interfaces.polarised import analyser_of, mueller_to_world, scatter_polarised
from ..scene.emitters import Emitters, emitted, emitter_pdf, ends_paths, sample_emitter, unoccluded
from ..scene.lighting import SunGlints
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.spectrum import hero_wavelength, to_output, unpolarised
from ..scene.surface_maps import MappedValues, above_surface, mapped_normal, values_at
from ..scene.surfaces import (
    AIR_INDEX,
    SurfaceMedia,
    SurfaceTable,
    broken_continuity,
    medium_after_bounce,
    medium_after_interface,
    medium_at_end,
    registry_id,
    surface_media,
)
from .emitter_candidates import candidates_of, chosen_candidate, per_candidate
from .sampler import SobolSampler, hashed_seed, sample_4d
from .simplified_optics import simplified_optics

#: Maximum survival probability of Russian roulette [1]; below 1, so that paths in lossless glass end.
MAX_SURVIVAL = 0.99


@dataclass(frozen=True, eq=False)
class Radiance:
    """The result of a wavefront of paths, one entry a path."""

    radiance: mi.Color3f
    #: 1 for a path with a segment whose medium is not the one on the near side of the surface at its end, else 0. (One
    #: that slipped through a crack into a painted bottle is reflected in it dozens of times.)
    violations: mi.UInt32
    segments: mi.UInt32
    #: In polarised variants s1, s2, s3 beside the radiance s0, in the frame with the x axis
    #: ``mi.mueller.stokes_basis(-ray.d)`` of the camera's ray; empty in other variants.
    polarisation: tuple[mi.Color3f, ...] = ()
    raw: mi.Color3f | None = None  #: response of the scene's sensor to the same light; None without one


@dataclass(frozen=True, eq=False)
class PathOrigin:
    """Where and how the direction of a path's last segment was sampled: what MIS weights emitter hits by."""

    previous: mi.Interaction3f  #: the point that the segment starts from
    pdf: mi.Float  #: density of the direction by solid angle, over the number of samples of emitter sampling
    delta: mi.Bool  #: whether emitter sampling could not have sampled it (camera, glass, Dirac lobes)


@dataclass(eq=False)  # not frozen: Dr.Jit assigns to the fields of loop state
class PathDimensions:
    """The sampler dimensions that one surface of a path consumes, each in [0, 1)."""

    u_emitter: mi.Point2f  #: emitter sampling
    u_bsdf: mi.Point2f  #: direction of BSDF sampling
    u_lobe: mi.Float  #: lobe of the BSDF, or reflection or refraction at an interface
    u_rr: mi.Float  #: Russian roulette


@dataclass(eq=False)  # not frozen: Dr.Jit assigns to the fields of loop state
class Bounce:
    """What an opaque surface adds to a path."""

    radiance: mi.Spectrum  #: outgoing radiance against the ray, without BSDF sampling
    direction: mi.Vector3f  #: the next segment, by BSDF sampling
    weight: mi.Spectrum  #: factor on the throughput
    pdf: mi.Float  #: density of the direction by solid angle
    delta: mi.Bool  #: whether the sampled lobe is a Dirac one
    u_emitter: mi.Point2f  #: sample point of emitter sampling
    candidates: mi.UInt32 | None  #: samples of emitter sampling that it was chosen from (`emitter_candidates`)

    @property
    def mis_pdf(self) -> mi.Float:
        """The density that the direction has in the MIS weight against one sample of emitter sampling."""
        return per_candidate(self.pdf, self.candidates)


#: Light through glass that is stored: takes a point on an opaque surface, its barycentric coordinates, the ray and the
#: sampled bounce; returns the radiance that the diffuse lobe adds, and the fraction of the bounce's weight that is due
#: to the glossy lobe. As a text, since `mi` has no types before a variant is set.
CausticShade: TypeAlias = (
    "Callable[[mi.SurfaceInteraction3f, mi.Point2f, mi.Ray3f, Bounce], tuple[mi.Color3f, mi.Color3f]]"
)


@dataclass(frozen=True, eq=False)
class StoredCaustics:
    """How paths find light through glass that they would find by chance alone."""

    shade: CausticShade
    glints: SunGlints | None = None  #: the sun as paths find it through glass; None: as it is


@syntax
def trace(
    loaded: LoadedScene,
    ray: mi.Ray3f,
    weight: mi.Spectrum,
    sampler: SobolSampler,
    picture: Picture,
    origin: PathOrigin | None = None,
    caustics: StoredCaustics | None = None,
) -> Radiance:
    """Trace one path for every ray, which starts in air, and return its radiance.

    The wavelengths have a `weight` (`draw_wavelengths`). Sets 0 and 1 of the sampler belong to the camera, the others
    are consumed here (`path_dimensions`). With an `origin`, emitter hits of the first segments are MIS-weighted too.
    With `caustics`, light that reaches a diffuse lobe through glass is read, not found; the origin counts as diffuse.
    Optics may be simplified (`simplified_optics`), some of them after the first opaque surface.
    """
    scene, table, emitters, carried = loaded.mi_scene, loaded.surfaces, loaded.emitters, mi.UnpolarizedSpectrum(weight)
    offset = dr.opaque(mi.Float, loaded.offset)
    max_depth, rr_depth = (dr.opaque(mi.UInt32, count) for count in (picture.max_depth, picture.rr_depth))
    ray, depth, medium = mi.Ray3f(ray), mi.UInt32(0), mi.UInt32(AIR_INDEX)  # medium of the segment by the last event
    L, beta = mi.Spectrum(0.0), mi.Spectrum(1.0)  # radiance so far, throughput
    eta_scale = mi.Float(1.0)  # product of eta^2, which Russian roulette must not count as loss
    previous, pdf, delta = _initial_origin(origin)  # fields of `PathOrigin`
    caustics_shade, glints = (None, None) if caustics is None else (caustics.shade, caustics.glints)
    meet, media_at, scattered = simplified_optics(loaded, interface_event)
    # With `caustics`: whether the segment has met glass since the last opaque surface, and its glossy fraction.
    coherent, through_glass, glossy = mi.Bool(origin is None), mi.Bool(False), mi.Color3f(float(origin is None))
    violations, segments, is_hero = mi.UInt32(0), mi.UInt32(0), mi.Bool(False)
    direct, active = mi.Bool(True), mi.Bool(True)  # direct: no opaque surface has been met

    while dr.hint(active, exclude=[table, scene, emitters, sampler, carried]):
        # (Camera rays alone are coherent: Embree takes three times as long for others that are said to be.)
        pi = meet(ray, coherent & (depth == 0), active, direct)
        si = pi.compute_surface_interaction(ray, mi.RayFlags.All, active)
        hit = active & si.is_valid()
        surface, medium = media_at(surface_media(table, si, ray, hit), medium, direct)
        violations, segments = violations + broken_continuity(surface, medium), segments + 1
        beta *= mi.Spectrum(table.transmittance(surface, si.wavelengths, active))
        medium = medium_at_end(surface, medium)

        found = mi.Spectrum(1.0) if caustics_shade is None else dr.select(through_glass, mi.Spectrum(glossy), 1.0)
        last = PathOrigin(previous, pdf, delta)
        L += beta * found * emitter_hit(emitters, pi, si, ray, last, active, glints, through_glass)
        active, u = hit & ~ends_paths(emitters, si, hit), path_dimensions(sampler, depth)
        direction, factor, pdf, delta = mi.Vector3f(0.0), mi.Spectrum(0.0), mi.Float(1.0), mi.Bool(True)
        if dr.hint(active & surface.opaque, exclude=[table, scene, emitters, sampler, carried]):
            bounce = opaque_event(emitters, si, ray, offset, u, table, depth == 0)
            direction, factor, pdf, delta = bounce.direction, bounce.weight, bounce.mis_pdf, bounce.delta
            medium, direct = medium_after_bounce(medium, si, direction), mi.Bool(False)
            L += beta * bounce.radiance
            if caustics_shade is not None:
                stored, glossy = caustics_shade(si, pi.prim_uv, ray, bounce)
                L += beta * stored
                through_glass = mi.Bool(False)
        if dr.hint(active & ~surface.opaque, exclude=[table, scene, emitters, sampler, carried]):
            interface = interface_hit(table, surface, ray, si.wavelengths, u.u_lobe, hashed_seed(sampler, depth))
            if picture.dispersion:  # from the first interface on the path follows its hero wavelength
                beta, is_hero = dr.select(is_hero, beta, hero_wavelength(beta)), mi.Bool(True)
            event = scattered(surface, interface, beta, si.wavelengths)
            direction, factor = event.direction, mi.Spectrum(event.weight)
            eta_scale, through_glass = eta_scale * event.eta_squared, mi.Bool(True)
            medium = medium_after_interface(medium, surface, event.transmitted)
        beta *= factor
        previous, ray, depth = mi.Interaction3f(si), leave(si, direction, offset), depth + 1
        survival = dr.select(depth >= rr_depth, survival_probability(beta, eta_scale), 1.0)
        active &= dr.any(unpolarised(beta) > 0.0) & (depth < max_depth) & (u.u_rr < survival)
        beta *= mi.Spectrum(dr.rcp(survival))

    s0, *others = to_output(L, carried, ray.wavelengths)
    return Radiance(s0, dr.minimum(violations, 1), segments, tuple(others), loaded.raw(L, carried, ray.wavelengths))


def _initial_origin(origin: PathOrigin | None) -> tuple[mi.Interaction3f, mi.Float, mi.Bool]:
    """Return the loop state of `PathOrigin`; without an origin that of a camera, where no emitter is sampled."""
    if origin is None:
        return dr.zeros(mi.Interaction3f), mi.Float(1.0), mi.Bool(True)
    return mi.Interaction3f(origin.previous), mi.Float(origin.pdf), mi.Bool(origin.delta)


def interface_hit(
    table: SurfaceTable, surface: SurfaceMedia, ray: mi.Ray3f, wavelengths: Any, u_lobe: mi.Float, seed: mi.UInt32
) -> InterfaceHit:
    """Return a ray at a dielectric interface, with the index and the roughness of pictures in the active variant."""
    eta = table.relative_index(surface, wavelengths)
    alpha = dr.gather(mi.Float, table.alpha, surface.row)
    return InterfaceHit(-ray.d, surface.n, surface.ns, eta, alpha, u_lobe, seed)


def interface_event(hit: InterfaceHit, beta: mi.Spectrum) -> Scattered:
    """Sample the scattering of a path with the throughput `beta` at an interface, polarised or not by the variant."""
    if mi.is_polarized:
        return scatter_polarised(hit, analyser_of(beta))
    return scatter(hit)


def path_dimensions(sampler: SobolSampler, depth: mi.UInt32) -> PathDimensions:
    """Return the sampler dimensions of the surface at a depth: sets 2 + 2 depth and 3 + 2 depth."""
    a, b, c, d = sample_4d(sampler, 2 + 2 * depth)
    u_lobe, u_rr, *_ = sample_4d(sampler, 3 + 2 * depth)
    return PathDimensions(mi.Point2f(a, b), mi.Point2f(c, d), u_lobe, u_rr)


def survival_probability(beta: mi.Spectrum, eta_scale: mi.Float) -> mi.Float:
    """Return the survival probability of Russian roulette: the throughput without its factors of eta^2."""
    return dr.minimum(dr.max(unpolarised(beta)) * eta_scale, MAX_SURVIVAL)


def balance_heuristic(pdf: mi.Float, other: mi.Float) -> mi.Float:
    """Return the MIS weight of a sample of density `pdf`, which another strategy has with `other` (Veach 1997, 9.8)."""
    return pdf / (pdf + other)


def emitter_hit(
    emitters: Emitters,
    pi: mi.PreliminaryIntersection3f,
    si: mi.SurfaceInteraction3f,
    ray: mi.Ray3f,
    origin: PathOrigin,
    active: mi.Bool,
    glints: SunGlints | None = None,
    through_glass: mi.Bool | None = None,
) -> mi.Spectrum:
    """Return the radiance of the emitter that BSDF sampling hit, with its MIS weight against emitter sampling.

    With `glints`, paths that come `through_glass` find the wide sun (`sun_glints`).
    """
    pdf = emitter_pdf(emitters, origin.previous, si, ray, ~origin.delta & active)
    mis_weight = dr.select(origin.delta, 1.0, balance_heuristic(origin.pdf, pdf))
    radiance = emitted(emitters, pi, si, ray, active)
    if glints is not None:
        radiance = dr.select(through_glass & ~si.is_valid(), glints(radiance, -si.wi), radiance)
    return dr.select(active, mi.Spectrum(mis_weight) * radiance, 0.0)


def two_sided(si: mi.SurfaceInteraction3f, ray: mi.Ray3f) -> mi.SurfaceInteraction3f:
    """Return the point with its shading frame flipped to the side that the ray comes from.

    Open meshes show both sides. Mitsuba's `twosided` adapter would compile every material twice.
    """
    flipped = mi.SurfaceInteraction3f(si)
    sign = dr.select(dr.dot(si.sh_frame.n, ray.d) > 0.0, mi.Float(-1.0), mi.Float(1.0))
    flipped.sh_frame.n, flipped.sh_frame.s = sign * si.sh_frame.n, sign * si.sh_frame.s
    flipped.wi = flipped.to_local(-ray.d)
    return flipped


def mapped_frame(si: mi.SurfaceInteraction3f, values: MappedValues, ray: mi.Ray3f) -> mi.SurfaceInteraction3f:
    """Return a point of `two_sided` with the shading frame of the maps."""
    frame = mi.Frame3f(mapped_normal(values, si, si.sh_frame.n, -ray.d))
    si.sh_frame = dr.select(values.mapped, frame, si.sh_frame)
    si.wi = si.to_local(-ray.d)
    return si


def opaque_event(
    emitters: Emitters,
    si: mi.SurfaceInteraction3f,
    ray: mi.Ray3f,
    offset: mi.Float,
    u: PathDimensions,
    table: SurfaceTable,
    direct: mi.Bool,
) -> Bounce:
    """Sample an emitter (next-event estimation) and the next direction at an opaque surface.

    Whether the eye sees it `direct` decides about the number of candidates (`candidates_of`).
    """
    bsdf, row, si = si.bsdf(ray), registry_id(si.shape), two_sided(si, ray)
    values = None if table.maps is None else values_at(table.maps, si, row)
    if values is not None:
        si = mapped_frame(si, values, ray)

    def reflected(at: mi.Point2f) -> mi.Float:
        ds, arriving = sample_emitter(emitters, si, at)
        value, pdf = bsdf.eval_pdf(mi.BSDFContext(), si, si.to_local(ds.d))
        found = unpolarised(value) * unpolarised(arriving) * emitter_weight(ds, pdf, count)
        above = mi.Bool(True) if values is None else above_surface(values, si, -ray.d, ds.d)
        return dr.select(above & (ds.pdf > 0.0), dr.max(found), 0.0)

    count = candidates_of(table.candidates, row, direct)
    chosen = chosen_candidate(u.u_emitter, u.u_rr, count, reflected)
    ds, arriving = sample_emitter(emitters, si, chosen.u)
    value, pdf, sampled, weight = bsdf.eval_pdf_sample(mi.BSDFContext(), si, si.to_local(ds.d), u.u_lobe, u.u_bsdf)
    lit = (ds.pdf > 0.0) & dr.any(unpolarised(value) > 0.0) & (chosen.weight > 0.0)
    arriving = unoccluded(emitters, si, (ds, arriving), offset, lit)
    mis_weight = chosen.weight * emitter_weight(ds, pdf, count)
    delta = mi.has_flag(sampled.sampled_type, mi.BSDFFlags.Delta)
    direction = si.to_world(sampled.wo)
    if values is not None:
        arriving = dr.select(above_surface(values, si, -ray.d, ds.d), arriving, 0.0)
        weight = dr.select(above_surface(values, si, -ray.d, direction), weight, 0.0)
    if mi.is_polarized:
        value = mueller_to_world(value, si, si.to_local(ds.d), ds.d, ray)
        weight = mueller_to_world(weight, si, sampled.wo, direction, ray)
    direct = dr.select(lit, mi.Spectrum(mis_weight) * value * arriving, 0.0)
    return Bounce(direct, direction, weight, sampled.pdf, delta, chosen.u, count)


def emitter_weight(ds: mi.DirectionSample3f, pdf: mi.Float, candidates: mi.UInt32 | None) -> mi.Float:
    """Return the MIS weight of one of a number of samples of emitter sampling, times that number."""
    return dr.select(ds.delta, 1.0, balance_heuristic(ds.pdf, per_candidate(pdf, candidates)))
