"""Skies as environments."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glassware.procedural.description.surroundings import SkyEnvironment
from glassware.procedural.surroundings.colour import luminance
from glassware.procedural.surroundings.preetham import sky_xyy, zenith_xyy
from glassware.procedural.surroundings.skies import bake_sky, disc_solid_angle, draw_sky, sun_direction
from glassware.procedural.surroundings.sphere import solid_angles, texel_directions
from glassware.procedural.surroundings.sun import SUN_RADIUS


def sky(**changes) -> SkyEnvironment:
    """A sky with a soft sun, as descriptions have that state no illuminance."""
    values = {
        "sun_elevation": math.radians(40),
        "sun_radiance": 0.0,
        "sun_radius": math.radians(4),
        "turbidity": 3.0,
        "cloudiness": 0.0,
        "ground": (0.2, 0.2, 0.2),
        "seed": 4,
    }
    return SkyEnvironment(**{**values, **changes})


def test_a_clear_sky_has_the_distribution_of_the_model():
    sunless = sky(sun_illuminance=0.0, sun_radius=SUN_RADIUS)
    pixels, directions = bake_sky(sunless, 256), texel_directions(512)
    high = _open_sky(directions, sun_direction(sunless))
    expected = sky_xyy(directions[high], sun_direction(sunless), 3.0)[:, 2]
    ratio = luminance(pixels[high]) / expected
    # The colour matrix has four digits, and blue beyond the gamut is cut off; the map is soft over a texel or two of
    # 0.7 degrees, the most at the pole.
    np.testing.assert_allclose(ratio, np.median(ratio), rtol=1e-2)


def test_a_description_without_an_illuminance_has_the_luminance_of_the_model():
    pixels, directions = bake_sky(sky(), 256), texel_directions(256)
    high = _open_sky(directions, sun_direction(sky()))
    expected = sky_xyy(directions[high], sun_direction(sky()), 3.0)[:, 2]
    np.testing.assert_allclose(luminance(pixels[high]), expected, rtol=5e-3)


def _open_sky(directions: np.ndarray, sun: np.ndarray) -> np.ndarray:
    """Above the trees, and away from the sun, where the model's glow has a peak that the map softens."""
    return (directions[..., 2] > 0.5) & (directions @ sun < math.cos(math.radians(10.0)))


def test_a_soft_sun_adds_its_disc_and_nothing_else():
    without, lit = bake_sky(sky(), 256), bake_sky(sky(sun_radiance=100.0), 256)
    extra = luminance(lit.astype(np.float64) - without)
    above = np.arange(256) < 100
    flux = (extra[above].sum(axis=1) * solid_angles(256)[above]).sum()
    zenith = zenith_xyy(math.sin(math.radians(40)), 3.0)[2]
    # About 80 texels across the disc, and the disc is taken as flat.
    assert flux == pytest.approx(100.0 * zenith * disc_solid_angle(math.radians(4)), rel=0.01)
    row, column = np.unravel_index(np.argmax(extra[above]), extra[above].shape)
    assert row == pytest.approx(256 * 50 / 180, abs=6)
    assert min(column, 512 - column) <= 6


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_clouds_cover_their_share_of_the_sky(share):
    clear, cloudy = bake_sky(sky(), 96), bake_sky(sky(cloudiness=share), 96)
    # Above 25 degrees, beyond haze and trees.
    rows = slice(0, 34)
    changed = np.abs(luminance(cloudy[rows]) / luminance(clear[rows]) - 1.0) > 0.05
    covered = (changed.mean(axis=1) * solid_angles(96)[rows]).sum() / solid_angles(96)[rows].sum()
    # The share is that of the whole half sphere; single clouds are up to a third of what is looked at.
    assert covered == pytest.approx(share, abs=0.25)


def test_more_clouds_hide_more_of_the_sky():
    clear = bake_sky(sky(), 48)[:17]
    hidden = [np.abs(bake_sky(sky(cloudiness=c), 48)[:17] / clear - 1.0).mean() for c in (0.1, 0.4, 0.8)]
    assert hidden == sorted(hidden)


def test_the_ground_reflects_what_falls_on_it():
    black = bake_sky(sky(ground=(0.0, 0.0, 0.0)), 64)
    grey = bake_sky(sky(ground=(0.3, 0.3, 0.3)), 64)
    assert black[48:].max() == 0.0
    # White under this light has E / pi; patches differ, their mean does not by more than a tenth.
    up = np.maximum(texel_directions(64)[..., 2], 0.0)
    clear = luminance(np.maximum(grey, 0.0))
    white = (clear * up * solid_angles(64)[:, None]).sum() / math.pi
    # Trees hide some of the sky near the horizon, where it hardly lights the ground.
    assert luminance(grey[48:]).mean() == pytest.approx(0.3 * white, rel=0.15)


def test_drawn_skies_are_finite_and_repeatable():
    for seed in range(6):
        drawn = draw_sky(np.random.default_rng(seed))
        assert drawn == draw_sky(np.random.default_rng(seed))
        pixels = bake_sky(drawn, 32)
        assert pixels.shape == (64, 128, 3)
        assert pixels.dtype == np.float32
        assert np.isfinite(pixels).all()
        assert pixels.min() >= 0.0
        np.testing.assert_array_equal(pixels, bake_sky(drawn, 32))


def test_the_map_closes_at_its_seam():
    pixels = luminance(bake_sky(sky(cloudiness=0.5), 128))[:56]
    seam = np.abs(pixels[:, 0] - pixels[:, -1]).mean()
    inside = np.abs(np.diff(pixels, axis=1)).mean()
    assert seam < 3.0 * inside
