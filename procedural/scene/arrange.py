"""Where the objects of a scene are: standing apart from each other, or in a pile."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...core.mesh import Mesh
from ...core.randomness import stream
from ..description.bodies import is_filled
from ..description.rest import Rest
from ..description.scene import FIRST_OBJECT_ID, MeshVessel, Prop, SceneObject, Vessel
from ..description.surroundings import Table
from ..physics.bodies import mechanics_of
from ..physics.faults import placed_parts
from ..physics.piles import pile_up
from ..physics.sections import hull
from ..placement.placement import CONTACT_GAP, crowded, find_positions, footprint
from ..placement.resting import lowered, resting_pose, resting_turn, turn_about_z
from ..surroundings.table import outline
from ..things.draw import prop_pose
from .draw_vessels import Parts, group_mesh, lies
from .settings import SceneSettings
from .supports import put_on_carriers

#: Least angle between the axis of a vessel that lies and the vertical [rad]: it lies on its side or on a corner of its
#: foot and its rim, and neither stands nor is it turned over.
LEAST_TILT = np.radians(30.0)
#: How often all that stands apart is turned and placed anew before it is said not to fit [1]: a napkin that is as long
#: as a narrow table is deep fits lengthwise alone.
_PLACEMENTS = 5


class Arrangement(NamedTuple):
    """The objects of a scene in their places."""

    objects: list[SceneObject]
    rest: Rest | None  #: how they came to rest where they fell
    placed_again: int  #: how often all places were drawn again, as the objects did not fit


def arranged(
    objects: Sequence[SceneObject], parts: Parts, table: Table, settings: SceneSettings, seed: int, scene_id: int
) -> Arrangement:
    """Return the objects in their places with their parts behind them, and how they came to rest where they fell.

    Vessels stand upright, some of them on trays and plates, but empty ones lie with `physics.lying_probability`. Props
    stand apart in a stable pose, or with `physics.piled_probability` all props of the scene and the vessels that lie
    fall onto the table. Where no pile comes to rest they stand apart after all, which the record says.

    Parameters
    ----------
    objects : sequence of SceneObject
        Vessels and props, wherever they are, by ascending id.
    parts : mapping
        Parts by the names of the vessels that they move with, in their frames.
    table : Table
        The table.
    settings : SceneSettings
        The settings.
    seed, scene_id : int
        Of the scene.

    Raises
    ------
    InputError
        Where the objects do not fit on the table, or no pile comes to rest and `physics.piled_probability` is 1.
    """
    upright = [_stands(item, parts, settings, seed, scene_id) for item in objects]
    piled = stream(seed, scene_id, "physics").random() < settings.physics.piled_probability
    board, poses, rest, again = outline(table), None, None, 0
    if piled and not all(upright):
        poses, rest = pile_up(
            objects, upright, board, table.material, settings.physics, settings.placement, seed, scene_id, parts
        )
    if poses is None:
        poses, again = _apart(objects, upright, board, settings, seed, scene_id, parts)
    placed, behind = [], []
    for item, pose in zip(objects, poses, strict=True):
        placed.append(item.model_copy(update={"world_T_object": pose}))
        behind += placed_parts(parts.get(item.name, ()), pose)
    first = FIRST_OBJECT_ID + len(placed)
    numbered = [part.model_copy(update={"id": first + number}) for number, part in enumerate(behind)]
    return Arrangement(placed + numbered, rest, again)


def _stands(item: SceneObject, parts: Parts, settings: SceneSettings, seed: int, scene_id: int) -> bool:
    """Return whether an object stands upright: vessels, but for those that lie. What is in one would not stay there."""
    if not isinstance(item, Vessel | MeshVessel):
        return is_filled(item)
    drawn = stream(seed, scene_id, f"lies/{item.name}").random() < settings.physics.lying_probability
    return is_filled(item) or not (drawn or lies(item, parts.get(item.name, ())))


def _apart(
    objects: Sequence[SceneObject],
    upright: Sequence[bool],
    board: np.ndarray,
    settings: SceneSettings,
    seed: int,
    scene_id: int,
    parts: Parts,
) -> tuple[list[np.ndarray], int]:
    """Return poses in which objects stand apart from each other, and how often they were drawn again."""
    meshes = [group_mesh(item, parts.get(item.name, ())) for item in objects]
    for again in range(_PLACEMENTS):
        poses = _placed(objects, upright, meshes, board, settings, seed, scene_id, f"again-{again}/" if again else "")
        if poses is not None:
            return poses, again
    raise crowded(len(objects), board)


def _placed(
    objects: Sequence[SceneObject],
    upright: Sequence[bool],
    meshes: Sequence[Mesh],
    board: np.ndarray,
    settings: SceneSettings,
    seed: int,
    scene_id: int,
    prefix: str,
) -> list[np.ndarray] | None:
    """Return poses in which objects stand apart, drawn from streams with a prefix; None where they do not fit."""
    streams = [stream(seed, scene_id, f"{prefix}pose/{item.name}") for item in objects]
    poses = [_pose(*given) for given in zip(objects, meshes, upright, streams, strict=True)]
    carrier = put_on_carriers(objects, upright, meshes, poses, settings.placement, seed, scene_id)
    outlines = [footprint(mesh, pose) for mesh, pose in zip(meshes, poses, strict=True)]
    groups = {number: [outlines[number]] for number in range(len(objects)) if number not in carrier}
    for number, below in carrier.items():
        groups[below].append(outlines[number])
    around = [hull(np.concatenate(some)) if len(some) > 1 else some[0] for some in groups.values()]
    shifts = find_positions(around, board, settings.placement, stream(seed, scene_id, f"{prefix}placement"))
    if shifts is None:
        return None
    shift_of = dict(zip(groups, shifts, strict=True))
    for number, pose in enumerate(poses):
        pose[:3, 3] += [*shift_of[carrier.get(number, number)], CONTACT_GAP]
    return poses


def _pose(item: SceneObject, mesh: Mesh, upright: bool, rng: np.random.Generator) -> np.ndarray:
    if upright:
        return lowered(turn_about_z(rng.uniform(0.0, 2.0 * np.pi)), mesh)
    if isinstance(item, Prop):
        return prop_pose(item, rng)
    if isinstance(item, Vessel | MeshVessel):
        centre = mechanics_of(item).whole.centre_of_mass
        return lowered(resting_turn(mesh.vertices.astype(np.float64), rng, LEAST_TILT, centre), mesh)
    return resting_pose(mesh, rng)
