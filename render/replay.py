"""Paths walked a second time: how their radiance changes with absorption, roughness and light.

Path replay (Vicini, Speierer, Jakob 2021, "Path Replay Backpropagation", ACM TOG 40(4), algorithm 2): sample points are
hashes, so the same points walk the same path again, and what a path still has to gather at any place on it is its whole
radiance, known from the first walk, less what it has gathered so far. Nothing is stored along the path. The replay is
also its own check: it gathers the same radiance as `integrator.trace`.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ..procedural.description import Picture
from .dielectric import scatter, upright_normal
from .integrator import _SURVIVE, _numbers, _opaque, _ran_into, _relative_index, met
from .kernel import Kernel
from .rays import leave
from .sampler import Samples, hashed
from .spectrum import absorption_at
from .surfaces import registry_id
from .walk_score import walk_score


@dataclass(frozen=True, eq=False)
class Slots:
    """The parameters: media first, then rough surfaces, then emitters."""

    media: int
    rough: np.ndarray  #: rows of the surface table that are rough interfaces
    emitters: tuple[str, ...]  #: "environment" or the shape's id
    of_surface: mi.UInt32  #: slot by row of the surface table
    of_emitter: mi.UInt32  #: slot by registry id of the emitter

    @property
    def count(self) -> int:
        """Number of parameters."""
        return self.media + len(self.rough) + len(self.emitters)


@dataclass(frozen=True, eq=False)
class Tape:
    """Where the replay adds up, by slot, colour and path."""

    sums: mi.Float
    lanes: mi.UInt32
    lane: mi.UInt32


def slots(kernel: Kernel) -> Slots:
    """Return the slots of a loaded scene."""
    table = kernel.surfaces
    rough = np.flatnonzero((np.array(table.alpha) > 0.0) & ~np.array(table.opaque))
    media, emitters = len(table.media), kernel.mi_scene.emitters()
    of_surface = np.zeros(dr.width(table.alpha), np.uint32)
    of_surface[rough] = media + np.arange(len(rough))
    ids = [int(dr.reinterpret_array(mi.UInt32, mi.EmitterPtr(emitter))[0]) for emitter in emitters]
    of_emitter = np.zeros(max(ids) + 1, np.uint32)
    of_emitter[ids] = media + len(rough) + np.arange(len(ids))
    names = tuple("environment" if emitter.is_environment() else emitter.get_shape().id() for emitter in emitters)
    found = Slots(media, rough, names, mi.UInt32(of_surface), mi.UInt32(of_emitter))
    dr.make_opaque(found.of_surface, found.of_emitter)
    return found


def tape(count: int, lanes: int) -> Tape:
    """Return an empty tape of `count` slots for so many paths."""
    sums = dr.zeros(mi.Float, 3 * count * lanes)
    dr.eval(sums)
    return Tape(sums, dr.opaque(mi.UInt32, lanes), dr.arange(mi.UInt32, lanes))


def _add(into: Tape, slot: mi.UInt32, value: mi.Color3f, active: mi.Bool) -> None:
    # Each path has places of its own, so nothing is added twice at a time and the order of threads does not matter.
    for colour in range(3):
        at = (3 * slot + colour) * into.lanes + into.lane
        dr.scatter_add(into.sums, value[colour], at, active, mode=dr.ReduceMode.NoConflicts)


@dr.syntax
def replay(
    kernel: Kernel,
    ray: mi.Ray3f,
    points: Samples,
    picture: Picture,
    total: mi.Color3f,
    baseline: mi.Color3f,
    where: Slots,
    into: Tape,
) -> mi.Color3f:
    """Walk the paths of `integrator.trace` again and add the derivatives of their radiance to a tape; RGB variants.

    The survival of roulette counts as given: the mean of the derivative is right, as the mean of the radiance is.

    Parameters
    ----------
    kernel, ray, points, picture
        What `trace` was given.
    total : mi.Color3f
        The radiance that it returned.
    baseline : mi.Color3f
        A guess of each path's radiance that none of its walks had a part in. A score has mean 0, so scores may weigh
        what differs from the guess instead of all: the mean stays, the variance falls. Radiance in a medium of index n
        is n^2 of that outside, and so is the guess; in a white furnace the variance vanishes.
    where : Slots
        The parameters' places.
    into : Tape
        Takes, by slot: for a medium d L / d sigma_a, the colours apart; for a rough surface d L / d alpha; for an
        emitter the radiance that comes from it.

    Returns
    -------
    mi.Color3f
        The radiance, gathered again.
    """
    scene, table = kernel.mi_scene, kernel.surfaces
    offset, max_depth = dr.opaque(mi.Float, kernel.offset), dr.opaque(mi.UInt32, picture.max_depth)
    rr_depth, first_light = dr.opaque(mi.UInt32, picture.rr_depth), where.media + len(where.rough)

    ray, depth = mi.Ray3f(ray), mi.UInt32(0)
    L, beta, eta_scale = mi.Color3f(0.0), mi.Color3f(1.0), mi.Float(1.0)
    previous = dr.zeros(mi.Interaction3f)
    pdf, delta, active = mi.Float(1.0), mi.Bool(True), mi.Bool(True)

    while dr.hint(active, exclude=[table, scene, points, where, into, total, baseline]):
        si = scene.ray_intersect(ray, mi.RayFlags.All, depth == 0, active)
        hit = active & si.is_valid()
        opaque, facing, beyond, n, ns = met(table, si, ray, hit)
        length = dr.select(hit, si.t, 0.0)
        beta *= dr.exp(-absorption_at(table.absorption, facing, si.wavelengths, active) * length)
        _add(into, facing, -length * (total - L), hit)  # all that comes from here on has passed this segment

        found = beta * _ran_into(scene, si, previous, pdf, delta, active)
        lamp = dr.reinterpret_array(mi.UInt32, si.emitter(scene, active))
        L += found
        _add(into, dr.gather(mi.UInt32, where.of_emitter, lamp, active), found, active & (lamp > 0))
        active = mi.Bool(hit)
        light_at, lobe_at, coin, gamble = _numbers(points, depth)
        direction, weight, pdf, delta = mi.Vector3f(0.0), mi.Color3f(0.0), mi.Float(1.0), mi.Bool(True)

        if dr.hint(active & opaque, exclude=[table, scene, points, where, into, total, baseline]):
            light, direction, weight, pdf, delta = _opaque(scene, si, ray, offset, light_at, coin, lobe_at)
            L += beta * light
            chosen, _, _ = scene.sample_emitter(light_at.x)
            _add(into, first_light + chosen, beta * light, mi.Bool(True))

        if dr.hint(active & ~opaque, exclude=[table, scene, points, where, into, total, baseline]):
            row = registry_id(si.shape)
            eta, alpha = _relative_index(table, facing, beyond, si.wavelengths), dr.gather(mi.Float, table.alpha, row)
            event = scatter(-ray.d, n, ns, eta, alpha, coin, hashed(points, depth))
            direction, weight = event.direction, mi.Color3f(event.weight)
            eta_scale *= event.eta_squared
            score = _score(-ray.d, n, ns, eta, alpha, hashed(points, depth))
            guess = beta * dr.square(dr.gather(mi.Float, table.index, facing)) * baseline
            _add(into, dr.gather(mi.UInt32, where.of_surface, row), score * (total - L - guess), alpha > 0.0)

        beta *= weight
        previous = mi.Interaction3f(si)
        ray = leave(si, direction, offset)
        depth += 1
        survive = dr.select(depth >= rr_depth, dr.minimum(dr.max(beta) * eta_scale, _SURVIVE), 1.0)
        active &= dr.any(beta > 0.0) & (depth < max_depth) & (gamble < survive)
        beta *= dr.rcp(survive)

    return L


@dr.syntax
def _score(
    wi: mi.Vector3f, n: mi.Normal3f, ns: mi.Normal3f, eta: mi.Float, alpha: mi.Float, seed: mi.UInt32
) -> mi.Float:
    """Return the score of the walk that `dielectric.scatter` takes; 0 where the interface is smooth."""
    score = mi.Float(0.0)
    if alpha > 0.0:
        score, _ = walk_score(mi.Frame3f(upright_normal(wi, n, ns, eta)).to_local(wi), alpha, eta, seed)
    return score
