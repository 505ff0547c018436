"""The clear sky, against a scalar version of the paper's formulas."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glassware.procedural.surroundings.preetham import sky_xyy, zenith_xyy

# Rounding of float64.
EXACT = 1e-9


def perez(coefficients, theta: float, gamma: float) -> float:
    a, b, c, d, e = coefficients
    return (1 + a * math.exp(b / math.cos(theta))) * (1 + c * math.exp(d * gamma) + e * math.cos(gamma) ** 2)


def scalar_sky(theta: float, gamma: float, sun: float, t: float) -> tuple[float, float, float]:
    luminance = (
        0.1787 * t - 1.4630,
        -0.3554 * t + 0.4275,
        -0.0227 * t + 5.3251,
        0.1206 * t - 2.5771,
        -0.0670 * t + 0.3703,
    )
    x = (
        -0.0193 * t - 0.2592,
        -0.0665 * t + 0.0008,
        -0.0004 * t + 0.2125,
        -0.0641 * t - 0.8989,
        -0.0033 * t + 0.0452,
    )
    y = (
        -0.0167 * t - 0.2608,
        -0.0950 * t + 0.0092,
        -0.0079 * t + 0.2102,
        -0.0441 * t - 1.6537,
        -0.0109 * t + 0.0529,
    )
    zenith_x = (
        t**2 * (0.00166 * sun**3 - 0.00375 * sun**2 + 0.00209 * sun)
        + t * (-0.02903 * sun**3 + 0.06377 * sun**2 - 0.03202 * sun + 0.00394)
        + (0.11693 * sun**3 - 0.21196 * sun**2 + 0.06052 * sun + 0.25886)
    )
    zenith_y = (
        t**2 * (0.00275 * sun**3 - 0.00610 * sun**2 + 0.00317 * sun)
        + t * (-0.04214 * sun**3 + 0.08970 * sun**2 - 0.04153 * sun + 0.00516)
        + (0.15346 * sun**3 - 0.26756 * sun**2 + 0.06670 * sun + 0.26688)
    )
    chi = (4 / 9 - t / 120) * (math.pi - 2 * sun)
    zenith = (4.0453 * t - 4.9710) * math.tan(chi) - 0.2155 * t + 2.4192
    one, two, three = (
        level * perez(table, theta, gamma) / perez(table, 0.0, sun)
        for level, table in ((zenith_x, x), (zenith_y, y), (zenith, luminance))
    )
    return one, two, three


@pytest.mark.parametrize("turbidity", [1.7, 3.0, 6.0])
@pytest.mark.parametrize("elevation", [10.0, 45.0, 70.0])
def test_the_sky_agrees_with_the_scalar_formulas(turbidity, elevation):
    sun_angle = math.radians(90 - elevation)
    sun = np.array([math.sin(sun_angle), 0.0, math.cos(sun_angle)])
    for theta in (0.1, 0.7, 1.2, 1.5):
        for phi in (0.3, 2.0):
            way = np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])
            expected = scalar_sky(theta, math.acos(way @ sun), sun_angle, turbidity)
            np.testing.assert_allclose(sky_xyy(way, sun, turbidity), expected, rtol=EXACT)


def test_the_zenith_has_the_zenith_values():
    sun = np.array([0.6, 0.0, 0.8])
    np.testing.assert_allclose(sky_xyy(np.array([0.0, 0.0, 1.0]), sun, 3.0), zenith_xyy(0.8, 3.0), rtol=EXACT)


def test_the_horizon_is_finite_and_whiter_than_the_zenith():
    sun = np.array([0.6, 0.0, 0.8])
    horizon = sky_xyy(np.array([-1.0, 0.0, 0.0]), sun, 2.5)
    assert np.isfinite(horizon).all()
    assert horizon[0] > zenith_xyy(0.8, 2.5)[0]
