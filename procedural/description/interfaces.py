"""Cut a vessel into the surfaces that light meets, each between two media.

- `outside`, air|glass: base, outer wall, rim, and the inner wall above the liquid. Normals point into the air.
- `wet_wall`, glass|liquid: the inner wall and floor below the liquid. Normals point into the liquid.
- `liquid_surface`, liquid|air: the top of the liquid. Normals point into the air.
- `liquid_interface`, liquid|liquid: where a liquid floats on another one. Normals point into the upper one.

So all normals of `outside` and `wet_wall` point out of the glass, and together they close it. The three meet in one
ring, the contact line, whose positions are bit-identical in all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...core.mesh import Mesh
from ..optics.medium import AIR, Medium
from ..optics.turbid import INTO_AIR, INTO_GLASS, diffuse_reflectance, is_turbid
from ..profiles.curve import Curve, backwards, chained
from ..profiles.cuts import cut_at
from ..profiles.revolve import revolved
from .bodies import Interface
from .material import OpaqueMaterial, UniformTexture

#: Principled roughness of the surface of a turbid liquid in air [1]: the clear skin of a liquid at rest mirrors
#: sharply, as far as pictures of this size show (GGX alpha 0.0025).
_CLEAR_SURFACE = 0.05


def dry_interfaces(
    outer: Curve, inner: Curve, *, glass: Medium, roughness: float, segments: int, name: str
) -> tuple[Interface, ...]:
    """Return the one interface of an empty vessel, the closed surface of its glass.

    Parameters
    ----------
    outer, inner : Curve
        From the axis to the rim's crown, normals out of the glass (`vessels.wall.Section`).
    glass : Medium
        The glass.
    roughness : float
        GGX alpha.
    segments : int
        Segments of the rings.
    name : str
        Prefix of the meshes' names.
    """
    mesh = revolved(chained(outer, backwards(inner)), segments, f"{name}-outside")
    return (Interface(part="outside", mesh=mesh, front=AIR, back=glass, roughness=roughness),)


def wet_interfaces(
    outer: Curve,
    inner: Curve,
    tops: Sequence[Curve],
    *,
    glass: Medium,
    liquids: Sequence[Medium],
    roughness: float,
    segments: int,
    name: str,
) -> tuple[Interface, ...]:
    """Return the interfaces of a vessel with liquids in it: three with one liquid, two more for each that floats on it.

    Parameters
    ----------
    outer, inner : Curve
        From the axis to the rim's crown, normals out of the glass (`vessels.wall.Section`).
    tops : sequence of Curve
        The surface of each liquid from the axis to the contact line, from the floor up, normals up; each ends on the
        inner curve's polygon (`surface.Surface`).
    glass : Medium
        The glass.
    liquids : sequence of Medium
        The liquids, from the floor up.
    roughness : float
        GGX alpha of the glass; the liquids' surfaces are smooth.
    segments : int
        Segments of the rings.
    name : str
        Prefix of the meshes' names.
    """
    dry, walls = inner, []
    for top in tops:
        wet, dry = cut_at(dry, top.points[-1])
        walls.append(wet)
    outside = revolved(chained(outer, backwards(dry)), segments, f"{name}-outside")
    return (
        Interface(part="outside", mesh=outside, front=AIR, back=glass, roughness=roughness),
        *wetted(
            [revolved(wall, segments, "wall") for wall in walls],
            [revolved(top, segments, "top") for top in tops],
            liquids,
            glass=glass,
            roughness=roughness,
            name=name,
        ),
    )


def wetted(
    walls: Sequence[Mesh],
    tops: Sequence[Mesh],
    liquids: Sequence[Medium],
    *,
    glass: Medium,
    roughness: float,
    name: str,
) -> tuple[Interface, ...]:
    """Return the interfaces of the liquids in a vessel, from the floor up: the wall and the surface of each.

    Parameters
    ----------
    walls, tops : sequence of Mesh
        What each liquid wets, and its surface.
    liquids : sequence of Medium
        The liquids.
    glass : Medium
        What the walls are of.
    roughness : float
        GGX alpha of the walls.
    name : str
        Prefix of the meshes' names.
    """
    found = []
    for number, (wall, top, liquid) in enumerate(zip(walls, tops, liquids, strict=True)):
        # The first has no number: a vessel with one liquid has the names that it had before there were layers.
        wall = replace(wall, name=f"{name}-wet-wall" + (f"-{number}" if number else ""))
        found.append(Interface(part="wet_wall", mesh=wall, front=liquid, back=glass, roughness=roughness))
        if number + 1 < len(tops):
            top = replace(top, name=f"{name}-liquid-interface-{number}")
            found.append(Interface(part="liquid_interface", mesh=top, front=liquids[number + 1], back=liquid))
        else:
            top = replace(top, name=f"{name}-liquid-surface")
            found.append(Interface(part="liquid_surface", mesh=top, front=AIR, back=liquid))
    return tuple(clouded(part) for part in found)


def clouded(part: Interface) -> Interface:
    """Return an interface of a turbid liquid as an opaque one, seen from the other medium; others as they are."""
    turbid = next((medium for medium in (part.back, part.front) if is_turbid(medium)), None)
    if turbid is None:
        return part
    behind_glass = part.part == "wet_wall" or (part.part == "outside" and is_turbid(part.front))
    index = INTO_GLASS if behind_glass else INTO_AIR
    look = OpaqueMaterial(
        name=turbid.name,
        base_colour=UniformTexture(colour=diffuse_reflectance(turbid.name, index)),
        # In air the surface mirrors as a smooth one of water does, nearly; behind glass there is next to no step.
        roughness=1.0 if behind_glass else _CLEAR_SURFACE,
    )
    return part.model_copy(update={"opaque": look, "seen_from_back": is_turbid(part.front)})
