"""Where bodies float in the liquids of a vessel, or lie on its floor, and how high the liquids stand then.

Levels count as flat here, each as high over the middle of its true surface as the caller says.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from ...core.mesh import Mesh, volume_of
from ..cavities.split import volume_below, without_folds
from ..profiles.clearance import floor_under

#: Heights at which the volume of a body below them is known [1]; between them it is interpolated. Few for those that
#: stay where they are: what they displace is measured again.
_SECTIONS, _FEW_SECTIONS = 65, 9
#: Distance between bodies and the glass that they lie on [m]: as that of objects and the table they stand on.
GAP = 1e-4
#: Change of the rises at which levels and bodies count as settled [m], and most rounds until then [1].
_SETTLED, _ROUNDS = 1e-7, 40


@dataclass(frozen=True, eq=False)
class Draught:
    """How much of a body is below a height, where it is."""

    heights: np.ndarray  #: (n,) float64 [m]
    volumes: np.ndarray  #: (n,) float64 [m^3]

    def below(self, height: float) -> float:
        """Return the volume below a height [m^3]."""
        return float(np.interp(height, self.heights, self.volumes))


@dataclass(frozen=True, eq=False)
class Floater:
    """A body that a liquid carries or displaces.

    Parameters
    ----------
    draught : Draught
        The body where it is.
    density : float or None
        Its density [kg/m^3]; None where it stays where it is.
    lowest : float
        By how much it has to rise at least, so as to lie on the floor [m].
    """

    draught: Draught
    density: float | None = None
    lowest: float = 0.0


def draught_of(mesh: Mesh, moves: bool = True) -> Draught:
    """Return the volumes of a closed body below heights, fewer of one that does not move."""
    heights = np.linspace(mesh.bounds[0, 2], mesh.bounds[1, 2], _SECTIONS if moves else _FEW_SECTIONS)
    volumes = [volume_below(mesh, lambda points, z=z: points[:, 2] - z) for z in heights[:-1]]
    return Draught(heights, np.array([*volumes, volume_of(mesh)]))


def equilibrium(
    capacity: Callable[[float], float],
    limits: tuple[float, float],
    liquids: Sequence[tuple[float, float]],
    bodies: Sequence[Floater],
    offsets: Sequence[float],
) -> tuple[list[float], list[float]]:
    """Return the level of each liquid and the rise of each body [m].

    Parameters
    ----------
    capacity : callable
        Volume of the cavity below a level [m^3].
    limits : (float, float)
        Floor and brim of the cavity [m].
    liquids : sequence of (float, float)
        Density [kg/m^3], and volume with that of all liquids below [m^3], from the floor up.
    bodies : sequence of Floater
        What is in them.
    offsets : sequence of float
        Height of the middle of each surface over its level [m].
    """
    rises = [body.lowest if body.density is not None else 0.0 for body in bodies]
    levels = [limits[0]] * len(liquids)
    for _ in range(_ROUNDS):
        before = list(rises)
        for k, (_, wanted) in enumerate(liquids):

            def excess(level: float, k: int = k, wanted: float = wanted) -> float:
                displaced = [b.draught.below(level + offsets[k] - rise) for b, rise in zip(bodies, rises, strict=True)]
                return capacity(level) - sum(displaced) - wanted

            # A level over the brim is found out where the liquids are filled in.
            levels[k] = limits[1] if excess(limits[1]) <= 0.0 else float(brentq(excess, *limits, xtol=1e-10))
        tops = [(rho, level + up) for (rho, _), level, up in zip(liquids, levels, offsets, strict=True)]
        for k, body in enumerate(bodies):
            if body.density is not None:
                up = _floating_rise(body.draught, body.density, tops)
                rises[k] = body.lowest if up is None else max(up, body.lowest)
        if max((abs(a - b) for a, b in zip(rises, before, strict=True)), default=0.0) < _SETTLED:
            break
    return levels, rises


def _floating_rise(draught: Draught, density: float, liquids: Sequence[tuple[float, float]]) -> float | None:
    """Return by how much a body has to rise to float [m]; None where it sinks in all liquids.

    Its weight is that of what it displaces, over all liquids by their densities [kg/m^3] and upper levels [m].
    """
    if not liquids:
        return None
    weight = density * float(draught.volumes[-1])

    def excess(rise: float) -> float:
        lift, under = 0.0, 0.0
        for rho, level in liquids:
            below = draught.below(level - rise)
            lift += rho * (below - under)
            under = below
        return lift - weight

    low, high = liquids[0][1] - draught.heights[-1], liquids[-1][1] - draught.heights[0]
    # At the lower end all of it is in the heaviest liquid.
    return float(brentq(excess, low, high, xtol=1e-10)) if excess(low) > 0.0 else None


def lying_rise(mesh: Mesh, inner: np.ndarray) -> float:
    """Return by how much a body has to rise to lie on the floor of a vessel of revolution, `GAP` above it [m]."""
    points = mesh.vertices.astype(np.float64)
    floor = floor_under(inner, np.hypot(points[:, 0], points[:, 1]))
    return float((floor - points[:, 2]).max()) + GAP


def raised(mesh: Mesh, rise: float) -> Mesh:
    """Return a body that is higher by some length [m]."""
    return without_folds(replace(mesh, vertices=mesh.vertices.astype(np.float64) + np.array([0.0, 0.0, rise])))
