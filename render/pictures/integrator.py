"""Path tracing through glass: interfaces from the surface table, opaque surfaces through Mitsuba's BSDFs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...procedural.description.scene import Picture
from .._mitsuba import dr, mi, syntax
from ..interfaces.dielectric import Scattered, scatter
from ..interfaces.polarised import analyser_of, in_world, scatter_polarised
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.spectrum import absorption_at, first_only, index_at, seen, unpolarised
from ..scene.surfaces import AIR_INDEX, SurfaceTable, met, registry_id
from .sampler import Samples, four, hashed

#: Shadow rays stop this share of the distance before the lamp, so as not to hit it.
_SHADOW_EPSILON = 1e-4
#: Most that roulette lets a path hope for; below 1, so that a path in lossless glass ends.
SURVIVE = 0.99


@dataclass(frozen=True, eq=False)
class Radiance:
    """What a bundle of paths brought back, one entry a path."""

    radiance: mi.Color3f
    violations: mi.UInt32  #: segments whose medium was not the one that the next surface faced them with
    segments: mi.UInt32
    #: In polarised variants s1, s2, s3 beside the radiance s0, in the frame with the x axis
    #: ``mi.mueller.stokes_basis(-ray.d)`` of the camera's ray; else nothing.
    polarisation: tuple[mi.Color3f, ...] = ()


@dataclass(frozen=True, eq=False)
class Start:
    """Where paths start, when it is not at a camera: lamps could have been sampled there, and are weighted so."""

    previous: mi.Interaction3f
    pdf: mi.Float  #: density that the direction was drawn with, by solid angle


@syntax
def trace(
    kernel: LoadedScene,
    ray: mi.Ray3f,
    weight: mi.Spectrum,
    points: Samples,
    picture: Picture,
    start: Start | None = None,
) -> Radiance:
    """Trace one path for every camera ray.

    Light is gathered by emitter sampling and BSDF sampling with the balance heuristic (Veach 1997, eq. 9.8). A segment
    is dimmed by the medium that the surface at its end faces it with (Beer-Lambert). Rays start in air; `weight` comes
    from `draw_wavelengths`. Sets 0 and 1 of the sample points are the camera's, the others are used here. In polarised
    variants all spectra are Mueller matrices (`mueller`), and lamps and sky are unpolarised.
    """
    scene, table, carried = kernel.mi_scene, kernel.surfaces, mi.UnpolarizedSpectrum(weight)
    offset, max_depth = dr.opaque(mi.Float, kernel.offset), dr.opaque(mi.UInt32, picture.max_depth)
    rr_depth = dr.opaque(mi.UInt32, picture.rr_depth)

    # ---- Loop state ----
    ray, depth, medium = mi.Ray3f(ray), mi.UInt32(0), mi.UInt32(AIR_INDEX)  # the segment's medium, by events so far
    L, beta = mi.Spectrum(0.0), mi.Spectrum(1.0)  # radiance so far, throughput
    eta_scale = mi.Float(1.0)  # product of eta^2, which roulette must not take for loss
    # Where the last direction was sampled, its density, and whether emitter sampling could not have found it.
    previous, pdf, delta = _beginning(start)
    violations, segments, alone, active = mi.UInt32(0), mi.UInt32(0), mi.Bool(False), mi.Bool(True)

    while dr.hint(active, exclude=[table, scene, points, carried]):
        si = scene.ray_intersect(ray, mi.RayFlags.All, depth == 0, active)
        hit = active & si.is_valid()
        opaque, facing, beyond, n, ns = met(table, si, ray, hit)
        segments += 1
        violations += dr.select(facing != medium, mi.UInt32(1), mi.UInt32(0))
        sigma_a = absorption_at(table.absorption, facing, si.wavelengths, active)
        beta *= mi.Spectrum(dr.exp(-sigma_a * dr.select(hit, si.t, 0.0)))

        L += beta * ran_into(scene, si, previous, pdf, delta, active)
        active = mi.Bool(hit)
        light_at, lobe_at, coin, gamble = numbers_of(points, depth)
        direction, factor, pdf, delta = mi.Vector3f(0.0), mi.Spectrum(0.0), mi.Float(1.0), mi.Bool(True)

        if dr.hint(active & opaque, exclude=[table, scene, points, carried]):
            light, direction, factor, pdf, delta = opaque_event(scene, si, ray, offset, light_at, coin, lobe_at)
            L += beta * light

        if dr.hint(active & ~opaque, exclude=[table, scene, points, carried]):
            eta = relative_index(table, facing, beyond, si.wavelengths)
            alpha = dr.gather(mi.Float, table.alpha, registry_id(si.shape))
            if picture.dispersion:  # from here on the path follows its first wavelength
                beta = dr.select(alone, beta, first_only(beta))
                alone = mi.Bool(True)
            event = interface_event(-ray.d, n, ns, eta, alpha, coin, hashed(points, depth), beta)
            direction, factor = event.direction, mi.Spectrum(event.weight)
            eta_scale *= event.eta_squared
            facing = dr.select(event.transmitted, beyond, facing)

        # ---- On to the next segment, if roulette lets it ----
        beta *= factor
        medium, previous = mi.UInt32(facing), mi.Interaction3f(si)
        ray = leave(si, direction, offset)
        depth += 1
        survive = dr.select(depth >= rr_depth, dr.minimum(dr.max(unpolarised(beta)) * eta_scale, SURVIVE), 1.0)
        active &= dr.any(unpolarised(beta) > 0.0) & (depth < max_depth) & (gamble < survive)
        beta *= mi.Spectrum(dr.rcp(survive))

    s0, *others = seen(L, carried, ray.wavelengths)
    return Radiance(s0, violations, segments, tuple(others))


def _beginning(start: Start | None) -> tuple[mi.Interaction3f, mi.Float, mi.Bool]:
    """Return the state that paths begin with: at a camera no lamp could have been sampled."""
    if start is None:
        return dr.zeros(mi.Interaction3f), mi.Float(1.0), mi.Bool(True)
    return mi.Interaction3f(start.previous), mi.Float(start.pdf), mi.Bool(False)


def interface_event(
    wi: mi.Vector3f,
    n: mi.Normal3f,
    ns: mi.Normal3f,
    eta: mi.Float,
    alpha: mi.Float,
    coin: mi.Float,
    seed: mi.UInt32,
    beta: mi.Spectrum,
) -> Scattered:
    """Return what an interface does to a path with the throughput `beta`, by the law of the active variant."""
    if mi.is_polarized:
        return scatter_polarised(wi, n, ns, eta, alpha, coin, seed, analyser_of(beta))
    return scatter(wi, n, ns, eta, alpha, coin, seed)


def numbers_of(points: Samples, depth: mi.UInt32) -> tuple[mi.Point2f, mi.Point2f, mi.Float, mi.Float]:
    """Return the random numbers of one surface: lamp, direction, lobe or Fresnel's coin, roulette."""
    a, b, c, d = four(points, 2 + 2 * depth)
    coin, gamble, *_ = four(points, 3 + 2 * depth)
    return mi.Point2f(a, b), mi.Point2f(c, d), coin, gamble


def relative_index(table: SurfaceTable, facing: mi.UInt32, beyond: mi.UInt32, wavelengths: Any) -> mi.Float:
    """Return the index behind an interface over the index before it, for pictures in the active variant."""
    behind = index_at(table.index, beyond, wavelengths, mi.Bool(True))
    return behind / index_at(table.index, facing, wavelengths, mi.Bool(True))


def ran_into(
    scene: mi.Scene,
    si: mi.SurfaceInteraction3f,
    previous: mi.Interaction3f,
    pdf: mi.Float,
    delta: mi.Bool,
    active: mi.Bool,
) -> mi.Spectrum:
    """Return the light of the lamp or the sky that the path ran into, weighted against emitter sampling."""
    emitter = si.emitter(scene, active)
    ds = mi.DirectionSample3f(scene, si, previous)
    emitter_pdf = scene.pdf_emitter_direction(previous, ds, ~delta & active)
    share = dr.select(delta, 1.0, pdf / (pdf + emitter_pdf))
    return dr.select(active, mi.Spectrum(share) * emitter.eval(si, active), 0.0)


def _two_sided(si: mi.SurfaceInteraction3f, ray: mi.Ray3f) -> mi.SurfaceInteraction3f:
    """Return the point with its shading frame turned to the side that the ray comes from.

    Open meshes show both sides. Mitsuba's adapter for that would compile every material twice.
    """
    turned = mi.SurfaceInteraction3f(si)
    sign = dr.select(dr.dot(si.sh_frame.n, ray.d) > 0.0, mi.Float(-1.0), mi.Float(1.0))
    turned.sh_frame.n, turned.sh_frame.s = sign * si.sh_frame.n, sign * si.sh_frame.s
    turned.wi = turned.to_local(-ray.d)
    return turned


def unshadowed(
    scene: mi.Scene, si: mi.SurfaceInteraction3f, ds: mi.DirectionSample3f, offset: mi.Float, lit: mi.Bool
) -> mi.Bool:
    """Return where nothing stands between the point and the lamp that was sampled, of where that is asked."""
    shadow = leave(si, ds.d, offset)
    shadow.maxt = ds.dist * (1.0 - _SHADOW_EPSILON)
    return lit & ~scene.ray_test(shadow, False, lit)


def opaque_event(
    scene: mi.Scene,
    si: mi.SurfaceInteraction3f,
    ray: mi.Ray3f,
    offset: mi.Float,
    light: mi.Point2f,
    lobe: mi.Float,
    bounce: mi.Point2f,
) -> tuple[mi.Spectrum, mi.Vector3f, mi.Spectrum, mi.Float, mi.Bool]:
    """Return the light by emitter sampling, and direction, weight, density and deltaness of the next bounce."""
    bsdf, si = si.bsdf(ray), _two_sided(si, ray)
    ds, arriving = scene.sample_emitter_direction(si, light, False)
    value, pdf, sampled, weight = bsdf.eval_pdf_sample(mi.BSDFContext(), si, si.to_local(ds.d), lobe, bounce)
    lit = (ds.pdf > 0.0) & dr.any(unpolarised(value) > 0.0)
    lit = unshadowed(scene, si, ds, offset, lit)
    share = dr.select(ds.delta, 1.0, ds.pdf / (ds.pdf + pdf))
    delta = mi.has_flag(sampled.sampled_type, mi.BSDFFlags.Delta)
    direction = si.to_world(sampled.wo)
    if mi.is_polarized:
        value = in_world(value, si, si.to_local(ds.d), ds.d, ray)
        weight = in_world(weight, si, sampled.wo, direction, ray)
    return dr.select(lit, mi.Spectrum(share) * value * arriving, 0.0), direction, weight, sampled.pdf, delta
