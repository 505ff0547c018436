"""The disc that paths through glass find in place of the sun: wider, at its place, of the same light."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glassware.core.assets import asset
from glassware.procedural.description.surroundings import PictureEnvironment, SkyEnvironment
from glassware.procedural.surroundings.colour import luminance
from glassware.procedural.surroundings.shipped_light import shipped_maps
from glassware.procedural.surroundings.skies import sun_direction
from glassware.procedural.surroundings.sun import SUN_RADIUS
from glassware.procedural.surroundings.sun_glints import wide_sun


def sky(illuminance: float = 80.0, radius: float = SUN_RADIUS, **changes) -> SkyEnvironment:
    values = {"turbidity": 3.0, "cloudiness": 0.0, "ground": (0.2, 0.2, 0.2), "seed": 4, "sun_elevation": 0.8}
    return SkyEnvironment(sun_illuminance=illuminance, sun_radius=radius, **{**values, **changes})


@pytest.mark.parametrize("pixel", [1e-3, 2e-3, 1e-2])
@pytest.mark.parametrize("rotation", [0.0, 2.3])
def test_the_wide_disc_has_the_light_of_the_sun_at_its_place(pixel, rotation):
    environment = sky(rotation=rotation, strength=1.7)
    sun = wide_sun(environment, pixel)
    assert sun is not None
    radius = math.acos(sun.disc_cos)
    assert radius == pytest.approx(min(20.0 * pixel, math.radians(4.0)), rel=1e-5)
    # The sun's illuminance, with the map's sky within 2.5 degrees taken for the mean of the ring around it.
    assert luminance(sun.light) == pytest.approx(80.0 * environment.strength, rel=2e-3)
    cos, sin = math.cos(rotation), math.sin(rotation)
    expected = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ sun_direction(environment)
    assert math.degrees(math.acos(min(1.0, float(sun.direction @ expected)))) < 0.1


@pytest.mark.parametrize("environment", [sky(0.0), sky(radius=math.radians(5.0))], ids=["no sun", "wide sun"])
def test_a_sky_without_a_sun_or_with_a_wide_one_stays_as_it_is(environment):
    assert wide_sun(environment, 1e-3) is None


def test_a_low_sun_is_not_spread_below_the_horizon():
    (sunrise,) = (path for path in shipped_maps() if path.stem == "sunrise")
    low, high = wide_sun(PictureEnvironment(asset=asset(sunrise)), 1e-3), wide_sun(sky(), 1e-3)
    assert low is not None
    assert high is not None
    # The map shows it 8 degrees above the horizon.
    assert low.widest == pytest.approx(math.asin(low.direction[2])) == pytest.approx(math.radians(7.9), abs=2e-3)
    assert high.widest == pytest.approx(math.radians(8.0))
