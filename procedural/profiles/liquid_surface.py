"""The liquid's surface in a vessel: a capillary meniscus that meets the wall at its contact angle.

The wall tilts and curves, so where the surface meets it decides how the surface is shaped, and both decide how much
liquid lies below. The height of the contact line is found so that the volume is the given one.

A liquid without density, surface tension or contact angle keeps a flat surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import root_scalar

from ...core.errors import InputError
from ..optics.capillary import Meniscus, capillary_length, meniscus
from ..optics.interfacial import angle_between, interfacial_tension
from ..optics.medium import Medium
from ..optics.wetting import contact_angle
from .curve import Curve, directions, simplified
from .cuts import CONTACT_MERGE, normal_at
from .liquid import ROUNDING, highest_contact, level_of_volume, volume_below

#: Smallest angle at which a surface meets the wall [rad], and its distance from a half turn at the other end. A facet
#: of the wall leans by up to half of `curve.MAX_TURN` (5 degrees) from the normal that its vertices interpolate, so at
#: 5 degrees or less a surface could cross it. And where the liquid is thinner than the renderer's ray offset, light
#: skips it: in close pictures of ethanol 5e-5 of all segments at 5 degrees and 2.5e-5 at 10, of water at its 25 degrees
#: 6e-6, of a flat surface 1e-6. A liquid that wets at 0 degrees so rises by sqrt(1 - sin 10 deg), 9.1 % less (ethanol
#: on a flat wall: 2.18 mm instead of 2.40).
LEAST_ANGLE = np.radians(10.0)
#: Fractions of the capillary slope at the wall that are tried in turn where the wall is so curved that the surface
#: would intersect it; after the last one the surface is flat.
SLOPE_FRACTIONS = (1.0, 0.75, 0.5, 0.25)
#: Points of the dense surface. The slope turns by up to 180 degrees over three quarters of them, by their cube: by at
#: most 6 degrees from one to the next, within `MAX_TURN`.
SAMPLES = 128
#: Largest error of the contact line's height while the surface's shape is sought [m].
CONTACT_TOLERANCE = 1e-8
#: Step of the contact line for the derivative of the volume by its height [m]: of the order of the chord error.
GROWTH_STEP = 1e-5
#: Secant steps that correct the volume of the polygon; the search before is for that of the true curve.
POLYGON_STEPS = 2


@dataclass(frozen=True, eq=False)
class Surface:
    """The surface of a liquid in a vessel.

    Parameters
    ----------
    top : Curve
        From the axis to the contact line on the inner curve's polygon, normals into the air.
    contact_angle : float
        Angle inside the liquid between the wall and the surface where they meet [rad]; that of the media, unless it
        is below `LEAST_ANGLE`, the wall leaves no room (`SLOPE_FRACTIONS`), or the surface is flat.
    volume : float
        Volume of the body of revolution between the inner polygon and the top's polygon [m^3].
    """

    top: Curve
    contact_angle: float
    volume: float

    @property
    def contact(self) -> float:
        """Height of the contact line [m]."""
        return float(self.top.points[-1, 1])

    @property
    def centre(self) -> float:
        """Height on the axis [m]."""
        return float(self.top.points[0, 1])


def surface_of_volume(
    inner: Curve,
    volume: float,
    medium: Medium,
    chord_error: float,
    wall: Medium | None = None,
    above: Medium | None = None,
) -> Surface:
    """Return the surface under which the inside holds a volume of a liquid.

    On a curved wall several surfaces may be at rest, with different contact lines; one of them is returned.

    Parameters
    ----------
    inner : Curve
        The inside, from the axis at the floor up to the rim's crown, normals out of the glass.
    volume : float
        Volume of the liquid [m^3]; kept to a few parts in 10^7 (`Surface.volume` is exact for what is returned).
    medium : Medium
        The liquid.
    chord_error : float
        Largest distance of the surface's polygon from the true curve [m].
    wall : Medium, optional
        What the wall is made of, which decides the contact angle (`wetting.contact_angle`); glass without it.
    above : Medium, optional
        The liquid that floats on it (`interfacial.angle_between`); air without one.

    Raises
    ------
    InputError
        Where the volume is not positive, or the contact line would come nearer to the rim than `liquid.RIM_MARGIN`.
    """
    liquid = _capillary(medium, wall, above)
    if liquid is not None:
        for fraction in SLOPE_FRACTIONS:
            surface = _fitted(inner, volume, liquid, fraction, chord_error)
            if _is_inside(inner.points, surface.top.points):
                return surface
    return _flat(inner, level_of_volume(inner.points, volume))


def most_volume(inner: Curve, medium: Medium, wall: Medium | None = None) -> float:
    """Return the volume of the liquid whose contact line is as high as `liquid.highest_contact` [m^3]."""
    highest, liquid = highest_contact(inner.points), _capillary(medium, wall)
    flat = volume_below(inner.points, highest)
    return flat if liquid is None else min(flat, _volume(inner, highest, liquid, 1.0))


@dataclass(frozen=True)
class _Capillary:
    """What shapes a surface: density over that of what is above [kg/m^3], tension [N/m], contact angle [rad]."""

    density: float
    tension: float
    angle: float


def _capillary(medium: Medium, wall: Medium | None, above: Medium | None = None) -> _Capillary | None:
    """Return what shapes the surface of a liquid below air or another liquid; None where that is not known."""
    if above is None:
        angle, tension, lighter = contact_angle(medium, wall), medium.surface_tension, 0.0
    else:
        angle, tension = angle_between(medium, above, wall), interfacial_tension(medium, above)
        lighter = above.density
    if medium.density is None or lighter is None or tension is None or angle is None:
        return None
    # Of two liquids gravity acts on the difference: the upper one buoys up the lower (de Gennes et al. 2004, 2.1).
    return _Capillary(medium.density - lighter, tension, min(max(angle, LEAST_ANGLE), np.pi - LEAST_ANGLE))


def _fitted(inner: Curve, volume: float, liquid: _Capillary, fraction: float, chord_error: float) -> Surface:
    contact = _contact_height(inner, volume, liquid, fraction)
    growth = (_volume(inner, contact + GROWTH_STEP, liquid, fraction) - volume) / GROWTH_STEP
    surface = _surface_at(inner, contact, liquid, fraction, chord_error)
    for _ in range(POLYGON_STEPS):
        contact += (volume - surface.volume) / growth
        surface = _surface_at(inner, contact, liquid, fraction, chord_error)
    return surface


def _contact_height(inner: Curve, volume: float, liquid: _Capillary, fraction: float) -> float:
    """Return the height at which the true curve's liquid has the volume; InputError where it is above the rim."""

    @cache  # each call solves the capillary equation, and the ends of the bracket are needed twice
    def excess(contact: float) -> float:
        return _volume(inner, contact, liquid, fraction) - volume

    # The floor's corner may hold nothing yet, where the surface would lie below the floor.
    lowest, highest = float(inner.points[0, 1]) + CONTACT_MERGE, highest_contact(inner.points)
    # A meniscus rises by less than two capillary lengths, and its contact line lies as near to the flat level.
    level = level_of_volume(inner.points, volume)
    reach = 2.0 * capillary_length(liquid.density, liquid.tension)
    near = max(lowest, level - reach), min(highest, level + reach)
    low = near[0] if excess(near[0]) < 0.0 else lowest
    high = near[1] if excess(near[1]) >= 0.0 else highest
    if -ROUNDING * volume <= excess(high) < 0.0:
        return high
    if excess(high) < 0.0:
        raise InputError("liquid.volume", f"at most {volume + excess(high):.3e} m^3 (below the rim)", f"{volume:.3e}")
    return root_scalar(excess, bracket=(low, high), method="brentq", xtol=CONTACT_TOLERANCE).root


def _volume(inner: Curve, contact: float, liquid: _Capillary, fraction: float) -> float:
    """Return the volume under the true curve: what lies below the contact line less the air under that [m^3]."""
    shape = _meniscus(inner, contact, liquid, fraction, 8)
    air = np.pi * float(shape.profile[-1, 0]) ** 2 * shape.wall_height - shape.volume
    return volume_below(inner.points, contact) - float(air)


def _meniscus(inner: Curve, contact: float, liquid: _Capillary, fraction: float, samples: int) -> Meniscus:
    radius = float(np.interp(contact, inner.points[:, 1], inner.points[:, 0]))
    tilt = _tilt(inner, contact)
    slope = fraction * (0.5 * np.pi - liquid.angle - tilt)
    return meniscus(radius, liquid.density, liquid.tension, 0.5 * np.pi - tilt - slope, tilt, samples)


def _tilt(inner: Curve, height: float) -> float:
    """Return how far the wall leans from the vertical at a height [rad], positive where the vessel widens upwards."""
    normal = normal_at(inner, height)
    return float(np.arctan2(normal[1], -normal[0]))


def _surface_at(inner: Curve, contact: float, liquid: _Capillary, fraction: float, chord_error: float) -> Surface:
    shape = _meniscus(inner, contact, liquid, fraction, SAMPLES)
    points = shape.profile + np.array([0.0, contact - shape.wall_height])
    points[-1, 1] = contact
    top = simplified(Curve(points, directions(0.5 * np.pi + shape.angles)), chord_error)
    return Surface(top, 0.5 * np.pi - _tilt(inner, contact) - shape.slope, _polygon_volume(inner.points, top.points))


def _flat(inner: Curve, level: float) -> Surface:
    radius = float(np.interp(level, inner.points[:, 1], inner.points[:, 0]))
    top = Curve(np.array([[0.0, level], [radius, level]]), np.array([[0.0, 1.0], [0.0, 1.0]]))
    return Surface(top, 0.5 * np.pi - _tilt(inner, level), volume_below(inner.points, level))


def _polygon_volume(inner: np.ndarray, top: np.ndarray) -> float:
    """Return the volume of revolution between the two polygons: up the wall, back down the surface [m^3]."""
    r, z = top.T
    air = np.pi / 3.0 * float((np.diff(z) * (r[:-1] ** 2 + r[:-1] * r[1:] + r[1:] ** 2)).sum())
    return volume_below(inner, float(z[-1])) - air


def _is_inside(inner: np.ndarray, top: np.ndarray) -> bool:
    """Return whether the surface's polygon stays inside the wall's. Height never turns back along either of them."""
    r, z = top.T if top[-1, 1] >= top[0, 1] else top[::-1].T
    if z[0] <= inner[0, 1]:
        return False
    heights = np.concatenate([z, inner[:, 1]])
    heights = heights[(heights >= z[0]) & (heights <= z[-1]) & (np.abs(heights - top[-1, 1]) > CONTACT_MERGE)]
    gap = np.interp(heights, inner[:, 1], inner[:, 0]) - np.interp(heights, z, r)
    return bool((gap > 0.0).all())
