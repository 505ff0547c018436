"""The inside of a vessel of revolution, as bodies in it find it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..description.bodies import Vessel

#: Profiles are thinned to points this far apart for distances [m]: their error is a tenth of what bodies may overlap.
_TOLERANCE = 2e-5


@dataclass(frozen=True, eq=False)
class Room:
    """The profiles of a vessel.

    Parameters
    ----------
    outer, inner : (n, 2) float64
        Rows (r, z) [m], from the axis to the rim's crown.
    """

    outer: np.ndarray
    inner: np.ndarray

    @property
    def floor(self) -> float:
        """Height of the floor on the axis [m]."""
        return float(self.inner[0, 1])

    @property
    def brim(self) -> float:
        """Height of the rim's crown [m]."""
        return float(self.inner[-1, 1])

    def radius(self, height: float) -> float:
        """Return the inner radius at a height [m]."""
        return float(np.interp(height, self.inner[:, 1], self.inner[:, 0]))

    def narrowest(self, low: float, high: float) -> float:
        """Return the smallest inner radius between two heights [m]."""
        between = self.inner[(self.inner[:, 1] >= low) & (self.inner[:, 1] <= high), 0]
        return float(min([self.radius(low), self.radius(high), *between.tolist()]))


def room_of(vessel: Vessel) -> Room:
    """Return the inside of a vessel."""
    return Room(np.array(vessel.outer), np.array(vessel.inner))
