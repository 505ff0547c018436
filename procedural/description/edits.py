"""Changes of a scene's objects, each checked: identities, poses, and places that no other body takes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh, joined
from ...core.pose import check_rigid
from ..placement.overlap import ALLOWANCE, Solid, overlap
from .bodies import Prop, SceneObject


def solid_of(item: SceneObject) -> Solid:
    """Return a body as others meet it, in the world frame: glass with its liquid, or a prop."""
    if isinstance(item, Prop):
        return in_world(item.mesh, item.world_T_object)
    outer = [part.mesh for part in item.interfaces if part.part != "wet_wall"]
    return in_world(joined(outer, f"{item.name}-body"), item.world_T_object)


def in_world(mesh: Mesh, world_T_mesh: np.ndarray) -> Solid:
    """Return a mesh in the world frame."""
    return Solid(mesh.vertices.astype(np.float64) @ world_T_mesh[:3, :3].T + world_T_mesh[:3, 3], mesh.faces)


def check_above_table(name: str, solid: Solid) -> None:
    """Refuse a body that reaches below the table's top."""
    lowest = float(solid.points[:, 2].min())
    if lowest < -ALLOWANCE:
        raise InputError(name, "an object above the table's top (z = 0)", f"{-1e3 * lowest:.1f} mm below it")


def check_apart(name: str, solid: Solid, other: str, another: Solid) -> None:
    """Refuse two bodies that overlap."""
    if overlap(solid, another):
        raise InputError(name, f"a place of its own (up to {1e3 * ALLOWANCE:g} mm)", f"that it overlaps {other}")


def check_place(item: SceneObject, others: Sequence[SceneObject]) -> None:
    """Refuse an object with the name of another one, in the table, or in another object."""
    for other in others:
        if other.name == item.name:
            raise InputError(f"{item.name}, name", "one of its own", "that of another object in the scene")
    solid = solid_of(item)
    check_above_table(item.name, solid)
    for other in others:
        check_apart(item.name, solid, other.name, solid_of(other))


def moved(item: SceneObject, world_T_object: object) -> SceneObject:
    """Return an object in another pose; InputError where that is no rigid (4, 4) matrix."""
    where = f"{item.name}, world_T_object"
    try:
        pose = np.array(world_T_object, dtype=np.float64)
    except (TypeError, ValueError):
        pose = np.zeros(0)
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise InputError(where, "a 4x4 matrix of finite numbers", f"an array of shape {pose.shape}")
    check_rigid(where, pose)
    pose.setflags(write=False)
    return item.model_copy(update={"world_T_object": pose})


def with_free_id(item: SceneObject, others: Sequence[SceneObject]) -> SceneObject:
    """Return an object with its id, or with the next free one where another object has it."""
    ids = {other.id for other in others}
    return item if item.id not in ids else item.model_copy(update={"id": max(ids) + 1})
