"""Path tracing through glass: interfaces from the surface table, opaque surfaces through Mitsuba's BSDFs."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ..procedural.description import Picture
from .dielectric import scatter
from .kernel import Kernel
from .rays import leave
from .surfaces import AIR_INDEX, registry_id


@dataclass(frozen=True, eq=False)
class Radiance:
    """What a bundle of paths brought back, one entry a path."""

    radiance: mi.Color3f
    albedo: mi.Color3f  #: guide: reflectance of the first rough surface, dimmed on the way there
    normal: mi.Normal3f  #: guide: its normal, world frame
    violations: mi.UInt32  #: segments whose medium was not the one that the next surface faced them with
    segments: mi.UInt32


@dr.syntax
def trace(kernel: Kernel, ray: mi.Ray3f, sampler: mi.Sampler, picture: Picture) -> Radiance:
    """Trace one path for every camera ray.

    Light is gathered by emitter sampling and BSDF sampling with the balance heuristic (Veach 1997, eq. 9.8). A segment
    is dimmed by the medium that the surface at its end faces it with (Beer-Lambert).

    Parameters
    ----------
    kernel : Kernel
        The loaded scene.
    ray : mi.Ray3f
        Camera rays, in air.
    sampler : mi.Sampler
        Seeded for the size of the wavefront.
    picture : Picture
        Longest path and start of Russian roulette.
    """
    scene, table, offset = kernel.mi_scene, kernel.surfaces, mi.Float(kernel.offset)
    max_depth, rr_depth = mi.UInt32(picture.max_depth), mi.UInt32(picture.rr_depth)
    dr.make_opaque(offset, max_depth, rr_depth)
    context = mi.BSDFContext()

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

    while dr.hint(active, exclude=[table, scene]):
        si = scene.ray_intersect(ray, mi.RayFlags.All, depth == 0, active)
        row = registry_id(si.shape)
        hit = si.is_valid()
        from_front = dr.dot(si.n, ray.d) < 0.0
        opaque = dr.gather(mi.Bool, table.opaque, row, hit)
        front, back = dr.gather(mi.UInt32, table.front, row, hit), dr.gather(mi.UInt32, table.back, row, hit)
        facing, beyond = dr.select(from_front, front, back), dr.select(from_front, back, front)
        facing = dr.select(hit, facing, AIR_INDEX)
        segments += 1
        violations += dr.select(facing != medium, mi.UInt32(1), mi.UInt32(0))

        # ---- Absorption along the segment ----
        sigma_a = dr.gather(mi.Color3f, table.sigma_a, facing, active)
        beta *= dr.select(hit, dr.exp(-sigma_a * dr.select(hit, si.t, 0.0)), 1.0)

        # ---- Light that the path ran into ----
        emitter = si.emitter(scene)
        ds = mi.DirectionSample3f(scene, si, previous)
        emitter_pdf = scene.pdf_emitter_direction(previous, ds, ~delta & active)
        share = dr.select(delta, 1.0, pdf / (pdf + emitter_pdf))
        emitted = beta * emitter.eval(si, active)
        L += dr.select(active, share * emitted, 0.0)
        # The environment is its own guide: without it the denoiser would smear what glass shows of it.
        sky = active & ~hit & ~guided
        albedo = dr.select(sky, dr.minimum(emitted, 1.0), albedo)
        guided |= sky

        active &= hit
        glass = active & ~opaque
        solid = active & opaque

        # ---- Opaque surface: emitter sampling, then its BSDF ----
        bsdf = si.bsdf(ray)
        u1, u2, u3, u4 = (
            sampler.next_1d(active),
            sampler.next_2d(active),
            sampler.next_2d(active),
            sampler.next_1d(active),
        )
        ds, arriving = scene.sample_emitter_direction(si, u2, False, solid)
        wo = si.to_local(ds.d)
        value, bsdf_pdf, sampled, sampled_value = bsdf.eval_pdf_sample(context, si, wo, u1, u3, solid)
        lit = solid & (ds.pdf > 0.0) & dr.any(value > 0.0)
        shadow = leave(si, ds.d, offset)
        shadow.maxt = dr.select(dr.isfinite(ds.dist), ds.dist * (1.0 - 1e-4), dr.largest(mi.Float))
        lit &= ~scene.ray_test(shadow, False, lit)
        share = dr.select(ds.delta, 1.0, ds.pdf / (ds.pdf + bsdf_pdf))
        L += dr.select(lit, share * beta * value * arriving, 0.0)

        rough_normal = dr.select(from_front, si.sh_frame.n, -si.sh_frame.n)
        reflectance = bsdf.eval_diffuse_reflectance(si, solid)
        guide_here = solid & ~guided
        albedo = dr.select(guide_here, beta * reflectance, albedo)
        normal = dr.select(guide_here, rough_normal, normal)
        guided |= guide_here

        # ---- Interface: Fresnel's coin ----
        eta_facing = dr.gather(mi.Float, table.eta, facing, glass)
        eta_beyond = dr.gather(mi.Float, table.eta, beyond, glass)
        alpha = dr.gather(mi.Float, table.alpha, row, glass)
        n = dr.select(from_front, si.n, -si.n)
        event = scatter(-ray.d, n, rough_normal, eta_beyond / eta_facing, alpha, u1, u3)

        # ---- On to the next segment ----
        beta *= dr.select(glass, mi.Color3f(event.weight), sampled_value)
        direction = dr.select(glass, event.direction, si.to_world(sampled.wo))
        eta_scale *= dr.select(glass, event.eta_squared, 1.0)
        medium = dr.select(glass & event.transmitted, beyond, facing)
        pdf = dr.select(glass, 1.0, sampled.pdf)
        delta = dr.select(glass, True, mi.has_flag(sampled.sampled_type, mi.BSDFFlags.Delta))
        previous = mi.Interaction3f(si)
        ray = leave(si, direction, offset)
        depth += 1
        active &= dr.any(beta > 0.0) & (depth < max_depth)

        # ---- Russian roulette ----
        survive = dr.minimum(dr.max(beta) * eta_scale, 0.95)
        gamble = depth >= rr_depth
        beta = dr.select(gamble, beta / survive, beta)
        active &= ~gamble | (u4 < survive)

    return Radiance(L, albedo, normal, violations, segments)
