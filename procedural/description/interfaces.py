"""Cut a vessel into the surfaces that light meets, each between two media.

- `outside`, air|glass: base, outer wall, rim, and the inner wall above the liquid. Normals point into the air.
- `wet_wall`, glass|liquid: the inner wall and floor below the liquid. Normals point into the liquid.
- `liquid_surface`, liquid|air: the top of the liquid. Normals point into the air.

So all normals of `outside` and `wet_wall` point out of the glass, and together they close it. The three meet in one
ring, the contact line, whose positions are bit-identical in all of them.
"""

from __future__ import annotations

from ..optics.medium import AIR, Medium
from ..profiles.curve import Curve, backwards, chained
from ..profiles.cuts import cut_at
from ..profiles.revolve import revolved
from .bodies import Interface


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
    top: Curve,
    *,
    glass: Medium,
    liquid: Medium,
    roughness: float,
    segments: int,
    name: str,
) -> tuple[Interface, ...]:
    """Return the three interfaces of a vessel with a liquid in it.

    Parameters
    ----------
    outer, inner : Curve
        From the axis to the rim's crown, normals out of the glass (`vessels.wall.Section`).
    top : Curve
        The liquid's surface from the axis to the contact line, normals into the air; it ends on the inner curve's
        polygon (`surface.Surface`).
    glass, liquid : Medium
        The two media.
    roughness : float
        GGX alpha of the glass; the liquid's surface is smooth.
    segments : int
        Segments of the rings.
    name : str
        Prefix of the meshes' names.
    """
    wet, dry = cut_at(inner, top.points[-1])
    outside = revolved(chained(outer, backwards(dry)), segments, f"{name}-outside")
    return (
        Interface(part="outside", mesh=outside, front=AIR, back=glass, roughness=roughness),
        Interface(
            part="wet_wall",
            mesh=revolved(wet, segments, f"{name}-wet-wall"),
            front=liquid,
            back=glass,
            roughness=roughness,
        ),
        Interface(
            part="liquid_surface", mesh=revolved(top, segments, f"{name}-liquid-surface"), front=AIR, back=liquid
        ),
    )
