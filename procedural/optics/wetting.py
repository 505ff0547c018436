"""Contact angles: how a liquid meets a wall of glass or of a plastic.

Glass has a polar surface, and how water wets it depends on how clean it is: the angles on it are measured ones
(`Medium.contact_angle`). On plastics the angle depends on little more than the liquid's surface tension g and the
wall's surface energy s, by the equation of state (Li and Neumann 1992, Adv. Colloid Interface Sci. 39, 299; Kwok and
Neumann 1999, the same journal 81, 167)::

    cos(angle) = -1 + 2 sqrt(s / g) exp(-beta (g - s)^2)

The wall's surface energy follows from the angle of water on it, which is measured.
"""

from __future__ import annotations

import math
from functools import cache

from scipy.optimize import brentq

from .catalogue import WATER_TENSION
from .medium import Medium

#: Angle of water on plastics [rad]: means of the equilibrium and advancing angles that Diversified Enterprises found in
#: the literature ("Critical Surface Tension and Contact Angle with Water for Various Polymers"). Polypropylene is not
#: in the catalogue of media, but a wall of that name gets its angle.
WATER_ON_PLASTIC = {
    "acrylic": math.radians(70.9),
    "PET": math.radians(72.5),
    "polycarbonate": math.radians(82.0),
    "polypropylene": math.radians(102.1),
}
#: Constant of the equation of state [m^4/J^2], 0.0001247 (m^2/mJ)^2 (Li and Neumann 1992).
BETA = 124.7
#: Surface tensions for which that was measured end near water's; 60 % of sugar is 5 % above it [N/m]. Liquid metals,
#: above it, keep the angle that they have on glass, as they wet neither.
MOST_TENSION = 0.080
#: Surface energies between which that of a plastic is sought [J/m^2]: fluoropolymers have 0.01 to 0.02.
_ENERGIES = (0.005, WATER_TENSION)


def contact_angle(liquid: Medium, wall: Medium | None) -> float | None:
    """Return the angle between a wall and a liquid's surface, inside the liquid [rad]; None where it is unknown.

    Parameters
    ----------
    liquid : Medium
        The liquid; without a contact angle its surface is flat, on any wall.
    wall : Medium or None
        The wall. A plastic of `WATER_ON_PLASTIC` is known by its name; everything else, and None, counts as glass.
    """
    water = None if wall is None else WATER_ON_PLASTIC.get(wall.name)
    if water is None or liquid.contact_angle is None or liquid.surface_tension is None:
        return liquid.contact_angle
    if liquid.surface_tension > MOST_TENSION:
        return liquid.contact_angle
    return math.acos(_cosine(liquid.surface_tension, surface_energy(water)))


@cache
def surface_energy(water_angle: float) -> float:
    """Return the surface energy of a plastic on which water has a contact angle [J/m^2]."""
    return float(brentq(lambda energy: _cosine(WATER_TENSION, energy) - math.cos(water_angle), *_ENERGIES))


def _cosine(tension: float, energy: float) -> float:
    """Return the cosine of the contact angle by the equation of state; 1 where the liquid spreads."""
    if tension <= energy:
        return 1.0
    return min(1.0, -1.0 + 2.0 * math.sqrt(energy / tension) * math.exp(-BETA * (tension - energy) ** 2))
