"""Outlines of mugs, cups, jugs and other tableware."""

from __future__ import annotations

import numpy as np

from .family_pieces import Size, free_piece, smoothed
from .outline import Outline, bulging, easing, levelling, linear

#: Mug: radius at the base, of the rim's; largest bulge of its side, of its radius.
_MUG_FOOT, _MUG_BULGE = (0.86, 1.0), 0.05
#: Cup: radius at the base, of the rim's; height where the rounded lower part ends, of the height; how much it flares.
_CUP_FOOT, _CUP_TURN, _CUP_FLARE = (0.5, 0.68), (0.45, 0.8), (0.9, 1.0)
#: Jug: radii at the base, of the neck and of the rim, of the largest; heights of the widest place and of the neck.
_JUG_FOOT, _JUG_NECK, _JUG_RIM, _JUG_BELLY, _JUG_COLLAR = (
    (0.68, 0.92),
    (0.62, 0.84),
    (1.02, 1.2),
    (0.25, 0.42),
    (0.72, 0.84),
)
#: Teapot: radii at the base and of the mouth, of the largest; height of the widest place, of the height; height of the
#: collar that the lid sits in [m].
_POT_FOOT, _POT_MOUTH, _POT_BELLY, _POT_COLLAR = (0.55, 0.75), (0.5, 0.62), (0.38, 0.52), 0.008
#: Double-walled glass: radii at the base and of the rim, of the largest; height of the widest place, of the height.
_DOUBLE_FOOT, _DOUBLE_RIM, _DOUBLE_BELLY = (0.7, 0.85), (0.86, 0.97), (0.55, 0.75)
#: Cocktail glass: radius of the stem, thickness of the foot's edge [m]; radius of the foot, of the rim's; heights where
#: the foot ends and the bowl begins, of the height; share of cones (martini), the others are coupes.
_STEM, _FOOT_EDGE, _FOOT_RADIUS, _FOOT_END, _BOWL, _CONES = (
    (0.0034, 0.005),
    (0.0022, 0.0032),
    (0.62, 0.8),
    (0.1, 0.16),
    (0.52, 0.62),
    0.5,
)
#: Half the height over which joints are smoothed [m].
_MUG_BLEND, _JUG_BLEND = 0.008, (0.01, 0.02)


def mug_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the side of a mug: nearly a cylinder."""
    foot = max(size.room, size.radius * rng.uniform(*_MUG_FOOT))
    bulge = _MUG_BULGE * size.radius * rng.uniform(-0.5, 1.0)
    side = bulging(0.0, size.height, foot, size.radius, bulge=bulge, skew=0.0)
    widest = float(side.derivative(np.linspace(0.0, size.height, 65), 0).max())
    scale = size.radius / widest
    return smoothed((bulging(0.0, size.height, scale * foot, scale * size.radius, bulge=scale * bulge, skew=0.0),), 0.0)


def cup_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the side of a cup: round below, upright or flared above."""
    foot = max(size.room, size.radius * rng.uniform(*_CUP_FOOT))
    turn = size.height * rng.uniform(*_CUP_TURN)
    middle = size.radius * rng.uniform(*_CUP_FLARE)
    lower = levelling(0.0, turn, foot, middle, power=2)
    upper = linear(turn, size.height, middle, size.radius)
    return smoothed((lower, upper), _MUG_BLEND)


def jug_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the side of a jug: a belly, a neck, and a rim that widens."""
    height, radius = size.height, size.radius
    belly, collar = height * rng.uniform(*_JUG_BELLY), height * rng.uniform(*_JUG_COLLAR)
    foot, neck = radius * rng.uniform(*_JUG_FOOT), max(size.room, radius * rng.uniform(*_JUG_NECK))
    rim = min(radius, neck * rng.uniform(*_JUG_RIM))
    lower = free_piece(rng, linear(0.0, belly, max(size.room, foot), radius), (size.room, radius), 0.08)
    return smoothed(
        (lower, easing(belly, collar, radius, neck), linear(collar, height, neck, rim)), rng.uniform(*_JUG_BLEND)
    )


def teapot_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the side of a teapot: a belly, and an upright collar for its lid."""
    height, radius = size.height, size.radius
    belly, collar = height * rng.uniform(*_POT_BELLY), height - _POT_COLLAR
    foot, mouth = radius * rng.uniform(*_POT_FOOT), radius * rng.uniform(*_POT_MOUTH)
    return smoothed(
        (
            levelling(0.0, belly, foot, radius, power=2),
            bulging(belly, collar, radius, mouth, bulge=0.18 * (radius - mouth), skew=0.0),
            linear(collar, height, mouth, mouth),
        ),
        0.006,
    )


def double_walled_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the outside of a double-walled glass: a tulip."""
    height, radius = size.height, size.radius
    belly = height * rng.uniform(*_DOUBLE_BELLY)
    foot, rim = max(size.room, radius * rng.uniform(*_DOUBLE_FOOT)), radius * rng.uniform(*_DOUBLE_RIM)
    return smoothed((levelling(0.0, belly, foot, radius, power=2), easing(belly, height, radius, rim)), 0.012)


def cocktail_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the side of a cocktail glass: foot, stem, and a cone or a shallow bowl."""
    height, radius = size.height, size.radius
    stem, edge, foot = rng.uniform(*_STEM), rng.uniform(*_FOOT_EDGE), radius * rng.uniform(*_FOOT_RADIUS)
    flat, start = height * rng.uniform(*_FOOT_END), height * rng.uniform(*_BOWL)
    if rng.random() < _CONES:
        bowl = (linear(start, height, stem, radius),)
    else:
        belly = start + (height - start) * rng.uniform(0.55, 0.85)
        bowl = (levelling(start, belly, stem, radius, power=2), linear(belly, height, radius, radius))
    pieces = (
        linear(0.0, edge, foot, foot - 0.2 * edge),
        levelling(edge, flat, foot - 0.2 * edge, stem, power=int(rng.integers(5, 9))),
        linear(flat, start, stem, stem),
        *bowl,
    )
    return smoothed(pieces, rng.uniform(0.004, 0.008), solid_below=start)
