"""Path replay: derivatives of the path tracer's radiance by absorption, roughness and emitters.

Path replay (Vicini, Speierer, Jakob 2021, "Path Replay Backpropagation", ACM TOG 40(4), algorithm 2): sample points are
hashes, so the same sampler gives the same path again, and the radiance that a path gathers after any vertex is its
total radiance, known from the first trace, minus what it has gathered so far. Nothing is stored along the path. The
replay checks itself: it returns the same radiance as `integrator.trace`.

Derivatives are added up on a tape, by parameter (slot), colour and path.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.description.picture import Picture
from .._mitsuba import dr, mi, syntax
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
from ..scene.emitters import ends_paths
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.surfaces import SurfaceMedia, SurfaceTable, surface_media
from .walk_score import walk_score


@dataclass(frozen=True, eq=False)
class Slots:
    """Slots of the differentiable parameters: media first, then rough surfaces, then emitters."""

    media: int
    rough: np.ndarray  #: rows of the surface table that are rough interfaces
    emitters: tuple[str, ...]  #: "environment" or the shape's id
    of_surface: mi.UInt32  #: slot by row of the surface table
    of_emitter: mi.UInt32  #: slot by registry id of the emitter

    @property
    def first_light(self) -> int:
        """Slot of the first emitter."""
        return self.media + len(self.rough)

    @property
    def count(self) -> int:
        """Number of parameters."""
        return self.first_light + len(self.emitters)


@dataclass(frozen=True, eq=False)
class Tape:
    """The radiance of each path before its replay, and the sums of its derivatives."""

    total: mi.Color3f  #: the path's radiance
    #: Control variate: an estimate of the path's radiance that is independent of its random walks. Scores have mean 0,
    #: so they may weight the difference from it instead of the radiance: the mean stays, the variance falls.
    baseline: mi.Color3f
    #: For a medium d L / d sigma_a, the colours apart; for a rough surface d L / d alpha; for an emitter the radiance
    #: that comes from it. By slot, colour, path.
    sums: mi.Float
    slots: Slots
    first_light: mi.UInt32
    lanes: mi.UInt32
    lane: mi.UInt32


def slots_of(loaded: LoadedScene) -> Slots:
    """Return the slots of a loaded scene."""
    table = loaded.surfaces
    rough = np.flatnonzero((np.array(table.alpha) > 0.0) & ~np.array(table.opaque))
    media, emitters = len(table.media), loaded.mi_scene.emitters()
    of_surface = np.zeros(dr.width(table.alpha), np.uint32)
    of_surface[rough] = media + np.arange(len(rough))
    ids = [int(dr.reinterpret_array(mi.UInt32, mi.EmitterPtr(emitter))[0]) for emitter in emitters]
    of_emitter = np.zeros(max(ids) + 1, np.uint32)
    of_emitter[ids] = media + len(rough) + np.arange(len(ids))
    names = tuple("environment" if emitter.is_environment() else emitter.get_shape().id() for emitter in emitters)
    found = Slots(media, rough, names, mi.UInt32(of_surface), mi.UInt32(of_emitter))
    dr.make_opaque(found.of_surface, found.of_emitter)
    return found


def empty_tape(slots: Slots, total: mi.Color3f, baseline: mi.Color3f) -> Tape:
    """Return an empty tape for paths of the given radiance, evaluated, and control variates for it."""
    lanes = dr.width(total)
    sums = dr.zeros(mi.Float, 3 * slots.count * lanes)
    dr.eval(sums)
    first_light = dr.opaque(mi.UInt32, slots.first_light)
    return Tape(total, baseline, sums, slots, first_light, dr.opaque(mi.UInt32, lanes), dr.arange(mi.UInt32, lanes))


def add_absorption(tape: Tape, medium: mi.UInt32, length: mi.Float, L: mi.Color3f, active: mi.Bool) -> None:
    """Add the derivative of a segment's Beer-Lambert factor: minus its length times the radiance gathered after `L`."""
    _add(tape, medium, -length * (tape.total - L), active)


def add_roughness(
    tape: Tape, table: SurfaceTable, surface: SurfaceMedia, score: mi.Float, L: mi.Color3f, beta: mi.Color3f
) -> None:
    """Add the derivative of a microsurface walk at throughput `beta`, after the radiance `L` was gathered.

    Radiance in a medium of index n is n^2 times the radiance outside (Veach 1997, eq. 5.2), so the baseline is scaled
    as well: in a white furnace it equals what the path gathers after the walk, and the variance is zero.
    """
    baseline = beta * dr.square(dr.gather(mi.Float, table.eta_render, surface.before)) * tape.baseline
    rough = dr.gather(mi.Float, table.alpha, surface.row) > 0.0
    slot = dr.gather(mi.UInt32, tape.slots.of_surface, surface.row)
    _add(tape, slot, score * (tape.total - L - baseline), rough)


def add_emitter(tape: Tape, emitter: mi.EmitterPtr, radiance: mi.Color3f, active: mi.Bool) -> None:
    """Add radiance of the emitter that a path hit; nothing where the pointer is null."""
    row = dr.reinterpret_array(mi.UInt32, emitter)
    _add(tape, dr.gather(mi.UInt32, tape.slots.of_emitter, row, active), radiance, active & (row > 0))


def add_sampled_emitter(tape: Tape, index: mi.UInt32, radiance: mi.Color3f) -> None:
    """Add radiance of the emitter that emitter sampling selected, by its position in the scene's list."""
    _add(tape, tape.first_light + index, radiance, mi.Bool(True))


def _add(tape: Tape, slot: mi.UInt32, value: mi.Color3f, active: mi.Bool) -> None:
    # Each path adds to separate elements, so there are no conflicts and the order of threads does not matter.
    for colour in range(3):
        at = (3 * slot + colour) * tape.lanes + tape.lane
        dr.scatter_add(tape.sums, value[colour], at, active, mode=dr.ReduceMode.NoConflicts)


@syntax
def replay(loaded: LoadedScene, ray: mi.Ray3f, sampler: SobolSampler, picture: Picture, tape: Tape) -> mi.Color3f:
    """Trace the paths of `integrator.trace` again and add up their derivatives on the tape; return their radiance.

    RGB variants only. The loop is that of `trace` and must equal it to the last bit. The survival probabilities of
    Russian roulette count as constants: the derivative is unbiased, as the radiance is.
    """
    scene, table, emitters = loaded.mi_scene, loaded.surfaces, loaded.emitters
    offset, max_depth = dr.opaque(mi.Float, loaded.offset), dr.opaque(mi.UInt32, picture.max_depth)
    rr_depth = dr.opaque(mi.UInt32, picture.rr_depth)

    ray, depth = mi.Ray3f(ray), mi.UInt32(0)
    L, beta, eta_scale = mi.Color3f(0.0), mi.Color3f(1.0), mi.Float(1.0)
    previous = dr.zeros(mi.Interaction3f)
    pdf, delta, active = mi.Float(1.0), mi.Bool(True), mi.Bool(True)

    while dr.hint(active, exclude=[table, scene, emitters, sampler, tape]):
        pi = scene.ray_intersect_preliminary(ray, depth == 0, active)
        si = pi.compute_surface_interaction(ray, mi.RayFlags.All, active)
        hit = active & si.is_valid()
        surface = surface_media(table, si, ray, hit)
        beta *= table.transmittance(surface, si.wavelengths, active)
        add_absorption(tape, surface.before, surface.distance, L, hit)

        emitted = beta * emitter_hit(emitters, pi, si, ray, PathOrigin(previous, pdf, delta), active)
        L += emitted
        add_emitter(tape, si.emitter(scene, active), emitted, active)
        active = hit & ~ends_paths(emitters, si, hit)
        u = path_dimensions(sampler, depth)
        direction, weight, pdf, delta = mi.Vector3f(0.0), mi.Color3f(0.0), mi.Float(1.0), mi.Bool(True)

        if dr.hint(active & surface.opaque, exclude=[table, scene, emitters, sampler, tape]):
            bounce = opaque_event(emitters, si, ray, offset, u, table, depth == 0)
            direction, weight, pdf, delta = bounce.direction, bounce.weight, bounce.mis_pdf, bounce.delta
            L += beta * bounce.radiance
            add_sampled_emitter(tape, scene.sample_emitter(bounce.u_emitter.x)[0], beta * bounce.radiance)

        if dr.hint(active & ~surface.opaque, exclude=[table, scene, emitters, sampler, tape]):
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


@syntax
def _score(hit: InterfaceHit) -> mi.Float:
    """Return the score of the microsurface walk that `dielectric.scatter` takes; 0 where the interface is smooth."""
    score, wi, n, ns = mi.Float(0.0), hit.wi, hit.n, hit.ns
    eta, alpha, seed = hit.eta, hit.alpha, hit.seed
    if alpha > 0.0:
        score, _ = walk_score(mi.Frame3f(consistent_normal(wi, n, ns, eta)).to_local(wi), alpha, eta, seed)
    return score
