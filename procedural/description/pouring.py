"""Change what a vessel holds: bodies in it float again, and objects that stand in it get new waterlines."""

from __future__ import annotations

from collections.abc import Sequence

from ...core.arguments import check_type
from ...core.errors import InputError
from ..cavities.interior import Interior
from ..cavities.split import whole
from ..optics.medium import Medium
from .bodies import MeshVessel, SceneObject, Vessel
from .filling import Body, fill_vessel, most_liquid
from .mesh_vessel import refilled_mesh
from .refill import refilled, wanted_volume
from .stack import Pour
from .standing import restood, standing_in


def poured(
    vessel: Vessel | MeshVessel,
    pours: Sequence[Pour],
    objects: Sequence[SceneObject] = (),
    inside: Interior | None = None,
    melted: bool = False,
) -> tuple[Vessel | MeshVessel, tuple[SceneObject, ...]]:
    """Return a vessel with other liquids in it, and the objects of a scene that stand in it.

    Ice floats at its new level or lies on the floor, beads stay, and bubbles are gone with the liquid that they were
    in.

    Parameters
    ----------
    vessel : Vessel or MeshVessel
        With the bodies that are in it.
    pours : sequence of Pour
        Its new liquids; none leaves it without.
    objects : sequence of SceneObject
        The objects of its scene.
    inside : Interior, optional
        Cavities of a `MeshVessel`, where they are known.
    melted : bool
        Whether ice is gone as well.

    Raises
    ------
    InputError
        Where they do not fit (`filling.fill_vessel`), or a body has no room at its new place.
    """
    standing = standing_in(objects, vessel)
    gone = ("bubbles", "ice cube") if melted else ("bubbles",)
    bodies = [body for body in bodies_in(vessel) if body.record is not None and body.record.kind not in gone]
    others = [Body(one.solid) for one in standing]
    filled = fill_vessel(vessel, pours, [*bodies, *others], inside)
    changed = tuple(
        restood(one.item, pieces, vessel.world_T_object) for one, pieces in zip(standing, filled.standing, strict=True)
    )
    return filled.vessel, changed


def is_plain(vessel: Vessel | MeshVessel, objects: Sequence[SceneObject]) -> bool:
    """Return whether a vessel holds one liquid or none, and nothing else."""
    return not (vessel.layers or vessel.contents or any(item.within == vessel.name for item in objects))


def held(vessel: Vessel | MeshVessel) -> tuple[Pour, ...]:
    """Return what a vessel holds."""
    return tuple(Pour(liquid.medium, liquid.volume) for liquid in vessel.liquids)


def pours_of(
    vessel: Vessel | MeshVessel, liquids: Sequence[tuple[Medium, float | str]], inside: Interior | None = None
) -> tuple[Pour, ...]:
    """Return liquids with their volumes, given as fractions of the brimful volume or as texts such as ``150ml``.

    Raises
    ------
    InputError
        For amounts that are none, or that do not fit in together.
    """
    pours, total = [], 0.0
    for medium, amount in liquids:
        check_type("liquids", medium, Medium, "a Medium, or its name in the catalogue")
        brimful, most = most_liquid(vessel, medium, inside)
        pours.append(Pour(medium, wanted_volume(vessel, brimful, most - total, amount)))
        total += pours[-1].volume
    return tuple(pours)


def repoured(
    vessel: Vessel | MeshVessel, medium: Medium | None, fill: float | str | None, objects: Sequence[SceneObject] = ()
) -> tuple[Vessel | MeshVessel, tuple[SceneObject, ...]]:
    """Return a vessel that holds one other liquid or none, and the objects of a scene that stand in it.

    Parameters
    ----------
    vessel : Vessel or MeshVessel
        The vessel.
    medium : Medium or None
        The liquid.
    fill : float, str or None
        As in `refill.refilled`; by default as much as it holds of all liquids, or half of an empty one.
    objects : sequence of SceneObject
        The objects of its scene.
    """
    if is_plain(vessel, objects):
        if isinstance(vessel, MeshVessel):
            return refilled_mesh(vessel, medium, fill), ()
        return refilled(vessel, medium, fill), ()
    if medium is None:
        if fill is not None:
            raise InputError(f"{vessel.name}, fill", "none without a liquid", repr(fill))
        return poured(vessel, (), objects)
    brimful, most = most_liquid(vessel, medium)
    total = sum(liquid.volume for liquid in vessel.liquids)
    if fill is None and total:
        return poured(vessel, [Pour(medium, total)], objects)
    return poured(vessel, [Pour(medium, wanted_volume(vessel, brimful, most, fill))], objects)


def bodies_in(vessel: Vessel | MeshVessel) -> tuple[Body, ...]:
    """Return the bodies that a vessel's record names, each with its whole surface."""
    found = []
    for number, record in enumerate(vessel.contents):
        pieces = [part.mesh for part in vessel.interfaces if part.content == number]
        found.append(Body(whole(pieces, f"content-{number}"), record))
    return tuple(found)
