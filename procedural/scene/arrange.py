"""Where the objects of a scene are: standing apart from each other, or in a pile."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.randomness import stream
from ..description.rest import Rest
from ..description.scene import GlassBody, MeshVessel, SceneObject, Vessel
from ..description.surroundings import Table
from ..physics.bodies import mechanics_of
from ..physics.piles import pile_up
from ..placement.placement import CONTACT_GAP, draw_positions, footprint
from ..placement.resting import lowered, resting_pose, resting_turn, turn_about_z
from ..surroundings.table import outline
from .settings import SceneSettings
from .solids import body_mesh

#: Least angle between the axis of a vessel that lies and the vertical [rad]: it lies on its side or on a corner of its
#: foot and its rim, and neither stands nor is it turned over.
LEAST_TILT = np.radians(30.0)


def arranged(
    objects: Sequence[SceneObject], table: Table, settings: SceneSettings, seed: int, scene_id: int
) -> tuple[list[SceneObject], Rest | None]:
    """Return the objects in their places, and how they came to rest where they fell.

    Vessels stand upright, but empty ones lie with `physics.lying_probability`. Props stand apart in a stable pose, or
    with `physics.piled_probability` all props of the scene and the vessels that lie fall onto the table.

    Parameters
    ----------
    objects : sequence of SceneObject
        Vessels and props, wherever they are.
    table : Table
        The table.
    settings : SceneSettings
        The settings.
    seed, scene_id : int
        Of the scene.

    Raises
    ------
    InputError
        Where the objects do not fit on the table, or no pile comes to rest.
    """
    upright = [_stands(item, settings, seed, scene_id) for item in objects]
    piled = stream(seed, scene_id, "physics").random() < settings.physics.piled_probability
    board, rest = outline(table), None
    if piled and not all(upright):
        poses, rest = pile_up(
            objects, upright, board, table.material, settings.physics, settings.placement, seed, scene_id
        )
    else:
        poses = _apart(objects, upright, board, settings, seed, scene_id)
    placed = [item.model_copy(update={"world_T_object": pose}) for item, pose in zip(objects, poses, strict=True)]
    return placed, rest


def _stands(item: SceneObject, settings: SceneSettings, seed: int, scene_id: int) -> bool:
    """Return whether an object stands upright: vessels, but for those that lie. A liquid needs a level surface."""
    if not isinstance(item, Vessel | MeshVessel):
        return isinstance(item, GlassBody) and item.liquid is not None
    lies = stream(seed, scene_id, f"lies/{item.name}").random() < settings.physics.lying_probability
    return item.liquid is not None or not lies


def _apart(
    objects: Sequence[SceneObject],
    upright: Sequence[bool],
    board: np.ndarray,
    settings: SceneSettings,
    seed: int,
    scene_id: int,
) -> list[np.ndarray]:
    streams = [stream(seed, scene_id, f"pose/{item.name}") for item in objects]
    poses = [_pose(*given) for given in zip(objects, upright, streams, strict=True)]
    outlines = [footprint(body_mesh(item), pose) for item, pose in zip(objects, poses, strict=True)]
    shifts = draw_positions(outlines, board, settings.placement, stream(seed, scene_id, "placement"))
    for pose, shift in zip(poses, shifts, strict=True):
        pose[:3, 3] += [*shift, CONTACT_GAP]
    return poses


def _pose(item: SceneObject, upright: bool, rng: np.random.Generator) -> np.ndarray:
    mesh = body_mesh(item)
    if upright:
        return lowered(turn_about_z(rng.uniform(0.0, 2.0 * np.pi)), mesh)
    if isinstance(item, Vessel | MeshVessel):
        centre = mechanics_of(item).whole.centre_of_mass
        return lowered(resting_turn(mesh.vertices.astype(np.float64), rng, LEAST_TILT, centre), mesh)
    return resting_pose(mesh, rng)
