"""Turbid liquids: how the surface of one looks that is so deep that no light comes through.

Their light would have to be followed inside them. Here it is not: a turbid liquid is opaque, with the diffuse
reflectance of a deep layer by diffusion theory (Jensen and Buhler 2002, "A rapid hierarchical rendering technique for
translucent materials", eq. 6, with the internal reflection of Egan and Hilgeman as given there)::

    R = a/2 (1 + exp(-4/3 A s)) exp(-s),    s = sqrt(3 (1 - a)),    a = sigma_s' / (sigma_s' + sigma_a)
    A = (1 + F) / (1 - F),    F = -1.440 / n^2 + 0.710 / n + 0.668 + 0.0636 n

So what is right is its colour and brightness from far; light that enters at one place and leaves at another, a glow
around highlights and thin edges that let light through, is missing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...core.errors import InputError
from ...core.setting_errors import suggest
from .catalogue import water
from .medium import Medium


class Scattering(NamedTuple):
    """Reduced scattering and absorption coefficients for red, green and blue [1/mm]."""

    reduced: tuple[float, float, float]
    absorption: tuple[float, float, float]
    source: str


_JENSEN = "Jensen, Marschner, Levoy and Hanrahan 2001, SIGGRAPH, measured"
_NARASIMHAN = "Narasimhan et al. 2006, SIGGRAPH, measured by dilution"
#: Turbid drinks by their names.
TURBID = {
    "milk": Scattering((2.55, 3.21, 3.77), (0.0011, 0.0024, 0.014), _JENSEN),
    "skimmed milk": Scattering((0.70, 1.22, 1.90), (0.0014, 0.0025, 0.0142), _JENSEN),
    "chocolate milk": Scattering((1.4585, 2.1289, 2.9527), (0.010063, 0.043125, 0.14375), _NARASIMHAN),
    "espresso": Scattering((0.72378, 0.84557, 1.0247), (4.7984, 6.5751, 8.8493), _NARASIMHAN),
    "grapefruit juice": Scattering((0.22826, 0.23998, 0.32748), (0.0138, 0.018831, 0.056781), _NARASIMHAN),
}
#: Where light leaves into air, or into the glass of a wall, whose index hardly differs.
INTO_AIR, INTO_GLASS = 1.33, 1.0


def turbid_medium(name: str) -> Medium:
    """Return a turbid liquid as a medium: its index, density and capillary constants are those of water.

    Raises
    ------
    InputError
        For a name that is not in `TURBID`.
    """
    scattering = scattering_of(name)
    source = f"{scattering.source}; all else that of water"
    return water().model_copy(update={"name": name, "absorbers": (), "sigma_a": (0.0, 0.0, 0.0), "source": source})


def scattering_of(name: str) -> Scattering:
    """Return what was measured of a turbid liquid; InputError with the nearest name where there is none."""
    if name not in TURBID:
        raise InputError("turbid liquid", f"one of {', '.join(TURBID)}{suggest(name, list(TURBID))}", repr(name))
    return TURBID[name]


def is_turbid(medium: Medium) -> bool:
    """Return whether a medium is one of `turbid_medium`."""
    return medium.name in TURBID


def diffuse_reflectance(name: str, index: float) -> tuple[float, float, float]:
    """Return the diffuse reflectance of a deep turbid liquid, linear Rec.709.

    Parameters
    ----------
    name : str
        Name in `TURBID`.
    index : float
        Its refractive index over that of what is before its surface (`INTO_AIR`, `INTO_GLASS`).
    """
    scattering = scattering_of(name)
    reduced, absorption = np.array(scattering.reduced), np.array(scattering.absorption)
    albedo = reduced / (reduced + absorption)
    # The fit holds above 1; without a step of the index nothing is reflected.
    inner = -1.440 / index**2 + 0.710 / index + 0.668 + 0.0636 * index if index > 1.0 else 0.0
    boundary = (1.0 + inner) / (1.0 - inner)
    depth = np.sqrt(3.0 * (1.0 - albedo))
    value = 0.5 * albedo * (1.0 + np.exp(-4.0 / 3.0 * boundary * depth)) * np.exp(-depth)
    red, green, blue = (math.floor(1e6 * x) / 1e6 for x in value.tolist())
    return red, green, blue
