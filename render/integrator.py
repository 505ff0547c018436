"""Path tracing through glass: interfaces from the surface table, opaque surfaces through Mitsuba's BSDFs."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ..procedural.description import Picture
from .dielectric import scatter
from .kernel import Kernel
from .rays import leave
from .sampler import Samples, four
from .surfaces import AIR_INDEX, registry_id


#: Shadow rays stop this share of the distance before the lamp, so as not to hit it.
_SHADOW_EPSILON = 1e-4


@dataclass(frozen=True, eq=False)
class Radiance:
    """What a bundle of paths brought back, one entry a path."""

    radiance: mi.Color3f
    albedo: mi.Color3f  #: guide: reflectance of the first rough surface, dimmed on the way there
    normal: mi.Normal3f  #: guide: its normal, world frame
    violations: mi.UInt32  #: segments whose medium was not the one that the next surface faced them with
    segments: mi.UInt32


@dr.syntax
def trace(kernel: Kernel, ray: mi.Ray3f, points: Samples, picture: Picture) -> Radiance:
    """Trace one path for every camera ray.

    Light is gathered by emitter sampling and BSDF sampling with the balance heuristic (Veach 1997, eq. 9.8). A segment
    is dimmed by the medium that the surface at its end faces it with (Beer-Lambert).

    Parameters
    ----------
    kernel : Kernel
        The loaded scene.
    ray : mi.Ray3f
        Camera rays, in air.
    points : Samples
        Sample points; set 0 is the camera's, the others are used here.
    picture : Picture
        Longest path and start of Russian roulette.
    """
    scene, table, offset = kernel.mi_scene, kernel.surfaces, mi.Float(kernel.offset)
    max_depth, rr_depth = mi.UInt32(picture.max_depth), mi.UInt32(picture.rr_depth)
    dr.make_opaque(offset, max_depth, rr_depth)

    # ---- Loop state ----
    ray = mi.Ray3f(ray)
    depth = mi.UInt32(0)
    L = mi.Color3f(0.0)  # radiance so far
    beta = mi.Color3f(1.0)  # throughput
    eta_scale = mi.Float(1.0)  # product of eta^2, which roulette must not take for loss
    previous = dr.zeros(mi.Interaction3f)  # where the last direction was sampled
    pdf = mi.Float(1.0)  # density of that direction
    delta = mi.Bool(True)  # whether emitter sampling could not have found it
    medium = mi.UInt32(AIR_INDEX)  # medium of the segment, by the events so far
    albedo, normal = mi.Color3f(0.0), mi.Normal3f(0.0)
    guided = mi.Bool(False)
    violations, segments = mi.UInt32(0), mi.UInt32(0)
    active = mi.Bool(True)

    while dr.hint(active, exclude=[table, scene, points]):
        si = scene.ray_intersect(ray, mi.RayFlags.All, depth == 0, active)
        row = registry_id(si.shape)
        hit = active & si.is_valid()
        from_front = dr.dot(si.n, ray.d) < 0.0
        opaque = dr.gather(mi.Bool, table.opaque, row, hit)
        front, back = dr.gather(mi.UInt32, table.front, row, hit), dr.gather(mi.UInt32, table.back, row, hit)
        facing, beyond = dr.select(from_front, front, back), dr.select(from_front, back, front)
        facing = dr.select(hit, facing, AIR_INDEX)
        segments += 1
        violations += dr.select(facing != medium, mi.UInt32(1), mi.UInt32(0))

        # ---- Absorption along the segment ----
        sigma_a = dr.gather(mi.Color3f, table.sigma_a, facing, active)
        beta *= dr.exp(-sigma_a * dr.select(hit, si.t, 0.0))

        # ---- Light that the path ran into ----
        emitter = si.emitter(scene, active)
        ds = mi.DirectionSample3f(scene, si, previous)
        emitter_pdf = scene.pdf_emitter_direction(previous, ds, ~delta & active)
        share = dr.select(delta, 1.0, pdf / (pdf + emitter_pdf))
        emitted = beta * emitter.eval(si, active)
        L += dr.select(active, share * emitted, 0.0)
        # The environment is its own guide: without it the denoiser would smear what glass shows of it.
        sky = active & ~hit & ~guided
        albedo = dr.select(sky, dr.minimum(emitted, 1.0), albedo)
        guided |= sky

        active = mi.Bool(hit)
        solid = active & opaque
        glass = active & ~opaque
        facing_normal = dr.select(from_front, si.sh_frame.n, -si.sh_frame.n)
        light_u, light_v, lobe_u, lobe_v = four(points, 1 + 2 * depth)
        coin, gamble, *_ = four(points, 2 + 2 * depth)

        # ---- Opaque surface: emitter sampling, then its BSDF ----
        direction, weight, pdf, delta = mi.Vector3f(0.0), mi.Color3f(0.0), mi.Float(1.0), mi.Bool(True)
        if dr.hint(solid, exclude=[table, scene, points]):
            light, bounce = _opaque(scene, si, ray, offset, mi.Point2f(light_u, light_v), coin, mi.Point2f(lobe_u, lobe_v))
            L += beta * light
            direction, weight, pdf, delta = bounce
            if dr.hint(~guided, exclude=[table, scene, points]):
                albedo = beta * si.bsdf().eval_diffuse_reflectance(si)
                normal = mi.Normal3f(facing_normal)
                guided = mi.Bool(True)

        # ---- Interface: Fresnel's coin ----
        if dr.hint(glass, exclude=[table, scene, points]):
            eta = dr.gather(mi.Float, table.eta, beyond) / dr.gather(mi.Float, table.eta, facing)
            alpha = dr.gather(mi.Float, table.alpha, row)
            n = dr.select(from_front, si.n, -si.n)
            event = scatter(-ray.d, n, facing_normal, eta, alpha, coin, mi.Point2f(lobe_u, lobe_v))
            direction, weight = event.direction, mi.Color3f(event.weight)
            eta_scale *= event.eta_squared
            facing = dr.select(event.transmitted, beyond, facing)

        # ---- On to the next segment ----
        beta *= weight
        medium = mi.UInt32(facing)
        previous = mi.Interaction3f(si)
        ray = leave(si, direction, offset)
        depth += 1
        active &= dr.any(beta > 0.0) & (depth < max_depth)

        # ---- Russian roulette ----
        survive = dr.minimum(dr.max(beta) * eta_scale, 0.95)
        gambling = depth >= rr_depth
        beta = dr.select(gambling, beta / survive, beta)
        active &= ~gambling | (gamble < survive)

    return Radiance(L, albedo, normal, violations, segments)


def _opaque(
    scene: mi.Scene,
    si: mi.SurfaceInteraction3f,
    ray: mi.Ray3f,
    offset: mi.Float,
    light: mi.Point2f,
    lobe: mi.Float,
    bounce: mi.Point2f,
) -> tuple[mi.Color3f, tuple[mi.Vector3f, mi.Color3f, mi.Float, mi.Bool]]:
    """Return the light by emitter sampling, and direction, weight, density and deltaness of the next bounce."""
    bsdf = si.bsdf(ray)
    ds, arriving = scene.sample_emitter_direction(si, light, False)
    value, pdf, sampled, weight = bsdf.eval_pdf_sample(mi.BSDFContext(), si, si.to_local(ds.d), lobe, bounce)
    lit = (ds.pdf > 0.0) & dr.any(value > 0.0)
    shadow = leave(si, ds.d, offset)
    shadow.maxt = ds.dist * (1.0 - _SHADOW_EPSILON)
    lit &= ~scene.ray_test(shadow, False, lit)
    share = dr.select(ds.delta, 1.0, ds.pdf / (ds.pdf + pdf))
    delta = mi.has_flag(sampled.sampled_type, mi.BSDFFlags.Delta)
    seen = dr.select(lit, share * value * arriving, 0.0)
    return seen, (si.to_world(sampled.wo), weight, sampled.pdf, delta)
