"""What is wrong with a pile, and which of its objects have to fall again for it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, combinations, product

import numpy as np

from ..description.bodies import GlassBody, SceneObject, liquid_solid
from ..description.edits import in_world, solid_of
from ..placement.overlap import ALLOWANCE, Solid, overlap
from ..placement.placement import CONTACT_GAP, inside
from ..placement.resting import turn_about_z
from .pile_state import Case, Run, tilt
from .world import contacts, place, poses, put_away

#: Depth below the table's top at which an object has left it [m].
_LOST = 0.05
#: Tilt at which a filled vessel is upset [rad], whatever follows.
_SPILT = 0.1
#: Height of a filled vessel over its place on the table, beyond the gap of contacts, that says that it stands on
#: something else [m].
_HIGH = 3e-4
#: Most that a filled vessel may lean at rest, as the way of its farthest point when it is made upright [m]: where an
#: object touches it, and where none is nearer than the sum of both gaps. No point crosses the gap. On soft contacts a
#: full bottle of four corners leans by a third of a milliradian.
_UPRIGHT, _UPRIGHT_ALONE = CONTACT_GAP, 2.0 * CONTACT_GAP


def is_spoilt(case: Case, there: np.ndarray, every: np.ndarray) -> bool:
    """Return whether an object has left the table, or a filled vessel is upset."""
    return bool((there[:, 2, 3] < -_LOST).any() or (every[case.filled, 2, 2] < np.cos(_SPILT)).any())


def take_away(run: Run, numbers: Sequence[int]) -> None:
    """Take objects out of the scene; what stood upright with a liquid and is upset stands again as it did."""
    upset = _upset(run.case, poses(run.world))
    for number in numbers:
        put_away(run.world, number)
        run.here.discard(number)
    for number in upset if numbers else ():
        place(run.world, number, run.standing[number])


def strays(run: Run) -> list[int]:
    """Return the objects that left the table, lie in a liquid, or have upset a filled vessel."""
    found, current = [], poses(run.world)
    upset = set(_upset(run.case, current))
    culprits = {one for pair in contacts(run.world) if upset & set(pair) for one in pair} & set(run.case.falls)
    middles = current[:, 2, 3]
    bodies = [(run.case.objects[i], current[i]) for i in run.case.filled]
    liquids = [
        in_world(liquid_solid(item), pose) for item, pose in bodies if isinstance(item, GlassBody) and item.liquid
    ]
    for number in sorted(run.here):
        lost = middles[number] < -_LOST or number in culprits or not _is_over_table(run.case, number, current[number])
        if not lost and number in run.case.falls and liquids:
            body = solid_of(run.case.objects[number].model_copy(update={"world_T_object": current[number]}))
            lost = any(_meet(body, liquid) for liquid in liquids)
        if lost:
            found.append(number)
    return found


def unsteady(run: Run, restless: np.ndarray) -> list[int]:
    """Return the objects that fell and do not come to rest, or those that keep others from it."""
    moving = set(np.flatnonzero(restless).tolist())
    touching = {one for pair in contacts(run.world) if moving & set(pair) for one in pair}
    return sorted(moving & set(run.case.falls)) or sorted(touching & set(run.case.falls))


def _upset(case: Case, current: np.ndarray) -> list[int]:
    return [number for number in case.filled if _leans(case, number, current[number])]


def _leans(case: Case, number: int, pose: np.ndarray) -> bool:
    """Return whether a vessel leans by more than can be made upright."""
    touched = any(number in pair and -1 not in pair for pair in contacts(case.world))
    way = tilt(pose) * float(np.ptp(case.bodies[number].parts.hull, axis=0).max())
    return way > (_UPRIGHT if touched else _UPRIGHT_ALONE)


def _is_over_table(case: Case, number: int, pose: np.ndarray) -> bool:
    """Return whether an object's centre of gravity is over the table, whose corners are round where it is."""
    centre = pose[:3, :3] @ np.array(case.bodies[number].mechanics.whole.centre_of_mass) + pose[:3, 3]
    return inside(centre[None, :2], case.board, 0.0)


def _meet(a: Solid, b: Solid) -> bool:
    """Return whether bodies have anything in common."""
    if (np.maximum(a.points.min(0), b.points.min(0)) > np.minimum(a.points.max(0), b.points.max(0))).any():
        return False
    return overlap(a, b) if a.exact is None or b.exact is None else not (a.exact ^ b.exact).is_empty()


def made_upright(case: Case, found: np.ndarray) -> str:
    """Make filled vessels exactly upright; return which one is not nearly so, or nothing."""
    for number in case.filled:
        pose = found[number].copy()
        standing = CONTACT_GAP - float(case.bodies[number].parts.hull[:, 2].min())
        if _leans(case, number, pose) or abs(pose[2, 3] - standing) > CONTACT_GAP + _HIGH:
            return f"upset {case.objects[number].name}, which is filled"
        found[number] = turn_about_z(float(np.arctan2(pose[1, 0], pose[0, 0])))
        found[number, :3, 3] = [*pose[:2, 3], standing]
    return ""


def lift_out_of_the_table(case: Case, found: np.ndarray) -> None:
    """Lift objects of which a point lies in the table, or nearer to it than half of `CONTACT_GAP`, by what they lack.

    Parts that are simulated cut off rounded edges of meshes: a vessel that leans would stand in the table by up to
    `ALLOWANCE`, and rays would leave its glass without meeting a surface of it.
    """
    for number, (item, parts) in enumerate(zip(case.objects, case.attached, strict=True)):
        bodies = [item.model_copy(update={"world_T_object": found[number]}), *placed_parts(parts, found[number])]
        lowest = min(float(solid_of(body).points[:, 2].min()) for body in bodies)
        if -ALLOWANCE < lowest < 0.5 * CONTACT_GAP:
            found[number, 2, 3] += CONTACT_GAP - lowest


def overlapping(case: Case, found: np.ndarray) -> tuple[str, list[int]]:
    """Return which objects overlap, in words or nothing, and by number those that fell and have to fall again.

    Measured on their meshes, not on the parts that were simulated. Of a pair the upper one falls again.
    """
    groups = [
        [item.model_copy(update={"world_T_object": pose}), *placed_parts(some, pose)]
        for item, some, pose in zip(case.objects, case.attached, found, strict=True)
    ]
    solids = [[(item.name, solid_of(item)) for item in group] for group in groups]
    fault, again = "", set()
    for first, second in combinations(range(len(solids)), 2):
        for (name, solid), (other, another) in product(solids[first], solids[second]):
            if overlap(solid, another):
                fault = f"left {name} in {other}"
                fell = [number for number in (first, second) if number in case.falls]
                again |= set(sorted(fell, key=lambda number: -found[number, 2, 3])[:1])
                break
    for name, solid in chain.from_iterable(solids):
        if solid.points[:, 2].min() < -ALLOWANCE:
            return f"left {name} in the table", []
    return fault, sorted(again)


def placed_parts(parts: Sequence[SceneObject], world_T_host: np.ndarray) -> list[SceneObject]:
    """Return parts with poses in the world, of parts with poses in the frame of the object that they move with."""
    return [part.model_copy(update={"world_T_object": world_T_host @ part.world_T_object}) for part in parts]
