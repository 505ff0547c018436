"""Outlines of laboratory glass: volumetric flasks, and profiles with round bottoms."""

from __future__ import annotations

import numpy as np

from ..profiles.curve import Curve, arc, chained
from .family_pieces import Size, lip, smoothed
from .outline import Outline, bulging, easing, linear

#: Volumetric flask: radius of the neck over the body's (ISO 1042: 100 ml 60 mm wide with a neck of 15 mm, 250 ml 80 and
#: 17, 1000 ml 125 and 23), height of the body, of the height, and of its widest place, of the body's.
_NECK, _BODY, _WIDEST, _FOOT = (0.2, 0.26), (0.44, 0.5), (0.3, 0.4), (0.62, 0.75)
#: Round flask: radius of the neck over the body's (ISO 1773: 100 ml 64 mm wide with a neck of 26 mm, 250 ml 85 and 34,
#: 500 ml 105 and 34), radius of the fillet between them, of the neck's.
_ROUND_NECK, _FILLET = (0.28, 0.4), (0.3, 0.7)
#: Test tube: share with a flared rim, the flare's radius, of the tube's, and its angle [rad] (ISO 4142: plain or rimmed).
_RIMMED, _FLARE, _FLARE_ANGLE = 0.6, (0.15, 0.3), (0.5, 1.0)
#: Distance of points on straight parts [m].
_STEP = 5e-4
#: Half the height over which joints are smoothed [m].
_BLEND = 0.006


def volumetric_flask_outline(rng: np.random.Generator, size: Size) -> Outline:
    """Draw the side of a volumetric flask: a pear on a flat base, and a long narrow neck."""
    height, radius = size.height, size.radius
    neck = max(size.room, radius * rng.uniform(*_NECK))
    body = height * rng.uniform(*_BODY)
    widest, foot = body * rng.uniform(*_WIDEST), radius * rng.uniform(*_FOOT)
    lower = bulging(0.0, widest, foot, radius, bulge=0.25 * (radius - foot), skew=0.0)
    start, mouth = lip(rng, height, neck)
    return smoothed(
        (
            lower,
            easing(widest, body, radius, neck),
            linear(body, start, neck, neck),
            linear(start, height, neck, mouth),
        ),
        _BLEND,
    )


def tube_profile(rng: np.random.Generator, size: Size) -> Curve:
    """Draw the side of a test tube: a hemisphere, a tube, and a plain or flared rim."""
    radius, rimmed = size.radius, rng.random() < _RIMMED
    flare, angle = radius * rng.uniform(*_FLARE), rng.uniform(*_FLARE_ANGLE)
    bottom = arc(np.array([0.0, radius]), radius, -0.5 * np.pi, 0.0)
    bottom.points[0, 0] = 0.0
    if not rimmed:
        return chained(bottom, _line((radius, radius), (radius, size.height)))
    # The rim bends outwards: the arc's centre is outside.
    bend = _concave((radius + flare, size.height - flare * np.sin(angle)), flare, np.pi, np.pi - angle)
    return chained(bottom, _line((radius, radius), (radius, bend.points[0, 1])), bend)


def round_flask_profile(rng: np.random.Generator, size: Size) -> Curve:
    """Draw the side of a round-bottom flask: a sphere, a fillet, and a neck with a bent rim."""
    radius = size.radius
    neck = max(size.room, radius * rng.uniform(*_ROUND_NECK))
    fillet, flare = neck * rng.uniform(*_FILLET), 0.003
    rise = np.sqrt((radius + fillet) ** 2 - (neck + fillet) ** 2)
    centre = np.array([neck + fillet, radius + rise])
    touch = float(np.arctan2(rise, neck + fillet))  # direction from the sphere's centre to the fillet's
    sphere = arc(np.array([0.0, radius]), radius, -0.5 * np.pi, touch)
    sphere.points[0, 0] = 0.0
    blend = _concave((centre[0], centre[1]), fillet, np.pi + touch, np.pi)
    angle = 0.8
    bend = _concave((neck + flare, size.height - flare * np.sin(angle)), flare, np.pi, np.pi - angle)
    return chained(sphere, blend, _line((neck, centre[1]), (neck, bend.points[0, 1])), bend)


def _line(start: tuple[float, float], end: tuple[float, float]) -> Curve:
    """Return an upright line."""
    count = max(2, int((end[1] - start[1]) / _STEP))
    points = np.linspace(start, end, count)
    return Curve(points, np.tile([1.0, 0.0], (count, 1)))


def _concave(centre: tuple[float, float], radius: float, start: float, end: float) -> Curve:
    """Return an arc whose centre is outside the glass, its normals towards the centre."""
    made = arc(np.array(centre), radius, start, end)
    return Curve(made.points, -made.normals)
