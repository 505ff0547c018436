"""Where a replay of paths adds up derivatives: one slot a parameter, kept apart by colour and path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._mitsuba import dr, mi
from ..scene.loaded_scene import LoadedScene
from ..scene.surfaces import SurfaceTable


@dataclass(frozen=True, eq=False)
class Slots:
    """The parameters: media first, then rough surfaces, then emitters."""

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
    """What is known of each path before its replay, and what the replay finds."""

    total: mi.Color3f  #: its radiance
    #: A guess of its radiance that none of its walks had a part in. A score has mean 0, so scores may weigh what
    #: differs from the guess instead of all: the mean stays, the variance falls.
    guess: mi.Color3f
    #: For a medium d L / d sigma_a, the colours apart; for a rough surface d L / d alpha; for an emitter the radiance
    #: that comes from it. By slot, colour, path.
    sums: mi.Float
    where: Slots
    first_light: mi.UInt32
    lanes: mi.UInt32
    lane: mi.UInt32


def slots(kernel: LoadedScene) -> Slots:
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


def tape(where: Slots, total: mi.Color3f, guess: mi.Color3f) -> Tape:
    """Return an empty tape for paths of the given radiance, evaluated, and guesses of it."""
    lanes = dr.width(total)
    sums = dr.zeros(mi.Float, 3 * where.count * lanes)
    dr.eval(sums)
    first_light = dr.opaque(mi.UInt32, where.first_light)
    return Tape(total, guess, sums, where, first_light, dr.opaque(mi.UInt32, lanes), dr.arange(mi.UInt32, lanes))


def add_absorption(into: Tape, medium: mi.UInt32, length: mi.Float, L: mi.Color3f, active: mi.Bool) -> None:
    """Add for a segment: all that is gathered after `L` has passed it, so changes by minus its length."""
    _add(into, medium, -length * (into.total - L), active)


def add_roughness(
    into: Tape, table: SurfaceTable, row: mi.UInt32, medium: mi.UInt32, score: mi.Float, L: mi.Color3f, beta: mi.Color3f
) -> None:
    """Add for a walk on the interface `row`, met in `medium` with throughput `beta` after `L` was gathered.

    Radiance in a medium of index n is n^2 of that outside (Veach 1997, eq. 5.2), and so is the guess: in a white
    furnace it is what the path goes on to gather, and there is no variance.
    """
    guess = beta * dr.square(dr.gather(mi.Float, table.index, medium)) * into.guess
    rough = dr.gather(mi.Float, table.alpha, row) > 0.0
    _add(into, dr.gather(mi.UInt32, into.where.of_surface, row), score * (into.total - L - guess), rough)


def add_emitter(into: Tape, emitter: mi.EmitterPtr, light: mi.Color3f, active: mi.Bool) -> None:
    """Add light of the emitter that a path ran into; none where the pointer is null."""
    row = dr.reinterpret_array(mi.UInt32, emitter)
    _add(into, dr.gather(mi.UInt32, into.where.of_emitter, row, active), light, active & (row > 0))


def add_chosen(into: Tape, chosen: mi.UInt32, light: mi.Color3f) -> None:
    """Add light of the emitter that emitter sampling chose, by its place in the scene's list."""
    _add(into, into.first_light + chosen, light, mi.Bool(True))


def _add(into: Tape, slot: mi.UInt32, value: mi.Color3f, active: mi.Bool) -> None:
    # Each path has places of its own, so nothing is added twice at a time and the order of threads does not matter.
    for colour in range(3):
        at = (3 * slot + colour) * into.lanes + into.lane
        dr.scatter_add(into.sums, value[colour], at, active, mode=dr.ReduceMode.NoConflicts)
