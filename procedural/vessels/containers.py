"""Outlines of containers: square and oval bottles, plastic bottles and cups, jars, vials."""

from __future__ import annotations

import numpy as np

from .family_pieces import Size, lip, smoothed
from .outline import Outline, bulging, easing, linear, waved

#: Square and oval bottles: heights of shoulder and collar, of the height; radius of the neck [m] (glass finishes of 22
#: to 31.5 mm; narrower vessels have narrower ones); radius at the base, of the largest.
_SHOULDER, _COLLAR, _NECK, _FOOT = (0.55, 0.68), (0.74, 0.84), (0.0115, 0.0155), (0.96, 1.0)
#: PET bottle: radius of the neck and of its support ring, height of the finish above that [m] (PCO 1881: 24.9 and
#: 17 mm; its ring of 33 mm is solid, a blown wall bends less); height where the shoulder begins, of the height; number
#: of the rings around it, their least distance and their depth [m].
_PET_NECK, _PET_RING, _PET_FINISH = 0.01245, 0.0150, 0.017
_PET_SHOULDER, _PET_RINGS, _PET_PITCH, _PET_DEPTH = (0.6, 0.72), (3, 7), 0.012, (0.5e-3, 1.2e-3)
#: Plastic cup: radius at the base, of the rim's; height and width of the bead at its rim [m] (cups of 0.2 l: 70 mm wide
#: at the rim, 45 mm at the base).
_CUP_FOOT, _BEAD_HEIGHT, _BEAD = (0.62, 0.76), 0.0035, (0.8e-3, 1.3e-3)
#: Jar: radius of the mouth, of the largest; height of the shoulder [m] and of the mouth with its thread [m] (jars of
#: 370 ml with a twist-off lid of 63 to 82 mm), height of the thread's rings [m].
_JAR_MOUTH, _JAR_SHOULDER, _JAR_FINISH, _THREAD = (0.84, 0.95), (0.006, 0.014), (0.012, 0.015), 0.6e-3
#: Vial: radius of the neck and of the crimp, of the body's; heights of the shoulder, of the body's radius, and of the
#: crimp [m] (ISO 8362-1: injection vials of 2 to 100 ml, neck 13 or 20 mm, crimp 3.6 mm high).
_VIAL_NECK, _VIAL_CRIMP, _VIAL_SHOULDER, _VIAL_FLANGE = (0.62, 0.72), 1.16, (0.45, 0.7), 0.0036
#: Height of the step from a vial's neck to its flange [m].
_STEP = 0.0022
#: Half the heights over which joints are smoothed [m].
_BLEND, _SMALL = 0.006, 0.0012


def angular_bottle_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the side of a bottle with a straight body, an S-shaped shoulder and a neck with a lip."""
    height = size.height
    neck = min(max(size.room, rng.uniform(*_NECK)), 0.8 * size.radius)
    shoulder, collar = height * rng.uniform(*_SHOULDER), height * rng.uniform(*_COLLAR)
    start, mouth = lip(rng, height, neck)
    mouth = min(mouth, size.radius)  # of a slim bottle
    return smoothed(
        (
            linear(0.0, shoulder, size.radius * rng.uniform(*_FOOT), size.radius),
            easing(shoulder, collar, size.radius, neck),
            linear(collar, start, neck, neck),
            linear(start, height, neck, mouth),
        ),
        _BLEND,
    )


def plastic_bottle_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the side of a PET bottle: rings around the body, a shoulder, a support ring, and the finish."""
    height, radius = size.height, size.radius
    shoulder, finish = height * rng.uniform(*_PET_SHOULDER), height - _PET_FINISH
    rings, depth = int(rng.integers(_PET_RINGS[0], _PET_RINGS[1] + 1)), rng.uniform(*_PET_DEPTH)
    belt = shoulder * rng.uniform(0.3, 0.5)  # rings below, a smooth belt for the label above
    rings = max(2, min(rings, int(belt / _PET_PITCH)))
    body, ring = radius - depth, 0.0045
    collar = finish - 2.0 * ring - 0.004
    flange = [
        linear(collar, finish - 2.0 * ring, _PET_NECK, _PET_NECK),
        easing(finish - 2.0 * ring, finish - ring, _PET_NECK, _PET_RING),
        easing(finish - ring, finish, _PET_RING, _PET_NECK),
        linear(finish, height, _PET_NECK, _PET_NECK),
    ]
    pieces = (
        waved(0.0, belt, body, body, amplitude=depth, half_waves=2 * rings),
        linear(belt, shoulder, body, body),
        easing(shoulder, collar, body, _PET_NECK),
        *flange,
    )
    return smoothed(pieces, _SMALL)


def plastic_cup_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the side of a single-use cup: a cone with a bead around its rim."""
    bead = rng.uniform(*_BEAD)
    top, rim = size.height - _BEAD_HEIGHT, size.radius - bead
    foot = rim * rng.uniform(*_CUP_FOOT)
    return smoothed((linear(0.0, top, foot, rim), bulging(top, size.height, rim, rim, bulge=bead, skew=0.0)), _SMALL)


def jar_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the side of a jar: a body, a short shoulder, and a wide mouth with a thread."""
    height, radius = size.height, size.radius
    mouth = radius * rng.uniform(*_JAR_MOUTH)
    finish, shoulder = height - rng.uniform(*_JAR_FINISH), rng.uniform(*_JAR_SHOULDER)
    foot = radius * rng.uniform(0.95, 1.0)
    return smoothed(
        (
            linear(0.0, finish - shoulder, foot, radius),
            easing(finish - shoulder, finish, radius, mouth),
            waved(finish, height - 0.002, mouth, mouth, amplitude=_THREAD, half_waves=4),
            linear(height - 0.002, height, mouth, mouth),
        ),
        _SMALL,
    )


def vial_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the side of a vial: a cylinder, a shoulder, a neck, and the flange that a cap is crimped over."""
    height, radius = size.height, size.radius
    neck = max(min(size.room, 0.8 * radius), radius * rng.uniform(*_VIAL_NECK))
    flange = height - _VIAL_FLANGE
    shoulder = radius * rng.uniform(*_VIAL_SHOULDER)
    collar = flange - 0.25 * radius
    crimp = neck * _VIAL_CRIMP
    return smoothed(
        (
            linear(0.0, collar - shoulder, radius, radius),
            easing(collar - shoulder, collar, radius, neck),
            linear(collar, flange - _STEP, neck, neck),
            easing(flange - _STEP, flange, neck, crimp),
            linear(flange, height, crimp, crimp),
        ),
        _SMALL,
    )
