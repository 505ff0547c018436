"""Paths walked a second time: how their radiance changes with absorption, roughness and light.

Path replay (Vicini, Speierer, Jakob 2021, "Path Replay Backpropagation", ACM TOG 40(4), algorithm 2): sample points are
hashes, so the same points walk the same path again, and what a path still has to gather at any place on it is its whole
radiance, known from the first walk, less what it has gathered so far. Nothing is stored along the path. The replay is
also its own check: it gathers the same radiance as `integrator.trace`.
"""

from __future__ import annotations

from ...procedural.description.scene import Picture
from .._mitsuba import dr, mi, syntax
from ..interfaces.dielectric import scatter, upright_normal
from ..pictures.integrator import SURVIVE, numbers_of, opaque_event, ran_into, relative_index
from ..pictures.sampler import Samples, hashed
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.spectrum import absorption_at
from ..scene.surfaces import met, registry_id
from .tape import Tape, add_absorption, add_chosen, add_emitter, add_roughness
from .walk_score import walk_score


@syntax
def replay(kernel: LoadedScene, ray: mi.Ray3f, points: Samples, picture: Picture, into: Tape) -> mi.Color3f:
    """Walk the paths of `integrator.trace`, given the same, again; return their radiance and fill the tape.

    RGB variants only. The loop is that of `trace`, which this must follow to the last bit. The survival of roulette
    counts as given: the mean of the derivative is right, as the mean of the radiance is.
    """
    scene, table = kernel.mi_scene, kernel.surfaces
    offset, max_depth = dr.opaque(mi.Float, kernel.offset), dr.opaque(mi.UInt32, picture.max_depth)
    rr_depth = dr.opaque(mi.UInt32, picture.rr_depth)

    ray, depth = mi.Ray3f(ray), mi.UInt32(0)
    L, beta, eta_scale = mi.Color3f(0.0), mi.Color3f(1.0), mi.Float(1.0)
    previous = dr.zeros(mi.Interaction3f)
    pdf, delta, active = mi.Float(1.0), mi.Bool(True), mi.Bool(True)

    while dr.hint(active, exclude=[table, scene, points, into]):
        si = scene.ray_intersect(ray, mi.RayFlags.All, depth == 0, active)
        hit = active & si.is_valid()
        opaque, facing, beyond, n, ns = met(table, si, ray, hit)
        length = dr.select(hit, si.t, 0.0)
        beta *= dr.exp(-absorption_at(table.absorption, facing, si.wavelengths, active) * length)
        add_absorption(into, facing, length, L, hit)

        found = beta * ran_into(scene, si, previous, pdf, delta, active)
        L += found
        add_emitter(into, si.emitter(scene, active), found, active)
        active = mi.Bool(hit)
        light_at, lobe_at, coin, gamble = numbers_of(points, depth)
        direction, weight, pdf, delta = mi.Vector3f(0.0), mi.Color3f(0.0), mi.Float(1.0), mi.Bool(True)

        if dr.hint(active & opaque, exclude=[table, scene, points, into]):
            light, direction, weight, pdf, delta = opaque_event(scene, si, ray, offset, light_at, coin, lobe_at)
            L += beta * light
            add_chosen(into, scene.sample_emitter(light_at.x)[0], beta * light)

        if dr.hint(active & ~opaque, exclude=[table, scene, points, into]):
            row, seed = registry_id(si.shape), hashed(points, depth)
            eta, alpha = relative_index(table, facing, beyond, si.wavelengths), dr.gather(mi.Float, table.alpha, row)
            event = scatter(-ray.d, n, ns, eta, alpha, coin, seed)
            direction, weight = event.direction, mi.Color3f(event.weight)
            eta_scale *= event.eta_squared
            add_roughness(into, table, row, facing, _score(-ray.d, n, ns, eta, alpha, seed), L, beta)

        beta *= weight
        previous = mi.Interaction3f(si)
        ray = leave(si, direction, offset)
        depth += 1
        survive = dr.select(depth >= rr_depth, dr.minimum(dr.max(beta) * eta_scale, SURVIVE), 1.0)
        active &= dr.any(beta > 0.0) & (depth < max_depth) & (gamble < survive)
        beta *= dr.rcp(survive)

    return L


@syntax
def _score(
    wi: mi.Vector3f, n: mi.Normal3f, ns: mi.Normal3f, eta: mi.Float, alpha: mi.Float, seed: mi.UInt32
) -> mi.Float:
    """Return the score of the walk that `dielectric.scatter` takes; 0 where the interface is smooth."""
    score = mi.Float(0.0)
    if alpha > 0.0:
        score, _ = walk_score(mi.Frame3f(upright_normal(wi, n, ns, eta)).to_local(wi), alpha, eta, seed)
    return score
