"""The light on the table, against closed forms and chance."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glassware.procedural.description.surroundings import AreaLight
from glassware.procedural.surroundings.colour import luminance
from glassware.procedural.surroundings.lights import aimed
from glassware.procedural.surroundings.metering import exposure, form_factor, irradiance
from glassware.procedural.surroundings.sphere import cosine_weights, solid_angles, texel_directions

# Rounding of float64 sums.
EXACT = 1e-12
# Four standard errors of a million samples whose spread is at most their mean.
CHANCE = 4e-3
DARK = np.zeros((4, 8, 3), dtype=np.float32)


def light(centre, target=(0.0, 0.0, 0.0), size=(0.5, 0.3), turn=0.4, radiance=(1.0, 2.0, 3.0)) -> AreaLight:
    return AreaLight(
        world_T_light=aimed(np.array(centre, float), np.array(target, float), turn), size=size, radiance=radiance
    )


def sampled_form_factor(item: AreaLight, count: int = 1_000_000) -> float:
    rng = np.random.default_rng(1)
    local = np.zeros((count, 4))
    local[:, :2] = (rng.uniform(size=(count, 2)) - 0.5) * item.size
    local[:, 3] = 1.0
    points = (local @ item.world_T_light.T)[:, :3]
    squared = (points**2).sum(axis=1)
    here = np.maximum(points[:, 2], 0.0) / np.sqrt(squared)
    there = np.maximum(-points @ item.world_T_light[:3, 2], 0.0) / np.sqrt(squared)
    return float((here * there / squared).mean() * item.size[0] * item.size[1] / math.pi)


def test_an_even_environment_gives_pi_times_its_radiance():
    pixels = np.full((32, 64, 3), (0.5, 1.0, 2.0), dtype=np.float32)
    np.testing.assert_allclose(irradiance(pixels, 1.0, ()), np.pi * np.array([0.5, 1.0, 2.0]), rtol=EXACT)


def test_what_lies_below_the_table_gives_no_light():
    pixels = np.zeros((33, 66, 3), dtype=np.float32)
    pixels[17:] = 1.0
    assert irradiance(pixels, 1.0, ()) == pytest.approx(0.0, abs=EXACT)


def test_strength_scales_and_rotation_changes_nothing():
    pixels = np.random.default_rng(0).uniform(size=(16, 32, 3)).astype(np.float32)
    once = irradiance(pixels, 1.0, ())
    np.testing.assert_allclose(irradiance(pixels, 2.5, ()), 2.5 * once, rtol=EXACT)
    np.testing.assert_allclose(irradiance(np.roll(pixels, 5, axis=1), 1.0, ()), once, rtol=EXACT)


def test_the_environment_integral_agrees_with_random_directions():
    pixels = np.random.default_rng(0).uniform(size=(16, 32, 3))
    rng = np.random.default_rng(2)
    # Cosine-distributed directions: their mean radiance times pi is the irradiance.
    theta, phi = np.arccos(np.sqrt(rng.uniform(size=1_000_000))), rng.uniform(0, 2 * np.pi, size=1_000_000)
    rows, columns = (theta / np.pi * 16).astype(int), (phi / (2 * np.pi) * 32).astype(int)
    expected = np.pi * pixels[rows, columns].mean(axis=0)
    np.testing.assert_allclose(irradiance(pixels, 1.0, ()), expected, rtol=CHANCE)


def test_texels_cover_the_sphere_and_its_projection():
    assert solid_angles(64).sum() * 128 == pytest.approx(4 * np.pi, rel=EXACT)
    assert cosine_weights(64).sum() * 128 == pytest.approx(np.pi, rel=EXACT)


def test_directions_follow_the_documented_layout():
    directions = texel_directions(8)
    assert directions.shape == (8, 16, 3)
    assert directions[0, 0, 2] > 0.9
    expected = [math.cos(math.pi / 16), math.sin(math.pi / 16)]
    np.testing.assert_allclose(directions[4, 0, :2] / np.hypot(*directions[4, 0, :2]), expected, rtol=1e-6)


def test_an_endless_ceiling_fills_half_the_sphere():
    ceiling = light((0.0, 0.0, 1.0), size=(1e6, 1e6), radiance=(1.0, 1.0, 1.0))
    # What is missing subtends about the height over the half width: 2e-6.
    np.testing.assert_allclose(irradiance(DARK, 1.0, (ceiling,)), np.pi, rtol=1e-5)


def test_a_small_far_rectangle_follows_the_inverse_square():
    centre = np.array([3.0, -2.0, 4.0])
    small = light(centre, target=(0.5, 0.0, 0.0), size=(0.02, 0.01), radiance=(1.0, 2.0, 3.0))
    squared = centre @ centre
    there = -centre @ small.world_T_light[:3, 2] / math.sqrt(squared)
    expected = np.array([1.0, 2.0, 3.0]) * 2e-4 * (centre[2] / math.sqrt(squared)) * there / squared
    # The rectangle's size over its distance, squared: 2e-5.
    np.testing.assert_allclose(irradiance(DARK, 1.0, (small,)), expected, rtol=1e-4)


def test_a_parallel_rectangle_over_its_corner_follows_the_closed_form():
    # Patch to parallel rectangle a x b at distance c, under its corner (Howell, catalogue of configuration factors).
    a, b, c = 0.7, 0.4, 0.9
    x, y = a / c, b / c
    corner = (
        x / math.sqrt(1 + x * x) * math.atan(y / math.sqrt(1 + x * x))
        + y / math.sqrt(1 + y * y) * math.atan(x / math.sqrt(1 + y * y))
    ) / (2 * math.pi)
    whole = light((0.0, 0.0, c), size=(2 * a, 2 * b), turn=0.0)
    assert form_factor(whole) == pytest.approx(4 * corner, rel=EXACT)


@pytest.mark.parametrize("centre", [(0.3, 0.2, 0.8), (1.0, 0.0, 0.1), (0.6, -0.6, 0.0)])
def test_the_form_factor_agrees_with_random_points_even_across_the_horizon(centre):
    item = light(centre, size=(0.8, 0.6))
    assert form_factor(item) == pytest.approx(sampled_form_factor(item), rel=2 * CHANCE)


def test_a_rectangle_that_faces_away_or_lies_below_gives_nothing():
    assert form_factor(light((0.0, 0.0, 1.0), target=(0.0, 0.0, 2.0))) == 0.0
    assert form_factor(light((0.0, 0.0, -1.0))) == 0.0


def test_a_grey_card_is_encoded_at_its_reflectance():
    lit = np.array([2.0, 3.0, 4.0])
    card = 0.18 * lit / np.pi
    assert luminance(card * exposure(lit)) == pytest.approx(0.18, rel=EXACT)


def test_no_light_has_no_exposure():
    with pytest.raises(ValueError, match="expected light"):
        exposure(np.zeros(3))
