"""Kinds of lamps in photometric units: what real ones measure, and luminance and flux of a rectangle that emits light.

A rectangle of area A that emits evenly (Lambert) on one side has the luminance L = flux / (pi A).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..description.surroundings import AreaLight
from .colour import luminance

# Candelas per kilocandela.
_CANDELAS = 1e3


@dataclass(frozen=True)
class Lamp:
    """What lamps of one kind measure: smallest and largest value."""

    length: tuple[float, float]  #: of the longer side [m]
    width: tuple[float, float] | None  #: of the shorter side [m]; None for a square
    flux: tuple[float, float]  #: that leaves the lamp [lm]
    temperature: tuple[float, float]  #: colour temperature [K]

    @property
    def most_luminance(self) -> float:
        """Luminance of the smallest lamp with the largest flux [cd/m^2]."""
        smallest = self.length[0] * (self.length if self.width is None else self.width)[0]
        return self.flux[1] / (math.pi * smallest)


#: By `AreaLight.kind`.
LAMPS: dict[str, Lamp] = {
    # Opal globes and frosted bulbs, 6 to 20 cm; 249 lm replace 25 W, 1521 lm 100 W (Regulation (EC) 244/2009, table 6).
    "bulb": Lamp((0.06, 0.2), None, (249.0, 1521.0), (2700.0, 4000.0)),
    # The mouth of a shade; LED desk lamps of 5 to 12 W at 60 to 80 lm/W.
    "desk-lamp": Lamp((0.08, 0.2), None, (300.0, 900.0), (2700.0, 5000.0)),
    # A tube of 1.2 m (T8: 26 mm across) alone, or behind a cover of up to 10 cm; LED 1500 lm and up, two T8 of 36 W
    # (3350 lm each, EN 60081) 4000 lm after the losses of the fitting.
    "tube": Lamp((1.15, 1.25), (0.026, 0.1), (1500.0, 4000.0), (2700.0, 6500.0)),
    # Ceiling panels of 0.3 x 0.6 to 0.6 x 1.2 m: 30 to 45 W at 100 lm/W.
    "panel": Lamp((0.6, 1.2), (0.3, 0.6), (3000.0, 4500.0), (3000.0, 6500.0)),
    # Photographers' lamps of 100 to 500 W at 100 lm/W; the cloths keep about half of it.
    "soft-box": Lamp((0.6, 1.2), (0.4, 0.6), (5000.0, 25000.0), (4000.0, 6500.0)),
}


def lamp_luminance(light: AreaLight) -> float:
    """Return the luminance of a rectangle whose radiance is in kcd/m^2 [cd/m^2]."""
    return _CANDELAS * float(luminance(np.array(light.radiance)))


def lamp_flux(light: AreaLight) -> float:
    """Return the luminous flux of a rectangle whose radiance is in kcd/m^2 [lm]."""
    return math.pi * light.size[0] * light.size[1] * lamp_luminance(light)
