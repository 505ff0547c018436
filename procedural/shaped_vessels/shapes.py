"""What turns an outline into a vessel of a family: its cross-sections, and what is joined to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..vessels.outline import Outline
from .forms import Form
from .sweep import bezier, flared

Limits = tuple[float, float]


@dataclass(frozen=True)
class Handle:
    """A handle at -x.

    Parameters
    ----------
    low, high : float
        Heights of its two ends [m].
    reach : float
        How far its middle line stands off the wall [m].
    depth, width : float
        Half axes of its cross-section, away from the wall and along it [m].
    rise, drop : float
        How much the control points of its curve lie above the upper and below the lower end [m].
    growth : float
        How much thicker it is where it meets the wall [1].
    """

    low: float
    high: float
    reach: float
    depth: float
    width: float
    rise: float
    drop: float
    growth: float


@dataclass(frozen=True)
class SpoutTube:
    """A hollow spout at +x, as teapots have it.

    Parameters
    ----------
    low : float
        Height at which it leaves the wall [m].
    tip : (float, float)
        Its end: distance from the wall, and height [m].
    root, mouth : float
        Outer radii at both ends [m].
    wall : float
        Thickness [m].
    """

    low: float
    tip: tuple[float, float]
    root: float
    mouth: float
    wall: float


@dataclass(frozen=True, eq=False)
class Shape:
    """What a family gives to an outline.

    Parameters
    ----------
    form : Form
        Cross-sections of the outside.
    measured : Form
        Those of the surface that the wall is measured from (`loft.loft`).
    handle, spout : optional
        What is joined to it.
    gap : float
        Largest width of a sealed space in the wall; 0 where there is none [m].
    """

    form: Form
    measured: Form
    handle: Handle | None = None
    spout: SpoutTube | None = None
    gap: float = 0.0


@dataclass(frozen=True)
class Drawn:
    """What a shape is drawn for: the outline, its wall [m], and segments around that keep the chord error [1]."""

    outline: Outline
    wall: float
    segments: int

    @property
    def height(self) -> float:
        """Height of the outline [m]."""
        return self.outline.height

    def radius(self, z: float) -> float:
        """Return the outer radius at a height [m]."""
        return float(self.outline.derivative(np.array([z]), 0)[0])

    @property
    def largest(self) -> float:
        """Largest radius [m]."""
        return float(self.outline.derivative(np.linspace(0.0, self.height, 129), 0).max())


#: Draws the shape of a family.
Shaper = Callable[[np.random.Generator, Drawn], Shape]


def handle_path(handle: Handle, radius: Callable[[float], float], depth: float) -> np.ndarray:
    """Return the middle line of a handle, (n, 2) as (x, z), whose ends lie `depth` inside the outline [m]."""
    upper, lower = radius(handle.high), radius(handle.low)
    # The middle of such a Bezier curve is at three quarters of the way to its inner control points.
    out = handle.reach / 0.75
    far = max(upper, lower) + out
    points = [
        (-(upper - depth), handle.high),
        (-far, handle.high + handle.rise),
        (-far, handle.low - handle.drop),
        (-(lower - depth), handle.low),
    ]
    return bezier(np.array(points))


def handle_axes(handle: Handle, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the half axes of a handle's cross-section along it [m]."""
    factor = flared(count, handle.growth, 0.05)
    return handle.depth * factor, handle.width * factor
