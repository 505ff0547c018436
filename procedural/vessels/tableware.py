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
