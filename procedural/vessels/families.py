"""Families of vessels: which sizes and which sequences of pieces make a tumbler, a bottle, a stem glass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...core.errors import InputError
from .outline import Outline, Piece, bulging, easing, levelling, linear, waved
from .settings import Category, VesselSettings

Limits = tuple[float, float]

#: Shares of straight, polynomial and sinusoidal pieces where a family leaves them free: the shares of vertical and
#: linear, accelerating and polynomial, and sine stretches in TransProteus' vessel generator (20+18, 18+22, 22 %).
PIECE_SHARES = (0.38, 0.40, 0.22)
#: Steepest dr/dz of a free piece: 2.5 is a wall at 22 degrees to the table, about the flattest of a common bowl.
MAX_SLOPE = 2.5


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
    """Sizes of common glassware of one category [m], and how its outline is drawn."""

    height: Limits
    radius: Limits
    slenderness: Limits
    """Radius over height."""
    wall: Limits
    base: Limits
    outline: Callable[[np.random.Generator, Size], Outline]


def draw_size(rng: np.random.Generator, settings: VesselSettings) -> tuple[Category, float, float]:
    """Draw a category, a height [m] and a largest outer radius [m] that fit it and the settings.

    Raises
    ------
    InputError
        Where no category asked for has the heights and radii asked for.
    """
    fitting: list[Category] = [c for c in settings.categories if _fits(FAMILIES[c], settings)]
    if not fitting:
        raise InputError(
            "vessels.categories",
            f"one that can be {settings.height} m high with a radius of {settings.radius} m",
            ", ".join(settings.categories),
        )
    category = fitting[int(rng.integers(len(fitting)))]
    family = FAMILIES[category]
    height_limits, radius_limits = _common(family, settings)
    height = rng.uniform(*height_limits)
    slender = (family.slenderness[0] * height, family.slenderness[1] * height)
    low, high = np.clip(slender, *radius_limits)
    return category, float(height), float(rng.uniform(low, high))


def _common(family: Family, settings: VesselSettings) -> tuple[Limits, Limits]:
    """Heights and radii that both the family and the settings allow, and that have a partner in each other."""
    radius = _overlap(family.radius, settings.radius)
    slenderness = family.slenderness
    height = _overlap(family.height, settings.height, (radius[0] / slenderness[1], radius[1] / slenderness[0]))
    return height, radius


def _overlap(*limits: Limits) -> Limits:
    return max(low for low, _ in limits), min(high for _, high in limits)


def _fits(family: Family, settings: VesselSettings) -> bool:
    return all(low <= high for low, high in _common(family, settings))


def free_piece(rng: np.random.Generator, piece: Piece, limits: Limits, strength: float) -> Piece:
    """Draw a piece of a random kind between the ends of a straight one.

    Its deviation from the straight line is `strength` times its size at most, and is halved until the radius keeps
    within `limits` [m] and the slope within `MAX_SLOPE` (or the straight line's own, if that is steeper).
    """
    ends = (piece.low, piece.high, piece.coefficients[0], sum(piece.coefficients))
    kind = rng.choice(3, p=PIECE_SHARES)
    most = strength * min(piece.high - piece.low, ends[2] + ends[3])
    first, second = rng.uniform(-most, most, 2)
    half_waves = int(rng.integers(1, 5))
    if kind == 0:
        return linear(*ends)
    u = np.linspace(piece.low, piece.high, 65)
    steepest = max(MAX_SLOPE, abs(ends[3] - ends[2]) / (piece.high - piece.low) + 0.1)
    for halvings in range(40):
        share = 0.5**halvings
        if kind == 1:
            drawn = bulging(*ends, bulge=share * first, skew=share * second)
        else:
            drawn = waved(*ends, amplitude=share * first / half_waves, half_waves=half_waves)
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


def _lip(rng: np.random.Generator, height: float, radius: float) -> tuple[float, float]:
    """Draw the height at which a lip begins to flare, and the radius that it reaches [m]."""
    length = min(rng.uniform(0.005, 0.012), 0.1 * height)
    return height - length, radius + length * rng.uniform(0.0, 0.7)


def _tumbler(rng: np.random.Generator, size: Size) -> Outline:
    limits = (size.room, size.radius)
    foot = size.radius * rng.uniform(0.68, 1.0)
    heights = [0.0, *np.sort(rng.uniform(0.2, 0.8, rng.integers(0, 3))).tolist(), 1.0]
    radii = [foot + (size.radius - foot) * h ** rng.uniform(0.6, 1.4) for h in heights]
    return smoothed(free_chain(rng, [h * size.height for h in heights], radii, limits, 0.08), rng.uniform(0.004, 0.015))


def _beaker(rng: np.random.Generator, size: Size) -> Outline:
    flare = rng.uniform(0.002, 0.004)
    body, start = size.radius - flare, size.height - 2.5 * flare
    return smoothed(
        (linear(0.0, start, body, body), bulging(start, size.height, body, size.radius, bulge=-0.2 * flare, skew=0.0)),
        0.003,
    )


def _bowl(rng: np.random.Generator, size: Size) -> Outline:
    foot = max(size.room, size.radius * rng.uniform(0.42, 0.65))
    top = size.height * rng.uniform(0.55, 1.0)
    side = levelling(0.0, top, foot, size.radius, power=int(rng.integers(2, 4)))
    if rng.random() < 0.4 or size.height - top < 0.008:
        high = size.height
        bulge = 0.25 * (size.radius - foot) * rng.uniform(0.2, 0.8)
        return smoothed((bulging(0.0, high, foot, size.radius, bulge=bulge, skew=0.0),), 0.0)
    rim = max(size.room, size.radius * rng.uniform(0.8, 1.0))
    upper = free_chain(rng, [top, size.height], [size.radius, rim], (size.room, size.radius), 0.1)
    return smoothed((side, *upper), rng.uniform(0.004, 0.012))


def _bottle(rng: np.random.Generator, size: Size) -> Outline:
    height, limits = size.height, (size.room, size.radius)
    neck = max(size.room, min(size.radius * rng.uniform(0.3, 0.5), 0.02))
    shoulder, collar = height * rng.uniform(0.42, 0.62), height * rng.uniform(0.68, 0.82)
    foot = size.radius * rng.uniform(0.9, 1.0)
    body = free_chain(rng, [0.0, shoulder], [foot, size.radius], limits, 0.05)
    slope = easing(shoulder, collar, size.radius, neck)
    if rng.random() < 0.3:
        slope = levelling(shoulder, collar, size.radius, neck, power=2)
    lip, mouth = _lip(rng, height, neck)
    return smoothed((*body, slope, linear(collar, lip, neck, neck), linear(lip, height, neck, mouth)), 0.008)


def _stem_glass(rng: np.random.Generator, size: Size) -> Outline:
    height, radius = size.height, size.radius
    stem = rng.uniform(0.0032, 0.0055)
    edge = rng.uniform(0.0022, 0.0032)
    foot = radius * rng.uniform(0.75, 0.95)
    flat, start = height * rng.uniform(0.12, 0.2), height * rng.uniform(0.35, 0.55)
    rim = radius * rng.uniform(0.72, 1.0)
    belly = start + (height - start) * rng.uniform(0.45, 0.7)
    pieces = (
        linear(0.0, edge, foot, foot - 0.2 * edge),
        levelling(edge, flat, foot - 0.2 * edge, stem, power=int(rng.integers(5, 9))),
        free_piece(rng, linear(flat, start, stem, stem), (0.8 * stem, 1.8 * stem), 0.3),
        levelling(start, belly, stem, radius, power=int(rng.integers(2, 4))),
        free_piece(rng, linear(belly, height, radius, rim), (0.5 * radius, radius), 0.06),
    )
    return smoothed(pieces, rng.uniform(0.004, 0.01), solid_below=start)


def _flask(rng: np.random.Generator, size: Size) -> Outline:
    height, radius = size.height, size.radius
    neck = max(size.room, radius * rng.uniform(0.28, 0.42))
    collar = height * rng.uniform(0.6, 0.72)
    lip, mouth = _lip(rng, height, neck)
    top = (linear(collar, lip, neck, neck), linear(lip, height, neck, mouth))
    if rng.random() < 0.5:
        belly = height * rng.uniform(0.06, 0.12)
        foot = radius - 0.3 * belly
        return smoothed((linear(0.0, belly, foot, radius), linear(belly, collar, radius, neck), *top), 0.012)
    # A round body: the arc of a circle is close to a straight line plus half a sine; its top is `radius` wide.
    foot = radius * rng.uniform(0.5, 0.6)
    body = waved(0.0, collar, foot, neck, amplitude=radius - 0.5 * (foot + neck), half_waves=1)
    widest = body.derivative(np.linspace(0.0, collar, 257), 0).max()
    body = waved(0.0, collar, foot, neck, amplitude=body.amplitude - (widest - radius), half_waves=1)
    return smoothed((body, *top), 0.012)


def _vase(rng: np.random.Generator, size: Size) -> Outline:
    height, radius = size.height, size.radius
    belly, neck = height * rng.uniform(0.25, 0.5), height * rng.uniform(0.65, 0.85)
    throat = max(size.room, radius * rng.uniform(0.35, 0.75))
    radii = [radius * rng.uniform(0.5, 0.8), radius, throat, min(radius, throat * rng.uniform(1.0, 1.7))]
    lower = free_piece(rng, linear(0.0, belly, max(size.room, radii[0]), radius), (size.room, radius), 0.1)
    rise = easing(belly, neck, radius, throat)
    mouth = bulging(neck, height, throat, radii[3], bulge=-0.15 * (radii[3] - throat), skew=0.0)
    return smoothed((lower, rise, mouth), rng.uniform(0.008, 0.02))


def _freeform(rng: np.random.Generator, size: Size) -> Outline:
    count = int(rng.integers(2, 6))
    heights = np.concatenate([[0.0], np.cumsum(rng.uniform(0.6, 1.4, count))])
    radii = size.radius * rng.uniform(0.45, 1.0, count + 1)
    radii[rng.integers(count + 1)] = size.radius
    limits = (max(size.room, 0.4 * size.radius), size.radius)
    z = (heights / heights[-1] * size.height).tolist()
    return smoothed(free_chain(rng, z, radii.tolist(), limits, 0.25), rng.uniform(0.004, 0.015))


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
