"""Scenes whose props fall onto the table, on each other, and on, into and against vessels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...core.errors import InputError
from ...core.randomness import stream
from ..description.bodies import TABLE_ID, SceneObject, is_filled
from ..description.material import OpaqueMaterial
from ..description.rest import Rest, no_rest
from ..placement.placement import CONTACT_GAP, PlacementSettings, draw_positions
from ..placement.resting import turn_about_z
from .bodies import mechanics_of
from .bodies import with_attached as mechanics_with
from .falling import calm, fall
from .faults import is_spoilt, lift_out_of_the_table, made_upright, overlapping, strays, take_away, unsteady
from .parts import body_parts
from .parts import with_attached as parts_with
from .pile_state import Case, Run, outline_of
from .rest import comes_to_rest
from .settings import PhysicsSettings
from .substances import substance_of
from .world import RigidBody, build_world, contacts, is_broken, let_go, poses, restart

#: How often each object that falls may fall again on average [1] before the whole pile is drawn anew.
_FALLS_AGAIN = 1.5
#: Simulated time of all attempts after which a pile that nobody asked for is given up [s]: some 5 s of one core.
_LONGEST_UNASKED = 20.0
#: Growth of the disc after something left the table, which has to land nearer, and after something did not come to rest
#: or overlaps, which has to land where there is more room [1].
_NEARER, _WIDER = 0.8, 1.2


def pile_up(
    objects: Sequence[SceneObject],
    stands: Sequence[bool],
    board: np.ndarray,
    table: OpaqueMaterial,
    settings: PhysicsSettings,
    placement: PlacementSettings,
    seed: int,
    scene_id: int,
    attached: Mapping[str, Sequence[SceneObject]] | None = None,
) -> tuple[list[np.ndarray] | None, Rest]:
    """Return the poses of objects that came to rest after a fall, or None where no pile does.

    What stands is placed first, apart from each other, and held. The others fall one after another. Then everything is
    let go until it is at rest. What leaves the table, upsets a filled vessel, does not come to rest or is in another
    object falls again. A pile in which that happens again and again is drawn anew, from a stream of its own.

    Parameters
    ----------
    objects : sequence of SceneObject
        The objects; their poses are not used.
    stands : sequence of bool
        Which of them stand upright from the beginning.
    board : (k, 2) float
        Convex outline of the flat part of the table's top, counter-clockwise [m].
    table : OpaqueMaterial
        Its material.
    settings, placement, seed, scene_id : PhysicsSettings, PlacementSettings, int, int
        Of the scene.
    attached : mapping, optional
        Parts by the names of the objects that they move with; their poses are in those objects' frames.

    Returns
    -------
    list of (4, 4) float64 or None
        ``world_T_object`` of each; None where no attempt rests and piles are left to chance (`piled_probability` < 1).
    Rest
        How they came to rest.

    Raises
    ------
    InputError
        Where no attempt comes to rest and `piled_probability` is 1, or what stands does not fit on the table.
    """
    case = _case(objects, stands, board, table, settings, placement, attached or {})
    fault, unasked, seconds = "", settings.piled_probability < 1.0, 0.0
    for attempt in range(settings.attempts):
        run = _begun(case, stream(seed, scene_id, f"physics/{attempt}"))
        fault, found = _settled(run)
        if not fault:
            return [*found], _record(run, attempt)
        seconds += run.seconds
        if unasked and seconds > _LONGEST_UNASKED:
            return None, no_rest(attempt + 1)
    if unasked:
        return None, no_rest(settings.attempts)
    where, expected = "physics.attempts, physics.longest_time", "a pile that comes to rest in one of "
    raise InputError(where, f"{expected}{settings.attempts} attempts", f"none; the last one {fault}")


def _case(
    objects: Sequence[SceneObject],
    stands: Sequence[bool],
    board: np.ndarray,
    table: OpaqueMaterial,
    settings: PhysicsSettings,
    placement: PlacementSettings,
    attached: Mapping[str, Sequence[SceneObject]],
) -> Case:
    parts = [attached.get(item.name, ()) for item in objects]
    bodies = [
        RigidBody(parts_with(body_parts(item), some), mechanics_with(mechanics_of(item), some))
        for item, some in zip(objects, parts, strict=True)
    ]
    numbers = range(len(objects))
    return Case(
        objects=objects,
        bodies=bodies,
        falls=[number for number in numbers if not stands[number]],
        stands=[number for number in numbers if stands[number]],
        filled=[number for number in numbers if is_filled(objects[number])],
        board=board,
        settings=settings,
        placement=placement,
        attached=parts,
        world=build_world(bodies, board, substance_of(table).friction),
    )


def _begun(case: Case, rng: np.random.Generator) -> Run:
    """Begin an attempt: the vessels stand and everything else waits."""
    turned = {number: turn_about_z(rng.uniform(0.0, 2.0 * np.pi)) for number in case.stands}
    hulls = [body.parts.hull for body in case.bodies]
    outlines = [outline_of(hulls[number], turned[number]) for number in case.stands]
    shifts = draw_positions(outlines, case.board, case.placement, rng)
    for (number, pose), shift in zip(turned.items(), shifts, strict=True):
        pose[:3, 3] = [*shift, CONTACT_GAP - hulls[number][:, 2].min()]
    restart(case.world, [turned.get(number) for number in range(len(case.bodies))])
    angle, distance = rng.uniform(0.0, 2.0 * np.pi), case.placement.radius * np.sqrt(rng.random())
    return Run(
        case=case,
        rng=rng,
        centre=0.5 * distance * np.array([np.cos(angle), np.sin(angle)]),
        radius=float(rng.uniform(*case.settings.pile_radius)),
        standing=turned,
        here=set(case.stands),
    )


def _settled(run: Run) -> tuple[str, np.ndarray]:
    """Let everything fall and come to rest; return why it did not, or nothing, and the poses (n, 4, 4)."""
    case, world = run.case, run.world
    sizes = {number: np.ptp(case.bodies[number].parts.hull, axis=0).prod() for number in case.falls}
    # The large first, more or less, as people stack things.
    order = sorted(case.falls, key=lambda number: -sizes[number] * float(np.exp(run.rng.normal())))
    held = True
    while True:
        for number in order:
            fall(run, number)
            if is_broken(world):
                return "broke off", poses(world)
        if held:
            calm(run)
            for number in case.stands:
                let_go(world, number)
            held = False
        fault, order = _at_rest(run)
        found = poses(world)
        if not fault:
            fault = made_upright(case, found)
        if not fault:
            lift_out_of_the_table(case, found)
            fault, order = overlapping(case, found)
            run.radius *= _WIDER
        if not fault:
            return "", found
        run.fell_again += len(order)
        if not order or run.fell_again > _FALLS_AGAIN * len(case.falls) or set(order) & set(case.stands):
            return fault, found
        take_away(run, order)


def _at_rest(run: Run) -> tuple[str, list[int]]:
    """Simulate until all is at rest; return why it is not, or nothing, and which objects have to fall again."""
    case, world = run.case, run.world
    among = np.array([number in run.here for number in range(len(case.objects))])
    end = comes_to_rest(world, among, case.settings.longest_time, lambda now: is_spoilt(case, now[among], now))
    run.seconds, run.moved = run.seconds + end.seconds, end.moved
    if is_broken(world):
        return "broke off", []
    away = strays(run)
    if away:
        run.radius *= _NEARER
        first = case.objects[away[0]].name
        return f"lost {first} again and again, from the table, in a liquid or off a full vessel", away
    if end.still:
        return "", []
    run.radius *= _WIDER
    return f"still moved after {case.settings.longest_time:g} s", unsteady(run, end.restless)


def _record(run: Run, attempt: int) -> Rest:
    ids = {-1: TABLE_ID} | {number: item.id for number, item in enumerate(run.case.objects)}
    pairs = sorted(tuple(sorted((ids[first], ids[second]))) for first, second in contacts(run.world))
    return Rest(
        attempt=attempt + 1,
        fell_again=run.fell_again,
        seconds=round(run.seconds, 6),
        moved=run.moved,
        contacts=tuple((first, second) for first, second in pairs),
    )
