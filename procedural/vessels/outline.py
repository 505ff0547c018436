"""The outline of a vessel: a function r(z) of linear, polynomial and sinusoidal pieces with smoothed joints.

The pieces follow the generator behind Syn-TODD (Eppel et al. 2022, "Predicting 3D shapes, masks, and properties of
materials inside transparent containers, using the TransProteus CGI dataset"), which draws each stretch of a vessel's
side as straight, linear, accelerating, polynomial or sinusoidal.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import polynomial

from ..profiles.curve import Curve

if TYPE_CHECKING:
    from scipy.interpolate import BPoly


@dataclass(frozen=True)
class Piece:
    """One stretch of an outline: r(u) = polynomial(u) + amplitude sin(half_waves pi u), u = 0..1 from low to high.

    Parameters
    ----------
    low, high : float
        Heights of its ends [m].
    coefficients : tuple of float
        Polynomial coefficients in u, constant first [m].
    amplitude : float
        Amplitude of the sine [m].
    half_waves : int
        Half periods of the sine; whole, so that it vanishes at both ends.
    """

    low: float
    high: float
    coefficients: tuple[float, ...]
    amplitude: float = 0.0
    half_waves: int = 0

    def derivative(self, z: np.ndarray | float, order: int) -> np.ndarray:
        """Radius (order 0) [m], slope dr/dz (order 1), or second derivative (order 2) [1/m] at heights z [m]."""
        length = self.high - self.low
        u = (np.asarray(z, dtype=np.float64) - self.low) / length
        omega = self.half_waves * np.pi
        wave = self.amplitude * omega**order * np.sin(omega * u + order * np.pi / 2)
        return (polynomial.polyval(u, polynomial.polyder(self.coefficients, order)) + wave) / length**order


def linear(low: float, high: float, start: float, end: float) -> Piece:
    """Return a straight piece between radii `start` and `end` [m]."""
    return Piece(low, high, (start, end - start))


def bulging(low: float, high: float, start: float, end: float, *, bulge: float, skew: float) -> Piece:
    """Return a cubic piece: straight plus ``4 bulge u (1 - u) + skew u (1 - u) (1 - 2 u)`` [m]."""
    return Piece(low, high, (start, end - start + 4.0 * bulge + skew, -4.0 * bulge - 3.0 * skew, 2.0 * skew))


def waved(low: float, high: float, start: float, end: float, *, amplitude: float, half_waves: int) -> Piece:
    """Return a straight piece with a sine on it."""
    return Piece(low, high, (start, end - start), amplitude, half_waves)


def levelling(low: float, high: float, start: float, end: float, *, power: int) -> Piece:
    """Return a piece that leaves steeply and arrives upright: ``end + (start - end) (1 - u)^power``."""
    rest = polynomial.polypow((1.0, -1.0), power) * (start - end)
    rest[0] += end
    return Piece(low, high, tuple(float(c) for c in rest))


def easing(low: float, high: float, start: float, end: float) -> Piece:
    """Return an S-shaped piece that is upright at both ends: ``start + (end - start) (3 u^2 - 2 u^3)``."""
    step = end - start
    return Piece(low, high, (start, 0.0, 3.0 * step, -2.0 * step))


@dataclass(frozen=True)
class Outline:
    """The outside of a vessel's wall as radius over height.

    Parameters
    ----------
    pieces : tuple of Piece
        From z = 0 up, each beginning where the one before ends (height and radius).
    joints : tuple of float
        Half the height over which each joint between two pieces is smoothed [m]; one fewer than pieces.
    solid_below : float
        Height up to which the vessel is solid glass whatever its radius (a stem) [m].
    """

    pieces: tuple[Piece, ...]
    joints: tuple[float, ...]
    solid_below: float = 0.0

    @property
    def height(self) -> float:
        """Height of the top end [m]."""
        return self.pieces[-1].high

    def derivative(self, z: np.ndarray, order: int) -> np.ndarray:
        """Radius (order 0) [m] or slope dr/dz (order 1) at heights z (n,) [m]; twice continuously differentiable."""
        z = np.asarray(z, dtype=np.float64)
        value = np.zeros_like(z)
        for piece in self.pieces:
            inside = (z >= piece.low) & (z <= piece.high)
            value[inside] = piece.derivative(z[inside], order)
        for blend in self._blends():
            inside = (z >= blend.x[0]) & (z <= blend.x[-1])
            value[inside] = (blend.derivative(order) if order else blend)(z[inside])
        return value

    def sampled(self, step: float) -> Curve:
        """Return points at about equal distances `step` [m] along the outline, normals away from the axis."""
        # A tenth of the step in height: slopes stay below 10, so the arc length is known to a step.
        z = np.linspace(0.0, self.height, max(2, int(10.0 * self.height / step)))
        length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(z), np.diff(self.derivative(z, 0))))])
        z = np.interp(np.linspace(0.0, length[-1], max(2, round(length[-1] / step) + 1)), length, z)
        slope = self.derivative(z, 1)
        normals = np.stack([np.ones_like(z), -slope], axis=-1) / np.hypot(1.0, slope)[:, None]
        return Curve(np.stack([self.derivative(z, 0), z], axis=-1), normals)

    def _blends(self) -> list[BPoly]:
        """Quintic Hermite bridges over the joints: value, slope and curvature agree at both of their ends."""
        from scipy.interpolate import BPoly  # here, as it takes a third of a second to load

        bridges = []
        for below, above, half in zip(self.pieces[:-1], self.pieces[1:], self.joints, strict=True):
            ends = [below.high - half, below.high + half]
            values = [
                [float(piece.derivative(z, order)) for order in range(3)]
                for piece, z in zip((below, above), ends, strict=True)
            ]
            bridges.append(BPoly.from_derivatives(ends, values))
        return bridges
