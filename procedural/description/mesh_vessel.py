"""Vessels of any shape: their surfaces between media, empty or with a liquid in them."""

from __future__ import annotations

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh, check_closed, joined, turned, volume_of
from ...core.units import volume_text
from ..cavities.cut import Filling, Parts
from ..cavities.domes import Dome
from ..cavities.find import Hollow
from ..cavities.interior import Interior, filled, flat_level, interior_of, most_volume
from ..cavities.sections import Wall
from ..optics.medium import AIR, Medium
from .bodies import Cavity, Interface, Liquid, MeshVessel, Origin
from .mesh_meniscus import meniscus_of
from .refill import wanted_volume, wets_otherwise


def mesh_vessel(
    solid: Mesh,
    glass: Medium,
    *,
    id: int,
    name: str,
    category: str,
    roughness: float = 0.0,
    symmetric: bool = False,
    origin: Origin | None = None,
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
    origin : Origin, optional
        Where it comes from.
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
        origin=origin,
    )


def refilled_mesh(
    vessel: MeshVessel, medium: Medium | None, fill: float | str | None = None, inside: Interior | None = None
) -> MeshVessel:
    """Return a vessel that holds a liquid, or nothing.

    The liquid's surface has a meniscus where the wall around it is one of revolution, and is flat elsewhere
    (`mesh_meniscus`).

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
        parts, filling = _filled(vessel, medium, inside, volume)
    except ValueError as error:
        # Where a level grazes a floor or a ledge, there may be no closed line; a person can choose another one.
        where, expected = f"{vessel.name}, fill", "a level that cuts the wall in closed lines"
        raise InputError(where, expected, f"{volume_text(volume)}: {error}") from error
    filled_one = with_parts(vessel, medium, parts, filling.level, inside.volume)
    return filled_one if filling.dome is None else _curved(filled_one, filling.hollow, filling.dome)


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


def _curved(vessel: MeshVessel, hollow: Hollow, dome: Dome) -> MeshVessel:
    """Return a vessel with the record of its liquid's curved surface in the largest cavity."""
    liquid = vessel.liquid
    assert liquid is not None
    slope = float(np.arctan2(-dome.normals[-1, 0], dome.normals[-1, 1]))
    changes = {
        "level": flat_level(hollow, liquid.fill * hollow.volume),
        "centre": float(dome.points[0, 1]),
        "contact_angle": liquid.contact_angle - slope,
    }
    return vessel.model_copy(update={"liquid": liquid.model_copy(update=changes)})


def with_mesh_wall(vessel: MeshVessel, glass: Medium, roughness: float | None) -> MeshVessel:
    """Return a vessel of another glass; where its liquid wets that at another angle, with the surface that follows."""
    changed = vessel.with_media(glass=glass, roughness=roughness)
    if changed.liquid is None or not wets_otherwise(vessel, glass):
        return changed
    return refilled_mesh(changed, changed.liquid.medium)


def _filled(vessel: MeshVessel, medium: Medium, inside: Interior, wanted: float) -> tuple[Parts, Filling]:
    """Return the parts, and the filling of the largest cavity."""
    stem = vessel.solid.name.removesuffix("-solid")
    names = (f"{stem}-outside", f"{stem}-wet-wall", f"{stem}-liquid-surface")

    def curved(wall: Wall, volume: float) -> Dome | None:
        return meniscus_of(wall, volume, medium, vessel.glass)

    parts, _ = filled(vessel.solid, inside, wanted, names, curved)
    # Lines sample the cavity: one correction by the volume of the body that follows takes their error away.
    corrected = min(2.0 * wanted - _content(parts), most_volume(inside))
    parts, fillings = filled(vessel.solid, inside, corrected, names, curved)
    return parts, fillings[0]


def _content(parts: Parts) -> float:
    """Return the volume of the liquid's body [m^3]."""
    return volume_of(joined([turned(parts.wet_wall), parts.liquid_surface], "liquid"))


def _contact_angle(parts: Parts, level: float) -> float:
    """Return the mean angle inside the liquid between the wall and a flat surface [rad]."""
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
