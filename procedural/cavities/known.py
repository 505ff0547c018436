"""Cavities that are known by construction: volumes and levels from the faces around them, exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.mesh import Mesh
from .cut import Parts, clear_level, cut_known
from .interior import BRIM_MARGIN, MOST_MARGIN

#: Steps of the search for a level [1], and where it ends, of the cavity's depth [1].
_STEPS, _TOLERANCE = 60, 1e-9


@dataclass(frozen=True, eq=False)
class KnownCavity:
    """A cavity of a mesh.

    Parameters
    ----------
    solid : Mesh
        The closed solid.
    inner : (m,) bool
        The faces around the cavity: below the brim, no other face shares an edge with them.
    brim : float
        Height at which liquid would flow out [m].
    """

    solid: Mesh
    inner: np.ndarray
    brim: float

    @property
    def floor(self) -> float:
        """Height of the lowest point [m]."""
        return float(self.solid.vertices[self.solid.faces[self.inner], 2].min())

    @property
    def volume(self) -> float:
        """Volume up to the brim [m^3]."""
        return self.volume_below(self.brim)

    @property
    def most_level(self) -> float:
        """Highest level of a liquid in it [m]."""
        return self.brim - min(BRIM_MARGIN, MOST_MARGIN * (self.brim - self.floor))

    def volume_below(self, level: float) -> float:
        """Return the volume up to a level [m^3].

        By Gauss's theorem with the field (x, y, 0) / 2, whose flux through the level surface vanishes: what is left is
        a sum over the faces below the level.
        """
        corners = self.solid.vertices[self.solid.faces[self.inner]].astype(np.float64)
        corners = corners[corners[..., 2].min(1) < level]
        low = corners[..., 2] < level
        whole = low.all(1)
        total = _flux(corners[whole]).sum()
        for count, sign, start in ((1, 1.0, 0.0), (2, -1.0, 1.0)):
            some = corners[low.sum(1) == count]
            alone = low[low.sum(1) == count]
            tip = (alone.argmax(1) if count == 1 else (~alone).argmax(1))[:, None]
            p, q, r = (np.take_along_axis(some, ((tip + k) % 3)[..., None], 1)[:, 0] for k in range(3))
            pieces = np.stack([p, _at_level(p, q, level), _at_level(p, r, level)], axis=1)
            total += start * _flux(some).sum() + sign * _flux(pieces).sum()
        return float(-total)  # the faces look into the cavity

    def level_of(self, volume: float) -> float:
        """Return the level of a volume [m^3], [m]."""
        low, high = self.floor, self.brim
        below, above = -volume, self.volume - volume
        for step in range(_STEPS):
            part = -below / (above - below) if step % 3 < 2 else 0.5  # regula falsi with bisection now and then
            level = low + min(max(part, 1e-3), 1.0 - 1e-3) * (high - low)
            excess = self.volume_below(level) - volume
            if excess < 0.0:
                low, below = level, excess
            else:
                high, above = level, excess
            if abs(excess) < _TOLERANCE * volume or high - low < _TOLERANCE * (self.brim - self.floor):
                return level
        return 0.5 * (low + high)


def _flux(corners: np.ndarray) -> np.ndarray:
    """Return the flux of (x, y, 0) / 2 through triangles (m, 3, 3)."""
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * (area[:, :2] * corners[..., :2].mean(1)).sum(1)


def _at_level(a: np.ndarray, b: np.ndarray, level: float) -> np.ndarray:
    part = (level - a[:, 2:]) / (b[:, 2:] - a[:, 2:])
    return a + part * (b - a)


def filled_known(cavity: KnownCavity, volume: float, names: tuple[str, str, str]) -> tuple[Parts, float]:
    """Return a solid's surface cut for a volume of liquid [m^3], and the level [m].

    Raises
    ------
    ValueError
        Where the level does not cut the wall in closed lines.
    """
    heights = cavity.solid.vertices[:, 2].astype(np.float64)
    level = clear_level(heights, cavity.level_of(volume))
    return cut_known(cavity.solid, cavity.inner, level, names), level
