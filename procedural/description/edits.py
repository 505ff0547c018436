"""Changes of a scene's objects, each checked: identities, poses, and places that no other body takes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh, joined
from ...core.pose import check_rigid
from ..cavities.pierce import lid
from ..optics.medium import Medium
from ..placement.overlap import ALLOWANCE, Solid, contains, overlap, union
from ..profiles.clearance import along_edges, clearance
from .bodies import GlassBody, Prop, SceneObject, Vessel, content_solid, glass_solid, is_filled

#: Distance of points on edges that are looked at [m]: walls are at least a millimetre thick.
_ALONG = 8e-4
#: Most corners of a part that are looked at in its vessel [1]: they are 5 mm apart on a label.
TOUCH_POINTS = 200
#: How far the vertical may be off a vessel's axis and still be that axis [rad]: 10 um across a vessel.
UPRIGHT = 1e-4
#: How far a liquid may be off level [rad]: 0.1 mm across a vessel, less than its meniscus.
LEVEL = 1.5e-3
#: What the name of a mesh, and so of its file, does not hold.
_NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9_-]")


def solid_of(item: SceneObject) -> Solid:
    """Return a body as others meet it, in the world frame: glass with all that is in it, or a prop."""
    if isinstance(item, Prop):
        return in_world(item.mesh, item.world_T_object)
    body = in_world(_closed(item), item.world_T_object)
    for number in _risen(item):
        body = union(body, in_world(content_solid(item, number), item.world_T_object))
    return body


def _closed(item: GlassBody) -> Mesh:
    """Return the surface of the glass with its liquids, as if nothing rose out of them."""
    # Bodies that reach through a liquid's surface leave holes in it, so a flat lid stands for it.
    outside = joined([part.mesh for part in item.interfaces if part.part == "outside"], f"{item.name}-outside")
    closing = [part.mesh for part in item.interfaces if part.part == "liquid_surface"]
    if item.liquids and lid(joined([outside, *closing], "body")) is not None:
        closing = [some for some in [lid(outside)] if some is not None]
    return joined([outside, *closing], f"{item.name}-body")


def _risen(item: GlassBody) -> list[int]:
    """Return which of a vessel's contents lie dry, or rise out of its liquids."""
    if not item.liquids:
        return list(range(len(item.contents)))
    top = item.liquids[-1]
    solids = [content_solid(item, number) for number in range(len(item.contents))]
    up = np.array(top.up or (0.0, 0.0, 1.0))
    return [number for number, solid in enumerate(solids) if float((solid.vertices @ up).max()) > top.contact]


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


def _check_in_glass(name: str, solid: Solid, vessel: Vessel) -> None:
    """Refuse what reaches into the glass of a vessel of revolution that it stands in, by distances from its profile."""
    pose = vessel.world_T_object
    points = (solid.points - pose[:3, 3]) @ pose[:3, :3]
    edges = points[np.unique(np.sort(np.concatenate([solid.faces[:, [0, 1]], solid.faces[:, [1, 2]]]), axis=1), axis=0)]
    depth = -float(clearance(np.array(vessel.outer), np.array(vessel.inner), along_edges(edges, _ALONG)).min())
    if depth > ALLOWANCE:
        expected = f"a place of its own (up to {1e3 * ALLOWANCE:g} mm) in {vessel.name}"
        raise InputError(name, expected, f"that it is {1e3 * depth:.1f} mm in its glass")


def check_pair(item: SceneObject, solid: Solid, other: SceneObject, another: Solid) -> None:
    """Refuse two objects that overlap.

    A vessel and its parts, which are thin and touch it, may come as near as they like, but no corner of one may be
    inside the other. What leans in a vessel may be in its liquid, but not in its glass.
    """
    if item.within == other.name or other.within == item.name:
        inner, outer = (item, other) if item.within == other.name else (other, item)
        _check_standing(inner, solid if inner is item else another, outer, another if inner is item else solid)
        return
    if not _belong_together(item, other):
        check_apart(item.name, solid, other.name, another)
        return
    for (name, body), (inner, points) in (
        ((item.name, solid), (other.name, another.points)),
        ((other.name, another), (item.name, solid.points)),
    ):
        low, high = body.points.min(0), body.points.max(0)
        near = points[((points >= low) & (points <= high)).all(1)]
        near = near[:: -(-len(near) // TOUCH_POINTS) or 1]
        if len(near) and contains(body, near).any():
            raise InputError(inner, f"a place on {name}, which it goes with", "one in it")


def _belong_together(item: SceneObject, other: SceneObject) -> bool:
    hosts = (item.part_of, other.part_of)
    return other.name == hosts[0] or item.name == hosts[1] or (hosts[0] is not None and hosts[0] == hosts[1])


def _check_standing(inner: SceneObject, solid: Solid, vessel: SceneObject, another: Solid) -> None:
    if isinstance(vessel, Vessel):
        _check_in_glass(inner.name, solid, vessel)
        return
    glass = another if isinstance(vessel, Prop) else in_world(glass_solid(vessel), vessel.world_T_object)
    check_apart(inner.name, solid, vessel.name, glass)


def check_place(item: SceneObject, others: Sequence[SceneObject]) -> None:
    """Refuse an object with the name of another one, in the table, or in another object."""
    for other in others:
        if other.name == item.name:
            raise InputError(f"{item.name}, name", "one of its own", "that of another object in the scene")
    check_level(item)
    solid = solid_of(item)
    check_above_table(item.name, solid)
    for other in others:
        check_pair(item, solid, other, solid_of(other))


def check_level(item: SceneObject) -> None:
    """Refuse a pose of a vessel in which its liquid is not level, or what lies dry in it would roll."""
    if not isinstance(item, GlassBody) or not is_filled(item):
        return
    up = np.array((0.0, 0.0, 1.0) if item.liquid is None else item.liquid.up or (0.0, 0.0, 1.0))
    vertical = item.world_T_object[2, :3]
    tilt = float(np.arctan2(np.linalg.norm(np.cross(vertical, up)), vertical @ up))
    if tilt <= LEVEL:
        return
    held = item.contents[0].kind if item.liquid is None else item.liquid.medium.name
    found = f"one tilted by {np.degrees(tilt):.3g} degrees"
    raise InputError(f"{item.name}, world_T_object", f"a pose in which its {held} stays as it is", found)


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


def surrounded(item: SceneObject, vessel: str, before: Medium, medium: Medium) -> SceneObject:
    """Return an object in which a medium around it is another one, where it stands in a vessel."""
    if item.within != vessel:
        return item
    if isinstance(item, Prop):
        parts = [
            part.model_copy(update={"surrounding": medium}) if part.surrounding == before else part
            for part in item.parts
        ]
        return item.model_copy(update={"parts": tuple(parts)})
    sides = [part.model_copy(update={"front": medium}) if part.front == before else part for part in item.interfaces]
    return item.model_copy(update={"interfaces": tuple(sides)})


def made_unique(item: SceneObject, others: Sequence[SceneObject]) -> SceneObject:
    """Return an object whose id and meshes' names no other object has: free ones where they are taken."""
    ids = {other.id for other in others}
    if item.id in ids:
        item = item.model_copy(update={"id": max(ids) + 1})
    if not {mesh.name for mesh in _meshes(item)} & {mesh.name for other in others for mesh in _meshes(other)}:
        return item
    stem = _NOT_IN_NAMES.sub("_", item.name)
    if isinstance(item, Prop):
        return item.model_copy(update={"mesh": replace(item.mesh, name=stem)})
    old = item.interfaces[0].mesh.name.removesuffix("-outside")
    parts = tuple(
        part.model_copy(update={"mesh": replace(part.mesh, name=stem + _end_of(part.mesh.name, old, part.part))})
        for part in item.interfaces
    )
    return item.model_copy(update={"interfaces": parts})


def _end_of(name: str, stem: str, part: str) -> str:
    """Return what a mesh's name has after the stem of its body, or of a mesh that is named otherwise its part."""
    return name.removeprefix(stem) if name.startswith(f"{stem}-") else f"-{part.replace('_', '-')}"


def _meshes(item: SceneObject) -> list[Mesh]:
    return [item.mesh] if isinstance(item, Prop) else [part.mesh for part in item.interfaces]


def moved_with_parts(
    item: SceneObject, world_T_object: object, objects: Sequence[SceneObject]
) -> dict[str, SceneObject]:
    """Return an object in another pose, and what goes with it or stands in it, by name; InputError as `moved`."""
    placed = moved(item, world_T_object)
    change = placed.world_T_object @ np.linalg.inv(item.world_T_object)
    parts = [other for other in objects if item.name in (other.part_of, other.within)]
    return {item.name: placed} | {part.name: moved(part, change @ part.world_T_object) for part in parts}
