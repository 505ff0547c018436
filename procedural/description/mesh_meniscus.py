"""The meniscus of a liquid in a solid of any shape, where the wall around its surface is one of revolution.

The capillary surface is that of a vessel of revolution with the same sections (`profiles.liquid_surface`). Where the
wall is not round, where the surface would touch it before its border, or where it would climb to the brim, there is
none: the surface is flat.
"""

from __future__ import annotations

import numpy as np

from ..cavities.domes import Dome
from ..cavities.sections import Wall
from ..optics.medium import Medium
from ..profiles.curve import Curve
from ..profiles.liquid import highest_contact
from ..profiles.liquid_surface import most_volume, surface_of_volume

#: Largest distance of the surface's polygon from the true curve [m]: that of vessels of revolution by default.
_CHORD_ERROR = 15e-6
#: Height over which the wall's slope is taken [m]: below the capillary length of water, 2.7 mm, and above the steps of
#: a scan.
_SLOPE_HEIGHT = 1e-3
#: The wall has to be round so far below and above the surface [m].
_MARGIN = 5e-4


def meniscus_of(wall: Wall, volume: float, liquid: Medium, glass: Medium) -> Dome | None:
    """Return the curved surface of a volume of liquid inside a wall; None where it is flat.

    Parameters
    ----------
    wall : Wall
        Of the cavity.
    volume : float
        Of the liquid [m^3].
    liquid, glass : Medium
        The two media, which decide the contact angle.
    """
    inner = inner_curve(wall)
    top = highest_contact(inner.points)
    if top <= wall.heights[1] or not 0.0 < volume <= most_volume(inner, liquid, glass):
        return None
    surface = surface_of_volume(inner, volume, liquid, _CHORD_ERROR, glass)
    low, high = sorted((surface.centre, surface.contact))
    if low == high or not wall.is_round(low - _MARGIN, high + _MARGIN):
        return None
    place = int(np.abs(wall.heights - surface.contact).argmin())
    dome = Dome(wall.centres[place], surface.top.points, surface.top.normals)
    return dome if _is_inside(wall, dome) else None


def inner_curve(wall: Wall) -> Curve:
    """Return the inside of the solid of revolution with the sections of a wall, from the axis at its floor up."""
    z, r = wall.heights, wall.radii
    low, high = (np.interp(z + shift, z, r) for shift in (-0.5 * _SLOPE_HEIGHT, 0.5 * _SLOPE_HEIGHT))
    rise = np.minimum(z + 0.5 * _SLOPE_HEIGHT, z[-1]) - np.maximum(z - 0.5 * _SLOPE_HEIGHT, z[0])
    slope = (high - low) / rise
    normals = np.stack([-np.ones_like(slope), slope], axis=1) / np.hypot(1.0, slope)[:, None]
    floor = z[0] - 0.5 * (z[1] - z[0])
    # The part below the first section is as wide as that: floors are flat, or narrow.
    points = np.concatenate([[[0.0, floor], [r[0], floor]], np.stack([r, z], axis=1)])
    return Curve(points, np.concatenate([[[0.0, 1.0]], normals[:1], normals]))


def _is_inside(wall: Wall, dome: Dome) -> bool:
    """Return whether a surface, stretched to the ring of the wall where it ends, meets the wall nowhere else."""
    edge = wall.section(float(dome.points[-1, 1]), dome.centre)
    if edge is None:
        return False
    for radius, height in dome.points[1:-1]:
        section = wall.section(float(height), dome.centre)
        if section is None:
            return False
        if not (section.radii(edge.angles) > radius / dome.points[-1, 0] * edge.radii(edge.angles)).all():
            return False
    return True
