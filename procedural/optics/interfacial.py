"""Where one liquid floats on another: which do not mix, their interfacial tension, and how they meet a wall.

The angle at a wall follows from the balance of Young's equation for each liquid against air (Bartell and Osterhof 1927,
Ind. Eng. Chem. 19, 1277): with g the surface tensions, a the contact angles in air and g_12 the interfacial tension::

    g_12 cos(a_12) = g_1 cos(a_1) - g_2 cos(a_2)
"""

from __future__ import annotations

import math
from typing import Literal

from .medium import Medium
from .turbid import TURBID
from .wetting import contact_angle

#: Of vegetable oils against water [N/m]: the middle of the 23 to 26 mN/m that Fisher, Mitchell and Parker found for all
#: that they tried (1985, "Interfacial tensions of commercial vegetable oils with water", J. Food Sci. 50, 1201). Sugar
#: changes that of water against air by less than 4 mN/m, and this is taken for sugar solutions as well.
OIL_WATER_TENSION = 0.0245
#: Least difference of densities at which one liquid is taken to float on another [kg/m^3]: below, layers of real drinks
#: do not stay apart. (10 % of sugar raises that of water by 40.)
LEAST_DIFFERENCE = 5.0

Kind = Literal["aqueous", "polar", "oil"]


def kind_of(medium: Medium) -> Kind | None:
    """Return what a liquid of the catalogue is: water and what is dissolved in it, another polar one, or an oil.

    None for media that are not of the catalogue.
    """
    name = medium.name.partition(" with ")[0]
    if name == "water" or name in TURBID or name.endswith("% sugar solution"):
        return "aqueous"
    if name in ("ethanol", "glycerol"):
        return "polar"
    return "oil" if name.endswith("oil") else None


def mixes(one: Medium, other: Medium) -> bool:
    """Return whether two liquids are known to mix: water, ethanol and glycerol do, in all proportions."""
    kinds = kind_of(one), kind_of(other)
    return None not in kinds and (kinds[0] == "oil") == (kinds[1] == "oil")


def interfacial_tension(one: Medium, other: Medium) -> float | None:
    """Return the tension of the interface between two liquids [N/m]; None where it is not known."""
    return OIL_WATER_TENSION if {kind_of(one), kind_of(other)} == {"aqueous", "oil"} else None


def angle_between(lower: Medium, upper: Medium, wall: Medium | None) -> float | None:
    """Return the angle inside the lower liquid between a wall and its interface with the upper one [rad].

    0 or pi where one of the two spreads under the other; None where the tensions or angles are not known.
    """
    tension = interfacial_tension(lower, upper)
    pulls = [_pull(medium, wall) for medium in (lower, upper)]
    if tension is None or pulls[0] is None or pulls[1] is None:
        return None
    return math.acos(max(-1.0, min(1.0, (pulls[0] - pulls[1]) / tension)))


def _pull(medium: Medium, wall: Medium | None) -> float | None:
    """Return the force of a liquid's surface along a wall in air, upwards, by length [N/m]."""
    angle = contact_angle(medium, wall)
    return None if angle is None or medium.surface_tension is None else medium.surface_tension * math.cos(angle)
