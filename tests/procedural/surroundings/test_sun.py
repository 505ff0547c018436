"""The sun and the clear sky in photometric units."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glassware.procedural.description.surroundings import SkyEnvironment
from glassware.procedural.surroundings.colour import luminance
from glassware.procedural.surroundings.metering import irradiance
from glassware.procedural.surroundings.skies import bake_sky, sun_direction
from glassware.procedural.surroundings.sphere import solid_angles, texel_directions
from glassware.procedural.surroundings.sun import (
    SOLAR_ILLUMINANCE,
    SUN_RADIUS,
    air_mass,
    clear_daylight,
    disc_coverage,
    disc_luminance,
)

# A disc counted at 256 places a texel, then scaled to its solid angle.
DISC_ERROR = 1e-3


def clear_sky(elevation: float, illuminance: float, radius: float = SUN_RADIUS, **changes) -> SkyEnvironment:
    values = {"turbidity": 3.0, "cloudiness": 0.0, "ground": (0.2, 0.2, 0.2), "seed": 4}
    return SkyEnvironment(
        sun_elevation=math.radians(elevation), sun_illuminance=illuminance, sun_radius=radius, **{**values, **changes}
    )


def test_the_sun_is_as_large_as_the_real_one():
    # Astronomical Almanac: semidiameter at unit distance 959.63 arc seconds.
    assert math.degrees(SUN_RADIUS) * 3600.0 == pytest.approx(959.63, rel=1e-3)


@pytest.mark.parametrize(("elevation", "expected"), [(90.0, 1.0), (30.0, 1.994), (10.0, 5.59), (5.0, 10.32)])
def test_the_air_mass_is_that_of_the_tables(elevation, expected):
    # Kasten and Young 1989, table 2.
    assert air_mass(math.radians(elevation)) == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("turbidity", [2.0, 3.0, 5.0, 10.0])
@pytest.mark.parametrize("elevation", [1.0, 8.0, 30.0, 65.0, 90.0])
def test_no_more_light_reaches_the_ground_than_the_atmosphere(elevation, turbidity):
    light = clear_daylight(math.radians(elevation), turbidity)
    sine = math.sin(math.radians(elevation))
    assert light.beam > 0.0
    assert light.diffuse > 0.0
    assert light.beam * sine + light.diffuse < SOLAR_ILLUMINANCE * sine


def test_a_clear_day_has_the_illuminance_of_the_lighting_handbook():
    # IESNA Lighting Handbook, clear sky: 127.5 klx exp(-0.21 m) from the sun, 0.8 + 15.5 sqrt(sin h) klx from the sky.
    for elevation in (30.0, 45.0, 65.0):
        light, sine = clear_daylight(math.radians(elevation), 2.0), math.sin(math.radians(elevation))
        sun, sky = 127.5 * math.exp(-0.21 / sine), 0.8 + 15.5 * math.sqrt(sine)
        # Two models of the same air.
        assert light.beam == pytest.approx(sun, rel=0.05)
        assert light.diffuse == pytest.approx(sky, rel=0.2)


def test_a_low_sun_is_redder_and_haze_takes_its_light():
    high, low = clear_daylight(math.radians(60.0), 3.0), clear_daylight(math.radians(8.0), 3.0)
    assert low.colour[0] / low.colour[2] > 2.0 * high.colour[0] / high.colour[2]
    assert luminance(low.colour) == pytest.approx(1.0)
    beams = [clear_daylight(math.radians(30.0), turbidity).beam for turbidity in (2.0, 3.0, 4.0, 5.0)]
    assert beams == sorted(beams, reverse=True)


@pytest.mark.parametrize("radius", [SUN_RADIUS, math.radians(2.0), math.radians(5.0)])
@pytest.mark.parametrize("elevation", [0.3, 8.0, 45.0, 89.9, 90.0])
def test_the_disc_on_a_map_gives_its_illuminance(elevation, radius):
    coverage = disc_coverage(1024, math.radians(elevation), radius).astype(np.float64)
    sun = np.array([math.cos(math.radians(elevation)), 0.0, math.sin(math.radians(elevation))])
    rows = np.flatnonzero(coverage.any(axis=1))
    directions = texel_directions(1024, slice(rows[0], rows[-1] + 1)).astype(np.float64)
    weights = coverage[rows[0] : rows[-1] + 1] * solid_angles(1024)[rows[0] : rows[-1] + 1, None]
    facing = disc_luminance(100.0, radius) * (weights * (directions @ sun)).sum()
    assert facing == pytest.approx(100.0, rel=DISC_ERROR)
    # And it is where the sun is; at the pole texels are long, and their middles stand for their parts.
    middle = (weights[..., None] * directions).sum((0, 1))
    assert np.linalg.norm(middle / np.linalg.norm(middle) - sun) < 0.02 * SUN_RADIUS


@pytest.mark.parametrize("elevation", [30.0, 60.0])
def test_the_map_of_a_clear_sky_gives_the_light_of_a_clear_sky(elevation):
    light, sine = clear_daylight(math.radians(elevation), 3.0), math.sin(math.radians(elevation))
    dark = float(luminance(irradiance(bake_sky(clear_sky(elevation, 0.0)), 1.0, ())))
    lit = float(luminance(irradiance(bake_sky(clear_sky(elevation, light.beam)), 1.0, ())))
    # Trees hide some of the horizon and reflect a little.
    assert dark == pytest.approx(light.diffuse, rel=0.05)
    # In the sun they reflect some hundredths of a small part of the view.
    assert lit - dark == pytest.approx(light.beam * sine, rel=0.01)


def test_the_sun_alone_adds_its_illuminance():
    elevation, sky = 50.0, clear_sky(50.0, 90.0, ground=(0.0, 0.0, 0.0))
    extra = bake_sky(sky) - bake_sky(sky.model_copy(update={"sun_illuminance": 0.0}))
    directions = texel_directions(1024)
    near = (directions @ sun_direction(sky).astype(np.float32)) > math.cos(math.radians(1.0))
    alone = np.where(near[..., None], extra, 0.0)
    horizontal = float(luminance(irradiance(alone, 1.0, ())))
    assert horizontal == pytest.approx(90.0 * math.sin(math.radians(elevation)), rel=DISC_ERROR)


def test_a_cloud_takes_nearly_all_of_the_sun():
    # Over many skies that are mostly cloud, the sun is either hidden or free, and rarely between.
    left = []
    for seed in range(24):
        sky = clear_sky(55.0, 90.0, turbidity=2.0, cloudiness=0.7, seed=seed)
        brightest = float(luminance(bake_sky(sky, 64)).max())
        left.append(brightest / float(luminance(bake_sky(sky.model_copy(update={"cloudiness": 0.0}), 64)).max()))
    assert min(left) < 0.01
    assert np.median(left) < 0.1
    assert max(left) > 0.5


def test_a_softer_sun_gives_the_same_light():
    sharp, soft = (bake_sky(clear_sky(40.0, 80.0, radius)) for radius in (SUN_RADIUS, math.radians(2.0)))
    levels = [float(luminance(irradiance(pixels, 1.0, ()))) for pixels in (sharp, soft)]
    assert levels[1] == pytest.approx(levels[0], rel=DISC_ERROR)
    assert luminance(sharp).max() > 40.0 * luminance(soft).max()
