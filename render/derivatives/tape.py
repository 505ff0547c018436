"""Tape of a path replay: sums of derivatives by parameter (slot), colour and path."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ..scene.loaded_scene import LoadedScene
from ..scene.surfaces import SurfaceMedia, SurfaceTable


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
