"""Families of vessels: which sizes and which sequences of pieces make a tumbler, a bottle, a stem glass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .outline import Outline, Piece, bulging, easing, levelling, linear, waved
from .settings import Category

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
    outline: Callable[[np.random.Generator, Size], Outline]


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


TUMBLER = Proportions(foot=(0.68, 1.0), first=(0.2, 0.8), blend=(0.004, 0.015), bulge=0.08)
BOWL = Proportions(foot=(0.42, 0.65), rim=(0.8, 1.0), first=(0.55, 1.0), blend=(0.004, 0.012), bulge=0.1)
BOTTLE = Proportions(foot=(0.9, 1.0), neck=(0.3, 0.5), first=(0.42, 0.62), second=(0.68, 0.82), bulge=0.05)
STEM_GLASS = Proportions(
    foot=(0.75, 0.95), rim=(0.72, 1.0), first=(0.12, 0.2), second=(0.35, 0.55), blend=(0.004, 0.01), bulge=0.06
)
FLASK = Proportions(foot=(0.5, 0.6), neck=(0.28, 0.42), first=(0.06, 0.12), second=(0.6, 0.72))
VASE = Proportions(
    foot=(0.5, 0.8),
    rim=(1.0, 1.7),
    neck=(0.35, 0.75),
    first=(0.25, 0.5),
    second=(0.65, 0.85),
    blend=(0.008, 0.02),
    bulge=0.1,
)
FREEFORM = Proportions(foot=(0.45, 1.0), first=(0.6, 1.4), blend=(0.004, 0.015), bulge=0.25)

#: Tumbler: most inner knots of the side, and exponents of its taper between straight (1), concave and convex.
_TUMBLER_KNOTS, _TUMBLER_TAPER = 2, (0.6, 1.4)
#: Beaker: width of the flared rim [m], and its height over its width.
_FLARE, _FLARE_HEIGHT = (0.002, 0.004), 2.5
#: Bowl: probability of one continuous curve, and bulge of that, of a quarter of the width that it gains. Steps of less
#: height [m] than this make no rim of their own.
_PLAIN_BOWL, _PLAIN_BULGE, _LEAST_RIM = 0.4, (0.2, 0.8), 0.008
#: Bottle: widest neck [m] (that of a jar is a mouth), probability of a round instead of an S-shaped shoulder.
_WIDEST_NECK, _ROUND_SHOULDER = 0.02, 0.3
#: Lip of bottles and flasks: height [m], at most this fraction of the vessel's, and flare over its height.
_LIP, _LIP_FRACTION, _LIP_FLARE = (0.005, 0.012), 0.1, (0.0, 0.7)
#: Stem glass: radius of the stem and thickness of the foot's edge [m]; height of the widest place, of the bowl's; the
#: stem's largest deviation and its radii, of its own radius.
_STEM, _FOOT_EDGE, _BELLY, _STEM_BULGE, _STEM_RADII = (0.0032, 0.0055), (0.0022, 0.0032), (0.45, 0.7), 0.3, (0.8, 1.8)
#: Flask: probability of a conical (Erlenmeyer) instead of a spherical body.
_CONICAL = 0.5
#: Freeform: fewest and most pieces, and smallest radius of the largest.
_PIECES, _LEAST_RADIUS = (2, 5), 0.4
#: Half the heights over which joints are smoothed where they do not vary [m]: beaker, bottle, flask.
_BEAKER_BLEND, _BOTTLE_BLEND, _FLASK_BLEND = 0.003, 0.008, 0.012


def _lip(rng: np.random.Generator, height: float, radius: float) -> tuple[float, float]:
    """Draw the height at which a lip begins to flare, and the radius that it reaches [m]."""
    length = min(rng.uniform(*_LIP), _LIP_FRACTION * height)
    return height - length, radius + length * rng.uniform(*_LIP_FLARE)


def _tumbler(rng: np.random.Generator, size: Size) -> Outline:
    limits = (size.room, size.radius)
    foot = size.radius * rng.uniform(*TUMBLER.foot)
    knots = rng.uniform(*TUMBLER.first, rng.integers(0, _TUMBLER_KNOTS + 1))
    heights = [0.0, *np.sort(knots).tolist(), 1.0]
    radii = [foot + (size.radius - foot) * h ** rng.uniform(*_TUMBLER_TAPER) for h in heights]
    side = free_chain(rng, [h * size.height for h in heights], radii, limits, TUMBLER.bulge)
    return smoothed(side, rng.uniform(*TUMBLER.blend))


def _beaker(rng: np.random.Generator, size: Size) -> Outline:
    flare = rng.uniform(*_FLARE)
    body, start = size.radius - flare, size.height - _FLARE_HEIGHT * flare
    lip = bulging(start, size.height, body, size.radius, bulge=-0.2 * flare, skew=0.0)
    return smoothed((linear(0.0, start, body, body), lip), _BEAKER_BLEND)


def _bowl(rng: np.random.Generator, size: Size) -> Outline:
    foot = max(size.room, size.radius * rng.uniform(*BOWL.foot))
    top = size.height * rng.uniform(*BOWL.first)
    side = levelling(0.0, top, foot, size.radius, power=int(rng.integers(2, 4)))
    if rng.random() < _PLAIN_BOWL or size.height - top < _LEAST_RIM:
        bulge = 0.25 * (size.radius - foot) * rng.uniform(*_PLAIN_BULGE)
        return smoothed((bulging(0.0, size.height, foot, size.radius, bulge=bulge, skew=0.0),), 0.0)
    rim = max(size.room, size.radius * rng.uniform(*BOWL.rim))
    upper = free_chain(rng, [top, size.height], [size.radius, rim], (size.room, size.radius), BOWL.bulge)
    return smoothed((side, *upper), rng.uniform(*BOWL.blend))


def _bottle(rng: np.random.Generator, size: Size) -> Outline:
    height, limits = size.height, (size.room, size.radius)
    neck = max(size.room, min(size.radius * rng.uniform(*BOTTLE.neck), _WIDEST_NECK))
    shoulder, collar = height * rng.uniform(*BOTTLE.first), height * rng.uniform(*BOTTLE.second)
    foot = size.radius * rng.uniform(*BOTTLE.foot)
    body = free_chain(rng, [0.0, shoulder], [foot, size.radius], limits, BOTTLE.bulge)
    slope = easing(shoulder, collar, size.radius, neck)
    if rng.random() < _ROUND_SHOULDER:
        slope = levelling(shoulder, collar, size.radius, neck, power=2)
    lip, mouth = _lip(rng, height, neck)
    top = (linear(collar, lip, neck, neck), linear(lip, height, neck, mouth))
    return smoothed((*body, slope, *top), _BOTTLE_BLEND)


def _stem_glass(rng: np.random.Generator, size: Size) -> Outline:
    height, radius = size.height, size.radius
    stem = rng.uniform(*_STEM)
    edge = rng.uniform(*_FOOT_EDGE)
    foot = radius * rng.uniform(*STEM_GLASS.foot)
    flat, start = height * rng.uniform(*STEM_GLASS.first), height * rng.uniform(*STEM_GLASS.second)
    rim = radius * rng.uniform(*STEM_GLASS.rim)
    belly = start + (height - start) * rng.uniform(*_BELLY)
    stem_limits = (_STEM_RADII[0] * stem, _STEM_RADII[1] * stem)
    # The foot falls off steeply (powers 5 to 8), the bowl rounds like a tulip (2 or 3).
    pieces = (
        linear(0.0, edge, foot, foot - 0.2 * edge),
        levelling(edge, flat, foot - 0.2 * edge, stem, power=int(rng.integers(5, 9))),
        free_piece(rng, linear(flat, start, stem, stem), stem_limits, _STEM_BULGE),
        levelling(start, belly, stem, radius, power=int(rng.integers(2, 4))),
        free_piece(rng, linear(belly, height, radius, rim), (0.5 * radius, radius), STEM_GLASS.bulge),
    )
    return smoothed(pieces, rng.uniform(*STEM_GLASS.blend), solid_below=start)


def _flask(rng: np.random.Generator, size: Size) -> Outline:
    height, radius = size.height, size.radius
    neck = max(size.room, radius * rng.uniform(*FLASK.neck))
    collar = height * rng.uniform(*FLASK.second)
    lip, mouth = _lip(rng, height, neck)
    top = (linear(collar, lip, neck, neck), linear(lip, height, neck, mouth))
    if rng.random() < _CONICAL:
        belly = height * rng.uniform(*FLASK.first)
        foot = radius - 0.3 * belly
        return smoothed((linear(0.0, belly, foot, radius), linear(belly, collar, radius, neck), *top), _FLASK_BLEND)
    # A spherical body: the arc of a circle is close to a straight line plus half a sine; its top is `radius` wide.
    foot = radius * rng.uniform(*FLASK.foot)
    body = waved(0.0, collar, foot, neck, amplitude=radius - 0.5 * (foot + neck), half_waves=1)
    widest = body.derivative(np.linspace(0.0, collar, 257), 0).max()
    body = waved(0.0, collar, foot, neck, amplitude=body.amplitude - (widest - radius), half_waves=1)
    return smoothed((body, *top), _FLASK_BLEND)


def _vase(rng: np.random.Generator, size: Size) -> Outline:
    height, radius = size.height, size.radius
    belly, neck = height * rng.uniform(*VASE.first), height * rng.uniform(*VASE.second)
    throat = max(size.room, radius * rng.uniform(*VASE.neck))
    foot, rim = radius * rng.uniform(*VASE.foot), min(radius, throat * rng.uniform(*VASE.rim))
    lower = free_piece(rng, linear(0.0, belly, max(size.room, foot), radius), (size.room, radius), VASE.bulge)
    rise = easing(belly, neck, radius, throat)
    mouth = bulging(neck, height, throat, rim, bulge=-0.15 * (rim - throat), skew=0.0)
    return smoothed((lower, rise, mouth), rng.uniform(*VASE.blend))


def _freeform(rng: np.random.Generator, size: Size) -> Outline:
    count = int(rng.integers(_PIECES[0], _PIECES[1] + 1))
    heights = np.concatenate([[0.0], np.cumsum(rng.uniform(*FREEFORM.first, count))])
    radii = size.radius * rng.uniform(*FREEFORM.foot, count + 1)
    radii[rng.integers(count + 1)] = size.radius
    limits = (max(size.room, _LEAST_RADIUS * size.radius), size.radius)
    z = (heights / heights[-1] * size.height).tolist()
    chain = free_chain(rng, z, radii.tolist(), limits, FREEFORM.bulge)
    return smoothed(chain, rng.uniform(*FREEFORM.blend))


#: Sizes are those of common household and laboratory glassware (tumblers 0.1-0.5 l, wine glasses, bottles up to a
#: magnum, laboratory glass from 50 ml), rounded.
FAMILIES: dict[Category, Family] = {
    "tumbler": Family((0.06, 0.17), (0.022, 0.05), (0.24, 0.55), (0.0015, 0.003), (0.003, 0.010), _tumbler),
    "beaker": Family((0.055, 0.19), (0.02, 0.065), (0.33, 0.40), (0.001, 0.0018), (0.002, 0.003), _beaker),
    "bowl": Family((0.04, 0.10), (0.035, 0.08), (0.7, 1.3), (0.0018, 0.004), (0.003, 0.008), _bowl),
    "bottle": Family((0.14, 0.30), (0.025, 0.055), (0.11, 0.24), (0.0018, 0.0035), (0.003, 0.010), _bottle),
    "stem glass": Family((0.11, 0.24), (0.025, 0.05), (0.17, 0.30), (0.001, 0.0016), (0.002, 0.006), _stem_glass),
    "flask": Family((0.09, 0.24), (0.03, 0.075), (0.30, 0.40), (0.001, 0.0022), (0.002, 0.004), _flask),
    "vase": Family((0.10, 0.30), (0.03, 0.075), (0.20, 0.36), (0.002, 0.004), (0.004, 0.010), _vase),
    "freeform": Family((0.04, 0.30), (0.015, 0.08), (0.18, 0.8), (0.001, 0.004), (0.002, 0.010), _freeform),
}
