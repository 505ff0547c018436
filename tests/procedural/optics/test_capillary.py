from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from glassware.core.errors import InputError
from glassware.procedural.optics.capillary import GRAVITY, capillary_length, meniscus

WATER: dict[str, Any] = {"density": 998.2, "surface_tension": 0.07274}
LENGTH = capillary_length(**WATER)


def _volume(profile):
    r, z = profile.T
    # Trapezium over the area's measure pi d(r^2).
    return np.pi * np.sum(np.diff(r**2) * 0.5 * (z[1:] + z[:-1]))


def test_the_capillary_length_of_water_is_2_7_mm():
    assert pytest.approx(2.7e-3, abs=0.05e-3) == LENGTH


@pytest.mark.parametrize("angle", [0.0, 25.0, 60.0, 110.0, 150.0])
def test_a_wide_vessel_has_the_height_of_a_flat_wall(angle):
    # de Gennes et al. 2004, sec. 2.3: h^2 = 2 lc^2 (1 - sin theta). The vessel's own curvature adds the order lc / R.
    theta = np.radians(angle)
    flat = np.sign(np.pi / 2 - theta) * LENGTH * np.sqrt(2.0 * (1.0 - np.sin(theta)))
    errors = []
    for ratio in (50.0, 100.0, 200.0):
        height = meniscus(ratio * LENGTH, **WATER, contact_angle=theta).wall_height
        errors.append(height / flat - 1.0)
        assert abs(errors[-1]) < 1.0 / ratio
    # First order: twice the radius, half the error.
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.05)


def test_a_wide_vessel_is_flat_in_the_middle():
    r, z = meniscus(30.0 * LENGTH, **WATER, contact_angle=0.3, samples=200).profile.T
    assert np.abs(z[r < 15.0 * LENGTH]).max() < 1e-5 * LENGTH
    assert z[0] < 1e-10 * LENGTH


def test_the_decay_from_the_wall_is_exponential_with_the_capillary_length():
    r, z = meniscus(60.0 * LENGTH, **WATER, contact_angle=0.3, samples=400).profile.T
    far = (r > 50.0 * LENGTH) & (r < 55.0 * LENGTH)
    slope = np.polyfit(r[far], np.log(z[far]), 1)[0] * LENGTH
    # ln I0(x) rises by 1 - 1 / (2 x): 1 % less at x = 50.
    assert slope == pytest.approx(1.0, abs=0.012)


@pytest.mark.parametrize("angle", [0.0, 40.0, 75.0])
def test_a_narrow_tube_has_jurins_height_under_a_spherical_cap(angle):
    theta, radius = np.radians(angle), 0.02 * LENGTH
    r, z = meniscus(radius, **WATER, contact_angle=theta, samples=200).profile.T
    # The next term of the height is of the order R^2 / lc^2, relative (Rayleigh 1916).
    order = (radius / LENGTH) ** 2
    jurin = 2.0 * np.cos(theta) * LENGTH**2 / radius
    assert z[0] == pytest.approx(jurin, rel=order)
    sphere = radius / np.cos(theta)
    cap = sphere - np.sqrt(np.maximum(sphere**2 - r**2, 0.0))
    assert np.abs(z - z[0] - cap).max() < order * radius


def test_rayleighs_correction_of_jurins_height_is_found():
    # Perfect wetting: a^2 = R (h + R / 3 - 0.1288 R^2 / h), a^2 = 2 lc^2 (Rayleigh 1916). Next term: R^3 / h^2.
    radius = 0.15 * LENGTH
    height = meniscus(radius, **WATER, contact_angle=0.0).profile[0, 1]
    a2 = radius * (height + radius / 3.0 - 0.1288 * radius**2 / height)
    assert a2 == pytest.approx(2.0 * LENGTH**2, rel=5e-6)


@settings(max_examples=25, deadline=None)
@given(
    ratio=st.floats(0.05, 60.0),
    theta=st.floats(0.0, np.pi),
    density=st.floats(700.0, 1400.0),
    tension=st.floats(0.02, 0.08),
)
def test_the_walls_pull_carries_the_liquid(ratio, theta, density, tension):
    # rho g V = 2 pi R gamma cos(theta), with V from the sampled profile: an independent quadrature.
    radius = ratio * capillary_length(density, tension)
    surface = meniscus(radius, density, tension, theta, samples=2000)
    pull = 2.0 * np.pi * radius * tension * np.cos(theta) / (density * GRAVITY)
    scale = 2.0 * np.pi * radius * tension / (density * GRAVITY)
    assert surface.volume == pytest.approx(pull, abs=1e-12 * scale)
    # The trapezium's error goes with the square of the spacing of 2,000 samples.
    assert _volume(surface.profile) == pytest.approx(pull, abs=2e-5 * scale)


@pytest.mark.parametrize(("angle", "tilt"), [(25.0, 0.0), (25.0, 10.0), (60.0, -8.0), (110.0, 5.0)])
def test_the_surface_meets_the_wall_at_its_contact_angle(angle, tilt):
    surface = meniscus(0.03, **WATER, contact_angle=np.radians(angle), wall_tilt=np.radians(tilt), samples=4000)
    (r0, z0), (r1, z1) = surface.profile[-2:]
    inward = np.array([r0 - r1, z0 - z1]) / np.hypot(r1 - r0, z1 - z0)
    down = -np.array([np.sin(np.radians(tilt)), np.cos(np.radians(tilt))])
    assert np.degrees(np.arccos(inward @ down)) == pytest.approx(angle, abs=0.1)
    assert surface.profile[-1, 0] == 0.03


def test_every_point_obeys_young_and_laplace():
    radius = 3.0 * LENGTH
    r, z = meniscus(radius, **WATER, contact_angle=0.5, samples=3000).profile.T
    # Points that lie closer than this would make the differences a matter of rounding.
    kept = np.unique(np.searchsorted(r, np.linspace(0.02, 1.0, 300)[:-1] * radius))
    r, z = r[kept], z[kept]
    slope = np.gradient(z, r)
    sine = slope / np.hypot(1.0, slope)
    curvature = np.gradient(r * sine, r) / r
    inside = slice(2, -2)
    assert np.abs(curvature[inside] * LENGTH**2 - z[inside]).max() < 2e-3 * z[-1]


def test_a_surface_at_ninety_degrees_is_flat():
    surface = meniscus(0.03, **WATER, contact_angle=np.pi / 2)
    assert np.abs(surface.profile[:, 1]).max() < 1e-15
    assert abs(surface.volume) < 1e-18


def test_a_liquid_that_does_not_wet_is_the_mirror_image():
    up = meniscus(0.01, **WATER, contact_angle=np.radians(50.0)).profile
    down = meniscus(0.01, **WATER, contact_angle=np.radians(130.0)).profile
    assert down[:, 0] == pytest.approx(up[:, 0])
    assert down[:, 1] == pytest.approx(-up[:, 1])


def test_the_profile_runs_from_the_axis_to_the_wall_without_turning_back():
    for radius in (1e-4, 0.01, 0.2, 2.0):
        surface = meniscus(radius, **WATER, contact_angle=0.2)
        assert surface.profile.shape == (64, 2)
        assert surface.profile[0, 0] == 0.0
        assert surface.profile[-1, 0] == radius
        assert np.all(np.diff(surface.profile[:, 0]) > 0.0)
        assert np.isfinite(surface.profile).all()


def test_the_mean_height_is_the_volume_over_the_area():
    surface = meniscus(0.02, **WATER, contact_angle=0.3)
    assert surface.mean_height * np.pi * 0.02**2 == pytest.approx(surface.volume)
    assert 0.0 < surface.mean_height < surface.wall_height


@pytest.mark.parametrize(
    ("field", "value"), [("radius", 0.0), ("radius", float("nan")), ("density", -1.0), ("surface_tension", 0.0)]
)
def test_sizes_must_be_positive(field, value):
    arguments = {"radius": 0.03, **WATER, "contact_angle": 0.3, field: value}
    with pytest.raises(InputError, match=field.replace("_", " ")):
        meniscus(**arguments)


def test_a_surface_that_would_close_above_itself_is_refused():
    with pytest.raises(InputError, match="slope at the wall"):
        meniscus(0.03, **WATER, contact_angle=0.1, wall_tilt=-1.6)


@pytest.mark.parametrize("radius", [0.05 * LENGTH, LENGTH, 10.0 * LENGTH])
def test_under_a_leaning_wall_the_surface_overhangs_and_still_balances_the_pull(radius):
    surface = meniscus(radius, **WATER, contact_angle=np.radians(25.0), wall_tilt=np.radians(-40.0), samples=4000)
    r, z = surface.profile.T
    assert np.degrees(surface.slope) == pytest.approx(105.0)
    assert r.max() > r[-1] == radius
    # In a narrow tube the middle is level to the last bit.
    assert np.all(np.diff(z) >= -1e-15)
    pull = 2.0 * np.pi * radius * LENGTH**2 * np.sin(surface.slope)
    # The trapezium's error goes with the square of the spacing of 4,000 samples.
    assert _volume(surface.profile) == pytest.approx(pull, rel=2e-5)


@pytest.mark.parametrize(("angle", "tilt"), [(25.0, 0.0), (20.0, -35.0), (89.9999, 0.0), (130.0, 0.0)])
def test_the_slopes_are_those_of_the_profile(angle, tilt):
    surface = meniscus(0.02, **WATER, contact_angle=np.radians(angle), wall_tilt=np.radians(tilt), samples=4000)
    steps = np.diff(surface.profile, axis=0)
    middle = 0.5 * (surface.angles[1:] + surface.angles[:-1])
    assert np.abs(np.arctan2(steps[:, 1], steps[:, 0]) - middle).max() < 1e-5
    assert surface.angles[0] == 0.0
    assert surface.angles[-1] == pytest.approx(surface.slope, abs=1e-12)


@pytest.mark.parametrize("ratio", [0.05, 0.3, 1.0, 10.0, 40.0])
@pytest.mark.parametrize("degrees", [10.0, 65.0, 105.0, 126.0])
def test_the_profile_is_the_one_that_adaptive_integration_finds(ratio, degrees):
    # A second method: from a point of the profile near the axis, the equation is integrated up to the wall.
    surface = meniscus(ratio * LENGTH, **WATER, contact_angle=0.0, wall_tilt=np.pi / 2 - np.radians(degrees))
    r, z = (surface.profile / LENGTH).T
    first = len(r) // 2

    def right_side(phi, state):
        curvature = state[1] - np.sin(phi) / state[0]
        return np.cos(phi) / curvature, np.sin(phi) / curvature

    span = (surface.angles[first], surface.angles[-1])
    start = (r[first], z[first])
    found = solve_ivp(right_side, span, start, "DOP853", t_eval=surface.angles[first:], rtol=1e-12, atol=1e-14).y
    assert found[0] == pytest.approx(r[first:], rel=2e-7)
    assert found[1] == pytest.approx(z[first:], rel=2e-7)
