"""Scenes whose props fall onto the table, on each other, and on, into and against vessels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, combinations, product

import numpy as np

from ...core.errors import InputError
from ...core.randomness import stream
from ..description.bodies import TABLE_ID, GlassBody, SceneObject, liquid_solid
from ..description.edits import in_world, solid_of
from ..description.material import OpaqueMaterial
from ..description.rest import Rest, no_rest
from ..placement.overlap import ALLOWANCE, Solid, overlap
from ..placement.placement import CONTACT_GAP, PlacementSettings, apart, draw_positions, inside
from ..placement.resting import resting_turn, turn_about_z
from .bodies import mechanics_of
from .bodies import with_attached as mechanics_with
from .parts import body_parts
from .parts import with_attached as parts_with
from .rest import comes_to_rest
from .sections import hull
from .settings import PhysicsSettings
from .substances import substance_of
from .world import (
    FALL_STEP,
    RigidBody,
    World,
    advance,
    build_world,
    contacts,
    is_broken,
    let_go,
    place,
    poses,
    put_away,
    speeds,
)

#: Time between two props that fall [s]: the first has landed, or nearly so.
_INTERVAL = 0.15
#: Speed below which vessels that were held are let go [m/s], and the longest time until then [s].
_SLOW, _HOLD_TIME = 0.05, 2.0
#: Places tried for a prop before the disc grows, and its growth [1].
_TRIES, _GROWTH = 30, 1.2
#: How often each prop that leaves the table, or falls into a liquid, may fall again on average [1].
_FALLS_AGAIN = 0.5
#: Depth below the table's top at which an object has left it [m].
_LOST = 0.05
#: Tilt at which a filled vessel is upset [rad], whatever follows.
_SPILT = 0.1
#: Largest tilt of a filled vessel at rest [rad], which is then made upright: at a height of 0.3 m the rim moves by as
#: much as the gap of contacts.
_UPRIGHT = 3e-4
#: Fraction of props that begin to fall in a pose in which they could lie, and the tilt that they then have [rad].
_FLAT_FRACTION, _FLAT_TILT = 0.5, 0.15


@dataclass(frozen=True, eq=False)
class _Case:
    """What all attempts at a scene have in common."""

    objects: Sequence[SceneObject]
    bodies: list[RigidBody]
    falls: list[int]  #: numbers of the objects that fall
    stands: list[int]  #: numbers of those that stand from the beginning
    filled: list[int]
    board: np.ndarray
    friction: float
    settings: PhysicsSettings
    placement: PlacementSettings
    attached: list[Sequence[SceneObject]]  #: parts that move with each object, in its frame


@dataclass(eq=False)
class _Run:
    """An attempt under way."""

    case: _Case
    world: World
    rng: np.random.Generator
    centre: np.ndarray  #: of the disc over which props fall [m]
    radius: float
    fell_again: int = 0
    seconds: float = 0.0
    moved: float = 0.0
    standing: dict[int, np.ndarray] = field(default_factory=dict)  #: poses of vessels as they were placed
    here: set[int] = field(default_factory=set)  #: numbers of the objects that are in the scene


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
    let go until it is at rest. A pile that does not come to rest, upsets a filled vessel, or loses an object again and
    again is drawn anew, from a stream of its own.

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
    fault = ""
    for attempt in range(settings.attempts):
        rng = stream(seed, scene_id, f"physics/{attempt}")
        run, found = _begun(case, rng), np.empty((0, 4, 4))
        fault = _settled(run)
        if not fault:
            found = poses(run.world)
            fault = _upset(case, found) or _overlapping(case, found)
        if not fault:
            return [*np.asarray(found)], _record(run, attempt)
    if settings.piled_probability < 1.0:  # nobody asked for this pile
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
) -> _Case:
    parts = [attached.get(item.name, ()) for item in objects]
    bodies = [
        RigidBody(parts_with(body_parts(item), some), mechanics_with(mechanics_of(item), some))
        for item, some in zip(objects, parts, strict=True)
    ]
    numbers = range(len(objects))
    return _Case(
        objects=objects,
        bodies=bodies,
        falls=[number for number in numbers if not stands[number]],
        stands=[number for number in numbers if stands[number]],
        filled=[number for number in numbers if _is_filled(objects[number])],
        board=board,
        friction=substance_of(table).friction,
        settings=settings,
        placement=placement,
        attached=parts,
    )


def _is_filled(item: SceneObject) -> bool:
    return isinstance(item, GlassBody) and item.liquid is not None


def _begun(case: _Case, rng: np.random.Generator) -> _Run:
    """Return a world in which the vessels stand and everything else waits."""
    turned = {number: turn_about_z(rng.uniform(0.0, 2.0 * np.pi)) for number in case.stands}
    outlines = [_outline(case.bodies[number].parts.hull, turned[number]) for number in case.stands]
    shifts = draw_positions(outlines, case.board, case.placement, rng)
    bodies = list(case.bodies)
    for number, shift in zip(case.stands, shifts, strict=True):
        pose = turned[number]
        pose[:3, 3] = [*shift, CONTACT_GAP - bodies[number].parts.hull[:, 2].min()]
        bodies[number] = RigidBody(bodies[number].parts, bodies[number].mechanics, pose)
    angle, distance = rng.uniform(0.0, 2.0 * np.pi), case.placement.radius * np.sqrt(rng.random())
    return _Run(
        case=case,
        world=build_world(bodies, case.board, case.friction),
        rng=rng,
        centre=0.5 * distance * np.array([np.cos(angle), np.sin(angle)]),
        radius=float(rng.uniform(*case.settings.pile_radius)),
        standing={number: pose for number in case.stands if (pose := bodies[number].pose) is not None},
        here=set(case.stands),
    )


def _settled(run: _Run) -> str:
    """Let everything fall and come to rest; return why it did not, or nothing."""
    case, world = run.case, run.world
    sizes = {number: np.ptp(case.bodies[number].parts.hull, axis=0).prod() for number in case.falls}
    # The large first, more or less, as people stack things.
    order = sorted(case.falls, key=lambda number: -sizes[number] * float(np.exp(run.rng.normal())))
    held = True
    while True:
        for number in order:
            _fall(run, number)
            if is_broken(world):
                return "broke off"
        if held:
            _calm(run)
            for number in case.stands:
                let_go(world, number)
            held = False
        among = np.array([number in run.here for number in range(len(case.objects))])
        still, seconds, moved = comes_to_rest(
            world, among, case.settings.longest_time, lambda now, among=among: _is_spoilt(case, now[among], now)
        )
        run.seconds += seconds
        if is_broken(world):
            return "broke off"
        order = _strays(run)
        if not order:
            run.moved = moved
            return "" if still else f"still moved after {case.settings.longest_time:g} s"
        run.fell_again += len(order)
        if run.fell_again > _FALLS_AGAIN * max(len(case.falls), 1) or set(order) & set(case.stands):
            return (
                f"lost {case.objects[order[0]].name} again and again, from the table, in a liquid or off a full vessel"
            )
        run.radius *= 0.8


def _is_spoilt(case: _Case, there: np.ndarray, every: np.ndarray) -> bool:
    """Return whether an object has left the table, or a filled vessel is upset."""
    return bool((there[:, 2, 3] < -_LOST).any() or (every[case.filled, 2, 2] < np.cos(_SPILT)).any())


def _calm(run: _Run) -> None:
    """Simulate while the vessels are held, until what fell is slow."""
    numbers, time = [number for number in run.case.falls if number in run.here], 0.0
    while time < _HOLD_TIME and numbers and speeds(run.world)[numbers].max() > _SLOW:
        advance(run.world, _INTERVAL, FALL_STEP)
        time += _INTERVAL
    run.seconds += time


def _fall(run: _Run, number: int) -> None:
    """Let an object fall over the disc, from a height over what is below it."""
    hull_points = run.case.bodies[number].parts.hull
    pose = _tumbled(run.rng, hull_points)
    outline = _outline(hull_points, pose)
    shift = _spot(run, outline)
    below = 0.0
    for other, other_pose in enumerate(poses(run.world)):
        if other in run.here and other != number:
            points = run.case.bodies[other].parts.hull
            if not apart(_outline(points, other_pose), outline + shift, 0.0):
                below = max(below, float((points @ other_pose[2, :3]).max() + other_pose[2, 3]))
    height = run.rng.uniform(*run.case.settings.drop_height)
    pose[:3, 3] = [*shift, below + height - float((hull_points @ pose[2, :3]).min())]
    let_go(run.world, number, pose)
    run.here.add(number)
    advance(run.world, _INTERVAL, FALL_STEP)
    run.seconds += _INTERVAL


def _tumbled(rng: np.random.Generator, points: np.ndarray) -> np.ndarray:
    """Return a turn of an object that falls: any, or one in which it could nearly lie."""
    from scipy.spatial.transform import Rotation

    lies = rng.random() < _FLAT_FRACTION
    any_turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    tilt = Rotation.from_rotvec(_FLAT_TILT * rng.normal(size=3) / np.sqrt(3.0)).as_matrix()
    pose = np.eye(4)
    pose[:3, :3] = tilt @ resting_turn(points, rng)[:3, :3] if lies else any_turn
    return pose


def _spot(run: _Run, outline: np.ndarray) -> np.ndarray:
    """Return a place for an outline in the disc, on the table and over no filled vessel."""
    current = poses(run.world)
    mouths = [_outline(run.case.bodies[number].parts.hull, current[number]) for number in run.case.filled]
    radius, shift = run.radius, run.centre
    while radius < 2.0 * float(np.linalg.norm(run.case.board, axis=1).max()):
        for _ in range(_TRIES):
            angle, distance = run.rng.uniform(0.0, 2.0 * np.pi), radius * np.sqrt(run.rng.random())
            shift = run.centre + distance * np.array([np.cos(angle), np.sin(angle)])
            at = outline + shift
            if inside(at, run.case.board, 0.0) and all(apart(at, mouth, 0.0) for mouth in mouths):
                return shift
        radius = radius * _GROWTH + 0.005
    return shift


def _strays(run: _Run) -> list[int]:
    """Put away and return the objects that left the table, lie in a liquid, or have upset a filled vessel.

    Such a vessel is put upright again where it stood.
    """
    found, current = [], poses(run.world)
    touching = contacts(run.world)
    upset = [number for number in run.case.filled if _tilt(current[number]) > _UPRIGHT]
    culprits = {one for number in upset for pair in touching if number in pair for one in pair} & set(run.case.falls)
    middles = current[:, 2, 3]
    liquids = [in_world(liquid_solid(run.case.objects[i]), current[i]) for i in run.case.filled]  # pyright: ignore
    for number in sorted(run.here):
        lost = middles[number] < -_LOST or number in culprits or not _is_over_table(run.case, number, current[number])
        if not lost and number in run.case.falls and liquids:
            body = solid_of(run.case.objects[number].model_copy(update={"world_T_object": current[number]}))
            lost = any(_meet(body, liquid) for liquid in liquids)
        if lost:
            found.append(number)
            put_away(run.world, number)
            run.here.discard(number)
    if found:
        for number in upset:
            place(run.world, number, run.standing[number])
    return found


def _is_over_table(case: _Case, number: int, pose: np.ndarray) -> bool:
    """Return whether an object's centre of gravity is over the table, whose corners are round where it is."""
    centre = pose[:3, :3] @ np.array(case.bodies[number].mechanics.whole.centre_of_mass) + pose[:3, 3]
    return inside(centre[None, :2], case.board, 0.0)


def _tilt(pose: np.ndarray) -> float:
    """Return the angle of an object's z axis to the vertical [rad]."""
    return float(np.arctan2(np.hypot(*pose[:2, 2]), pose[2, 2]))


def _meet(a: Solid, b: Solid) -> bool:
    """Return whether bodies have anything in common."""
    if (np.maximum(a.points.min(0), b.points.min(0)) > np.minimum(a.points.max(0), b.points.max(0))).any():
        return False
    return overlap(a, b) if a.exact is None or b.exact is None else not (a.exact ^ b.exact).is_empty()


def _upset(case: _Case, found: np.ndarray) -> str:
    """Make filled vessels exactly upright; return which one is not nearly so, or nothing."""
    for number in case.filled:
        pose = found[number].copy()
        standing = CONTACT_GAP - float(case.bodies[number].parts.hull[:, 2].min())
        if _tilt(pose) > _UPRIGHT or abs(pose[2, 3] - standing) > CONTACT_GAP + _UPRIGHT:
            return f"upset {case.objects[number].name}, which holds a liquid"
        found[number] = turn_about_z(float(np.arctan2(pose[1, 0], pose[0, 0])))
        found[number, :3, 3] = [*pose[:2, 3], standing]
    return ""


def _overlapping(case: _Case, found: np.ndarray) -> str:
    """Return which objects overlap, or nothing: measured on their meshes, not on the parts that were simulated."""
    groups = [
        [item.model_copy(update={"world_T_object": pose}), *placed_parts(some, pose)]
        for item, some, pose in zip(case.objects, case.attached, found, strict=True)
    ]
    solids = [[(item.name, solid_of(item)) for item in group] for group in groups]
    for first, second in combinations(solids, 2):
        for (name, solid), (other, another) in product(first, second):
            if overlap(solid, another):
                return f"left {name} in {other}"
    for name, solid in chain.from_iterable(solids):
        if solid.points[:, 2].min() < -ALLOWANCE:
            return f"left {name} in the table"
    return ""


def placed_parts(parts: Sequence[SceneObject], world_T_host: np.ndarray) -> list[SceneObject]:
    """Return parts with poses in the world, of parts with poses in the frame of the object that they move with."""
    return [part.model_copy(update={"world_T_object": world_T_host @ part.world_T_object}) for part in parts]


def _record(run: _Run, attempt: int) -> Rest:
    ids = {-1: TABLE_ID} | {number: item.id for number, item in enumerate(run.case.objects)}
    pairs = sorted(tuple(sorted((ids[first], ids[second]))) for first, second in contacts(run.world))
    return Rest(
        attempt=attempt + 1,
        fell_again=run.fell_again,
        seconds=round(run.seconds, 6),
        moved=run.moved,
        contacts=tuple((first, second) for first, second in pairs),
    )


def _outline(points: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Return the convex outline of a body seen from above, (k, 2) [m]."""
    return hull(points @ pose[:2, :3].T + pose[:2, 3])
