"""What families of vessels are drawn with: sizes, proportions, and random pieces of an outline."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..profiles.curve import Curve
from .outline import Outline, Piece, bulging, linear, waved

Limits = tuple[float, float]

#: Probabilities of straight, polynomial and sinusoidal pieces where a family leaves them free: those of vertical and
#: linear, accelerating and polynomial, and sine stretches in TransProteus' vessel generator (20+18, 18+22, 22 %).
PIECE_PROBABILITIES = (0.38, 0.40, 0.22)
#: Steepest dr/dz of a free piece: 2.5 is a wall at 22 degrees to the table, about the flattest of a common bowl.
MAX_SLOPE = 2.5
#: Most half periods of a sinusoidal piece, and most halvings of a deviation that is too large.
MOST_HALF_WAVES, HALVINGS = 4, 40


@dataclass(frozen=True)
class Size:
    """What a family's outline is drawn for [m].

    `room` is the smallest outer radius that leaves room inside the wall (`draw.py` says how much).
    """

    height: float
    radius: float
    room: float


@dataclass(frozen=True)
class Family:
    """Sizes of common glassware of one category [m], and the function that draws its outline."""

    height: Limits
    radius: Limits
    slenderness: Limits
    """Radius over height."""
    wall: Limits
    base: Limits
    outline: Callable[[np.random.Generator, Size], Outline | Curve]
    """An outline over the height, or of a round bottom the whole outside from the axis up."""


def free_piece(rng: np.random.Generator, piece: Piece, limits: Limits, strength: float) -> Piece:
    """Draw a piece of a random kind between the ends of a straight one.

    Its deviation from the straight line is `strength` times its size at most, and is halved until the radius keeps
    within `limits` [m] and the slope within `MAX_SLOPE` (or the straight line's own, if that is steeper).
    """
    ends = (piece.low, piece.high, piece.coefficients[0], sum(piece.coefficients))
    kind = rng.choice(3, p=PIECE_PROBABILITIES)
    most = strength * min(piece.high - piece.low, ends[2] + ends[3])
    first, second = rng.uniform(-most, most, 2)
    half_waves = int(rng.integers(1, MOST_HALF_WAVES + 1))
    if kind == 0:
        return linear(*ends)
    u = np.linspace(piece.low, piece.high, 65)
    steepest = max(MAX_SLOPE, abs(ends[3] - ends[2]) / (piece.high - piece.low) + 0.1)
    for halvings in range(HALVINGS):
        factor = 0.5**halvings
        if kind == 1:
            drawn = bulging(*ends, bulge=factor * first, skew=factor * second)
        else:
            drawn = waved(*ends, amplitude=factor * first / half_waves, half_waves=half_waves)
        radius, slope = drawn.derivative(u, 0), drawn.derivative(u, 1)
        within = radius.min() >= min(limits[0], *ends[2:]) - 1e-9 and radius.max() <= max(limits[1], *ends[2:]) + 1e-9
        if within and np.abs(slope).max() <= steepest:
            return drawn
    return linear(*ends)


def free_chain(
    rng: np.random.Generator, z: list[float], r: list[float], limits: Limits, strength: float
) -> tuple[Piece, ...]:
    """Draw free pieces through knots at heights z and radii r [m]; radii are held within limits and slopes."""
    held = [float(np.clip(r[0], *limits))]
    for low, high, radius in zip(z[:-1], z[1:], r[1:], strict=True):
        reach = 0.8 * MAX_SLOPE * (high - low)
        held.append(float(np.clip(np.clip(radius, *limits), held[-1] - reach, held[-1] + reach)))
    straight = [linear(*ends) for ends in zip(z[:-1], z[1:], held[:-1], held[1:], strict=True)]
    return tuple(free_piece(rng, piece, limits, strength) for piece in straight)


def smoothed(pieces: tuple[Piece, ...], half: float, solid_below: float = 0.0) -> Outline:
    """Return the outline of the pieces, joints smoothed over +- `half` [m], or less between short pieces."""
    lengths = [piece.high - piece.low for piece in pieces]
    joints = tuple(min(half, 0.45 * min(pair)) for pair in pairwise(lengths))
    return Outline(pieces, joints, solid_below)


@dataclass(frozen=True)
class Proportions:
    """Ranges of one family's shape: fractions [1] unless a unit stands beside them.

    They span common glassware of the family by eye. No single source has them, and nothing else depends on them: the
    limits of radius and slope hold whatever is drawn.
    """

    foot: Limits = (1.0, 1.0)
    """Radius at the base, of the largest radius."""
    rim: Limits = (1.0, 1.0)
    """Radius at the rim, of the largest radius (vase: of the throat's radius)."""
    neck: Limits = (1.0, 1.0)
    """Radius of the neck, of the largest radius."""
    first: Limits = (0.0, 0.0)
    """Height of the first joint, of the height (stem glass: where the foot ends)."""
    second: Limits = (0.0, 0.0)
    """Height of the second joint, of the height (stem glass: where the bowl begins)."""
    blend: Limits = (0.0, 0.0)
    """Half the height over which joints are smoothed [m]."""
    bulge: float = 0.0
    """Largest deviation of free pieces from a straight line, of their size."""


#: Lip of bottles and flasks: height [m], at most this fraction of the vessel's, and flare over its height.
LIP, LIP_FRACTION, LIP_FLARE = (0.005, 0.012), 0.1, (0.0, 0.7)


def lip(rng: np.random.Generator, height: float, radius: float) -> tuple[float, float]:
    """Draw the height at which a lip begins to flare, and the radius that it reaches [m]."""
    length = min(rng.uniform(*LIP), LIP_FRACTION * height)
    return height - length, radius + length * rng.uniform(*LIP_FLARE)
