"""Cut a vessel into the surfaces that light meets, each between two media.

- `outside`, air|glass: base, outer wall, rim, and the inner wall above the liquid. Normals point into the air.
- `wet_wall`, glass|liquid: the inner wall and floor below the liquid. Normals point into the liquid.
- `liquid_surface`, liquid|air: the top of the liquid. Normals point into the air.

So all normals of `outside` and `wet_wall` point out of the glass, and together they close it. The three meet in one
ring, the contact line, whose positions are bit-identical in all of them.
"""

from __future__ import annotations

import numpy as np

from ..description.scene import Interface
from ..optics.medium import AIR, Medium
from .curve import Curve, backwards, chained
from .revolve import revolved

#: A point of the profile nearer to the contact line than this is moved onto it instead of making a needle [m];
#: a tenth of the finest chord error that the settings allow.
CONTACT_MERGE = 2e-7


def dry_interfaces(
    outer: Curve, inner: Curve, *, glass: Medium, roughness: float, segments: int, name: str
) -> tuple[Interface, ...]:
    """Return the one interface of an empty vessel, the closed surface of its glass.

    Parameters
    ----------
    outer, inner : Curve
        From the axis to the rim's crown, normals out of the glass (`wall.Section`).
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
        From the axis to the rim's crown, normals out of the glass (`wall.Section`).
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


def normal_at(inner: Curve, height: float) -> np.ndarray:
    """Return the inner curve's unit normal (2,) at a height [m] above its floor, between those of its points."""
    normal = np.array([np.interp(height, inner.points[:, 1], column) for column in inner.normals.T])
    return normal / np.hypot(*normal)


def cut_at(inner: Curve, contact: np.ndarray) -> tuple[Curve, Curve]:
    """Return the inner curve below and above a point on it, both ending in exactly that point.

    Parameters
    ----------
    inner : Curve
        From the floor up; z never falls.
    contact : (2,) float
        A point (r, z) on the curve's polygon, above the floor and below the crown [m].
    """
    z = inner.points[:, 1]
    if not z[0] < contact[1] < z[-1]:
        raise ValueError(f"contact: expected a height between {z[0]} and {z[-1]}, got {contact[1]}")
    normal = normal_at(inner, contact[1])
    below, above = z < contact[1] - CONTACT_MERGE, z > contact[1] + CONTACT_MERGE
    point, normal = np.array([contact]), normal[None]
    return (
        Curve(np.concatenate([inner.points[below], point]), np.concatenate([inner.normals[below], normal])),
        Curve(np.concatenate([point, inner.points[above]]), np.concatenate([normal, inner.normals[above]])),
    )
