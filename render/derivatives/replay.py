"""Path replay: derivatives of the path tracer's radiance by absorption, roughness and emitters.

Path replay (Vicini, Speierer, Jakob 2021, "Path Replay Backpropagation", ACM TOG 40(4), algorithm 2): sample points are
hashes, so the same sampler gives the same path again, and the radiance that a path gathers after any vertex is its
total radiance, known from the first trace, minus what it has gathered so far. Nothing is stored along the path. The
replay checks itself: it returns the same radiance as `integrator.trace`.
"""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from ...procedural.description.scene import Picture
from ..interfaces.dielectric import InterfaceHit, consistent_normal, scatter
from ..pictures.integrator import (
    PathOrigin,
    emitter_hit,
    interface_hit,
    opaque_event,
    path_dimensions,
    survival_probability,
)
from ..pictures.sampler import SobolSampler, hashed_seed
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.surfaces import surface_media
from .tape import Tape, add_absorption, add_emitter, add_roughness, add_sampled_emitter
from .walk_score import walk_score


@dr.syntax
def replay(loaded: LoadedScene, ray: mi.Ray3f, sampler: SobolSampler, picture: Picture, tape: Tape) -> mi.Color3f:
    """Trace the paths of `integrator.trace` again and add up their derivatives on the tape; return their radiance.

    RGB variants only. The loop is that of `trace` and must equal it to the last bit. The survival probabilities of
    Russian roulette count as constants: the derivative is unbiased, as the radiance is.
    """
    scene, table = loaded.mi_scene, loaded.surfaces
    offset, max_depth = dr.opaque(mi.Float, loaded.offset), dr.opaque(mi.UInt32, picture.max_depth)
    rr_depth = dr.opaque(mi.UInt32, picture.rr_depth)

    ray, depth = mi.Ray3f(ray), mi.UInt32(0)
    L, beta, eta_scale = mi.Color3f(0.0), mi.Color3f(1.0), mi.Float(1.0)
    previous = dr.zeros(mi.Interaction3f)
    pdf, delta, active = mi.Float(1.0), mi.Bool(True), mi.Bool(True)

    while dr.hint(active, exclude=[table, scene, sampler, tape]):
        si = scene.ray_intersect(ray, mi.RayFlags.All, depth == 0, active)
        hit = active & si.is_valid()
        surface = surface_media(table, si, ray, hit)
        beta *= table.transmittance(surface, si.wavelengths, active)
        add_absorption(tape, surface.before, surface.distance, L, hit)

        emitted = beta * emitter_hit(scene, si, PathOrigin(previous, pdf, delta), active)
        L += emitted
        add_emitter(tape, si.emitter(scene, active), emitted, active)
        active = mi.Bool(hit)
        u = path_dimensions(sampler, depth)
        direction, weight, pdf, delta = mi.Vector3f(0.0), mi.Color3f(0.0), mi.Float(1.0), mi.Bool(True)

        if dr.hint(active & surface.opaque, exclude=[table, scene, sampler, tape]):
            bounce = opaque_event(scene, si, ray, offset, u)
            direction, weight, pdf, delta = bounce.direction, bounce.weight, bounce.pdf, bounce.delta
            L += beta * bounce.radiance
            add_sampled_emitter(tape, scene.sample_emitter(u.u_emitter.x)[0], beta * bounce.radiance)

        if dr.hint(active & ~surface.opaque, exclude=[table, scene, sampler, tape]):
            interface = interface_hit(table, surface, ray, si.wavelengths, u.u_lobe, hashed_seed(sampler, depth))
            event = scatter(interface)
            direction, weight = event.direction, mi.Color3f(event.weight)
            eta_scale *= event.eta_squared
            add_roughness(tape, table, surface, _score(interface), L, beta)

        beta *= weight
        previous = mi.Interaction3f(si)
        ray = leave(si, direction, offset)
        depth += 1
        survival = dr.select(depth >= rr_depth, survival_probability(beta, eta_scale), 1.0)
        active &= dr.any(beta > 0.0) & (depth < max_depth) & (u.u_rr < survival)
        beta *= dr.rcp(survival)

    return L


@dr.syntax
def _score(hit: InterfaceHit) -> mi.Float:
    """Return the score of the microsurface walk that `dielectric.scatter` takes; 0 where the interface is smooth."""
    score, wi, n, ns = mi.Float(0.0), hit.wi, hit.n, hit.ns
    eta, alpha, seed = hit.eta, hit.alpha, hit.seed
    if alpha > 0.0:
        score, _ = walk_score(mi.Frame3f(consistent_normal(wi, n, ns, eta)).to_local(wi), alpha, eta, seed)
    return score
