"""Another liquid in a vessel, or another glass around it: the surface, the meshes and the media follow together."""

from __future__ import annotations

import numpy as np

from ...core.arguments import number
from ...core.errors import InputError
from ...core.mesh import Mesh
from ...core.units import volume, volume_text
from ..optics.medium import Medium
from ..optics.turbid import is_turbid
from ..optics.wetting import contact_angle
from ..profiles.curve import Curve
from ..profiles.liquid import brimful_volume, level_of_volume
from ..profiles.liquid_surface import Surface, most_volume, surface_of_volume
from .bodies import GlassBody, Liquid, Vessel
from .interfaces import dry_interfaces, wet_interfaces

#: What a vessel holds that has been emptied.
_NOTHING_ELSE = {"liquid": None, "layers": (), "contents": ()}
#: How full an empty vessel becomes where nobody says it [1].
HALF_FULL = 0.5
#: Largest distance of a mesh's ring from the profile's point [m]: meshes hold single precision.
_RING_TOLERANCE = 1e-6


def liquid_of(inner: Curve, surface: Surface, medium: Medium) -> Liquid:
    """Return the record of a liquid from its surface in a vessel."""
    return Liquid(
        medium=medium,
        level=level_of_volume(inner.points, surface.volume),
        centre=surface.centre,
        contact=surface.contact,
        contact_angle=surface.contact_angle,
        fill=surface.volume / brimful_volume(inner.points),
        volume=surface.volume,
        turbid=is_turbid(medium),
    )


def refilled(vessel: Vessel, medium: Medium | None, fill: float | str | None = None) -> Vessel:
    """Return a vessel that holds a liquid, or nothing: with its capillary surface, its meshes and its media.

    Parameters
    ----------
    vessel : Vessel
        Empty or filled.
    medium : Medium or None
        The liquid; None empties the vessel.
    fill : float or str, optional
        Fraction of the brimful volume, or a volume such as ``"150ml"``; by default the volume that the vessel holds, or
        half of an empty one.

    Raises
    ------
    InputError
        Where there is no such volume, or it does not fit in below the rim.
    """
    outer, inner, segments = section_of(vessel)
    common = {"glass": vessel.glass, "roughness": vessel.roughness, "segments": segments, "name": _mesh_name(vessel)}
    if medium is None:
        if fill is not None:
            raise InputError(f"{vessel.name}, fill", "none without a liquid", repr(fill))
        dry = dry_interfaces(outer, inner, **common)
        return vessel.model_copy(update=_NOTHING_ELSE | {"interfaces": dry})
    most = most_volume(inner, medium, vessel.glass)
    amount = wanted_volume(vessel, brimful_volume(inner.points), most, fill)
    chord_error = vessel.size[0] / 2.0 * (1.0 - np.cos(np.pi / segments))
    surface = surface_of_volume(inner, amount, medium, chord_error, vessel.glass)
    interfaces = wet_interfaces(outer, inner, [surface.top], liquids=[medium], **common)
    held = {"liquid": liquid_of(inner, surface, medium), "interfaces": interfaces}
    return vessel.model_copy(update=_NOTHING_ELSE | held)


def with_wall(vessel: Vessel, glass: Medium, roughness: float | None) -> Vessel:
    """Return a vessel of another glass; where its liquid wets that at another angle, with the surface that follows."""
    changed = vessel.with_media(glass=glass, roughness=roughness)
    if changed.liquid is None or not wets_otherwise(vessel, glass):
        return changed
    return refilled(changed, changed.liquid.medium)


def wets_otherwise(vessel: GlassBody, glass: Medium) -> bool:
    """Return whether the liquid in a vessel would meet another glass at another angle."""
    if vessel.liquid is None:
        return False
    before, after = (contact_angle(vessel.liquid.medium, wall) for wall in (vessel.glass, glass))
    return before != after


def wanted_volume(vessel: GlassBody, brimful: float, most: float, fill: float | str | None) -> float:
    """Return the volume of a filling [m^3].

    Parameters
    ----------
    vessel : GlassBody
        Empty or filled.
    brimful, most : float
        What it holds up to the brim, and at most so that the liquid stays below [m^3].
    fill : float or str, optional
        As in `refilled`.

    Raises
    ------
    InputError
        With the largest volume, where it does not fit in.
    """
    where = f"{vessel.name}, fill"
    if fill is None:
        # The same volume of a liquid that climbs higher may need a little more room.
        return min(HALF_FULL * brimful if vessel.liquid is None else vessel.liquid.volume, most)
    if isinstance(fill, str):
        try:
            wanted = volume(fill)
        except ValueError as error:
            raise InputError(where, *str(error).removeprefix("expected ").split(", found ", 1)) from error
        if wanted > most:
            limit = f"at most {volume_text(most)} (below the rim of a vessel of {volume_text(brimful)})"
            raise InputError(where, limit, fill)
        return wanted
    fraction = number(where, fill, 0.0, 1.0)
    if not 0.0 < fraction * brimful <= most:
        raise InputError(where, f"more than 0 and at most {most / brimful:.3f} (below the rim)", fraction)
    return fraction * brimful


def ring_segments(vessel: Vessel) -> int:
    """Return the segments of each ring of a vessel's meshes: triangles about the middle of its foot, vertex 0."""
    outside = next(part.mesh for part in vessel.interfaces if part.part == "outside")
    return int((outside.faces == 0).any(1).sum())


def section_of(vessel: Vessel) -> tuple[Curve, Curve, int]:
    """Return a vessel's outer and inner curve, with the normals of its meshes, and the segments of its rings.

    Raises
    ------
    InputError
        Where the meshes are not those of the profiles.
    """
    outside = next(part.mesh for part in vessel.interfaces if part.part == "outside")
    outer, inner = np.array(vessel.outer), np.array(vessel.inner)
    segments = ring_segments(vessel)
    points, normals = _rings(outside, segments)
    count = len(outer)
    # Behind the outer curve comes the inner one from the rim down, without the crown, which both have.
    inside = [(points[: count - 2 : -1], normals[: count - 2 : -1])]
    walls = [_rings(part.mesh, segments) for part in vessel.interfaces if part.part == "wet_wall"]
    # Each ends with the ring at the line where a liquid's surface meets it, which the next one begins with.
    inside = [*((below[0][:-1], below[1][:-1]) for below in walls), *inside]
    places, facing = (np.concatenate([part[i] for part in inside]) for i in (0, 1))
    found = Curve(outer, _matched(vessel, outer, points[:count], normals[:count]))
    return found, Curve(inner, _matched(vessel, inner, places, facing)), segments


def _matched(vessel: Vessel, profile: np.ndarray, places: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the normal of each point of a profile: that of the ring at the same place, in order."""
    nearest, first = [], 0
    for point in profile:
        distance = np.hypot(*(places[first : first + 3] - point).T)
        step = int(distance.argmin()) if len(distance) else -1
        if step < 0 or distance[step] > _RING_TOLERANCE:
            raise InputError(f"{vessel.name}, interfaces", "the meshes of its profiles", "others")
        nearest.append(first + step)
        first += step + (1 if len(places) > first + step + 1 else 0)
    unit = normals[nearest].astype(np.float64)
    return unit / np.hypot(*unit.T)[:, None]


def _rings(mesh: Mesh, segments: int) -> tuple[np.ndarray, np.ndarray]:
    """Return one point (r, z) and one normal of each ring of a surface of revolution; a vertex on the axis is one."""
    if mesh.normals is None or segments < 8:
        raise InputError(f"mesh {mesh.name}", "rings with normals, as vessels have them", "others")
    on_axis = np.hypot(*mesh.vertices[:, :2].T) == 0.0
    firsts, index = [], 0
    while index < len(mesh.vertices):
        firsts.append(index)
        index += 1 if on_axis[index] else segments
    rows = np.array(firsts)
    return mesh.vertices[rows][:, [0, 2]].astype(np.float64), mesh.normals[rows][:, [0, 2]]


def _mesh_name(vessel: Vessel) -> str:
    """Return the prefix of the names of a vessel's meshes, which scene files name their files by."""
    outside = next(interface.mesh for interface in vessel.interfaces if interface.part == "outside")
    return outside.name.removesuffix("-outside")
