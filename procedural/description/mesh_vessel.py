"""Vessels of any shape: their surfaces between media, empty or with a liquid in them, whose surface is flat."""

from __future__ import annotations

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh, check_closed, joined, turned, volume_of
from ...core.units import volume_text
from ..cavities.cut import Parts
from ..cavities.interior import Interior, filled, interior_of, most_volume
from ..optics.medium import AIR, Medium
from .bodies import Cavity, Interface, Liquid, MeshVessel
from .refill import wanted_volume


def mesh_vessel(
    solid: Mesh,
    glass: Medium,
    *,
    id: int,
    name: str,
    category: str,
    roughness: float = 0.0,
    symmetric: bool = False,
    inside: Interior | None = None,
) -> MeshVessel:
    """Return an empty vessel at the origin, of a closed solid as it stands: z is up.

    Parameters
    ----------
    solid : Mesh
        Closed, its box about the origin, normals out of the glass, named ``<name>-solid``.
    glass : Medium
        The glass.
    id, name, category : int, str, str
        As in the description.
    roughness : float
        GGX alpha of the glass.
    symmetric : bool
        Whether it is a solid of revolution about z.
    inside : Interior, optional
        Its cavities, where they are known (`cavities.interior.interior_of`).

    Raises
    ------
    InputError
        Where the solid is not closed.
    """
    check_closed(f"{name}, mesh {solid.name}", solid)
    inside = inside or interior_of(solid)
    cavities = tuple(Cavity(floor=hollow.floor, brim=hollow.brim, volume=hollow.volume) for hollow in inside.hollows)
    x, y, z = np.ptp(solid.bounds, axis=0).tolist()
    return MeshVessel(
        id=id,
        name=name,
        category=category,
        glass=glass,
        roughness=roughness,
        interfaces=dry_interfaces_of(solid, glass, roughness),
        size=(x, y, z),
        symmetric=symmetric,
        world_T_object=np.eye(4),
        solid=solid,
        wall=inside.wall,
        cavities=cavities,
    )


def refilled_mesh(
    vessel: MeshVessel, medium: Medium | None, fill: float | str | None = None, inside: Interior | None = None
) -> MeshVessel:
    """Return a vessel that holds a liquid with a flat surface, or nothing.

    Parameters
    ----------
    vessel : MeshVessel
        Empty or filled, with a cavity.
    medium : Medium or None
        The liquid; None empties the vessel.
    fill : float or str, optional
        As in `refill.refilled`.
    inside : Interior, optional
        Its cavities, where they are known.

    Raises
    ------
    InputError
        Where there is no such volume, or it does not fit in below the brim.
    """
    if medium is None:
        if fill is not None:
            raise InputError(f"{vessel.name}, fill", "none without a liquid", repr(fill))
        return vessel.model_copy(
            update={"liquid": None, "interfaces": dry_interfaces_of(vessel.solid, vessel.glass, vessel.roughness)}
        )
    inside = inside or interior_of(vessel.solid)
    volume = wanted_volume(vessel, inside.volume, most_volume(inside), fill)
    try:
        parts, level = _filled(vessel.solid, inside, volume)
    except ValueError as error:
        # Where a level grazes a floor or a ledge, there may be no closed line; a person can choose another one.
        where, expected = f"{vessel.name}, fill", "a level that cuts the wall in closed lines"
        raise InputError(where, expected, f"{volume_text(volume)}: {error}") from error
    return with_parts(vessel, medium, parts, level, inside.volume)


def with_parts(vessel: MeshVessel, medium: Medium, parts: Parts, level: float, brimful: float) -> MeshVessel:
    """Return a vessel that holds a liquid, from its surface cut along the level [m] and its brimful volume [m^3]."""
    volume = _content(parts)
    record = Liquid(
        medium=medium,
        level=level,
        centre=level,
        contact=level,
        contact_angle=_contact_angle(parts, level),
        fill=min(volume / brimful, 1.0),
        volume=volume,
    )
    return vessel.model_copy(update={"liquid": record, "interfaces": _wet(parts, vessel, medium)})


def _filled(solid: Mesh, inside: Interior, wanted: float) -> tuple[Parts, float]:
    """Return the parts and the level [m]."""
    stem = solid.name.removesuffix("-solid")
    names = (f"{stem}-outside", f"{stem}-wet-wall", f"{stem}-liquid-surface")
    parts, _ = filled(solid, inside, wanted, names)
    # Lines sample the cavity: one correction by the volume of the body that follows takes their error away.
    return filled(solid, inside, min(2.0 * wanted - _content(parts), most_volume(inside)), names)


def _content(parts: Parts) -> float:
    """Return the volume of the liquid's body [m^3]."""
    return volume_of(joined([turned(parts.wet_wall), parts.liquid_surface], "liquid"))


def _contact_angle(parts: Parts, level: float) -> float:
    """Return the mean angle inside the liquid between the wall and the flat surface [rad]."""
    corners = parts.wet_wall.vertices[parts.wet_wall.faces].astype(np.float64)
    at_level = corners[..., 2] == np.float32(level)
    corners = corners[at_level.sum(1) == 2]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    kept = length > 0.0
    if not kept.any():
        return 0.5 * np.pi
    angles = np.arccos(np.clip(normal[kept, 2] / length[kept], -1.0, 1.0))
    edge = np.ptp(corners[kept, :, :2], axis=1).max(1)
    return float(np.average(angles, weights=np.maximum(edge, 1e-12)))


def dry_interfaces_of(solid: Mesh, glass: Medium, roughness: float) -> tuple[Interface, ...]:
    """Return the one interface of an empty vessel, the whole surface of its solid."""
    name = solid.name.removesuffix("-solid") + "-outside"
    mesh = Mesh(name, solid.vertices, solid.faces, solid.normals)
    return (Interface(part="outside", mesh=mesh, front=AIR, back=glass, roughness=roughness),)


def _wet(parts: Parts, vessel: MeshVessel, liquid: Medium) -> tuple[Interface, ...]:
    glass, roughness = vessel.glass, vessel.roughness
    return (
        Interface(part="outside", mesh=parts.outside, front=AIR, back=glass, roughness=roughness),
        Interface(part="wet_wall", mesh=parts.wet_wall, front=liquid, back=glass, roughness=roughness),
        Interface(part="liquid_surface", mesh=parts.liquid_surface, front=AIR, back=liquid),
    )
