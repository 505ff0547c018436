"""Fireflies are spread over pixels with noise like theirs, not clamped: light is kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from glassware.render.pictures.fireflies import spread_fireflies
from glassware.render.pictures.guides import Guides
from glassware.render.pictures.picture import NoisyImage, PictureNoise, denoise_image

#: float32 sums over a picture of 64 x 48.
SUM_ROUNDING = 1e-5
#: An exposure at which even a firefly of 500 is dim where it is spread: it bleaches nothing.
DIM = 1e-4


@pytest.fixture
def noisy(rng):
    radiance = rng.uniform(0.4, 0.6, size=(48, 64, 3)).astype(np.float32)
    return radiance, np.full_like(radiance, 0.05**2)


@pytest.fixture
def plain() -> Guides:
    """One grey wall that faces the camera."""
    return grey(48, 64)


def grey(height: int, width: int) -> Guides:
    none = np.zeros((height, width), bool)
    return Guides(
        np.full((height, width, 3), 0.5),
        np.full((height, width, 3), 0.577),
        none,
        none,
        none,
        np.zeros((height, width), np.uint32),
    )


@pytest.mark.parametrize("place", [(20, 30), (0, 0), (47, 63), (0, 31)])
def test_a_firefly_is_gone_and_its_light_is_not(noisy, plain, place):
    radiance, variance = noisy
    radiance[place], variance[place] = (500.0, 300.0, 100.0), np.square((500.0, 300.0, 100.0))
    spread, _, _ = spread_fireflies(radiance, variance, plain, DIM)
    # The kernel of radius 4 px has the sum 26.2, of which a corner has a third. The firefly's own weight is larger than
    # that of its neighbours; it keeps less than an eighth.
    assert spread[place].max() < 500.0 / 8.0
    np.testing.assert_allclose(spread.sum((0, 1)), radiance.sum((0, 1)), rtol=SUM_ROUNDING)


def test_a_firefly_that_would_bleach_a_wall_stays_where_it_is(noisy, plain):
    """Spread, the sun in one pixel at the edge of a box of seed 208 was a halo that made the box 18 % too bright."""
    radiance, variance = noisy
    radiance[20, 30], variance[20, 30] = (500.0, 300.0, 100.0), np.square((500.0, 300.0, 100.0))
    rest, _, glints = spread_fireflies(radiance, variance, plain, 1.0)
    np.testing.assert_allclose(rest + glints, radiance, rtol=1e-6)
    assert rest[20, 30].max() < 1.0
    others = np.ones((48, 64), bool)
    others[20, 30] = False
    np.testing.assert_array_equal(rest[others], radiance[others])


def test_what_is_bright_in_every_group_of_samples_is_left_alone(noisy, plain):
    radiance, variance = noisy
    radiance[20, 30], variance[20, 30] = 500.0, 50.0**2  # a lamp's image: a tenth of its value in doubt
    np.testing.assert_array_equal(spread_fireflies(radiance, variance, plain, 1.0)[0], radiance)


def test_a_picture_of_one_sample_of_which_nothing_is_known_is_left_alone(noisy, plain):
    radiance, variance = noisy
    radiance[20, 30] = 500.0
    np.testing.assert_array_equal(spread_fireflies(radiance, np.zeros_like(variance), plain, 1.0)[0], radiance)


def test_noise_on_an_edge_is_no_firefly(noisy, plain):
    radiance, variance = noisy
    radiance[:, 32:] *= 100.0
    variance[:, 32:] *= 100.0**2
    np.testing.assert_array_equal(spread_fireflies(radiance, variance, plain, 1.0)[0], radiance)


@pytest.fixture
def with_firefly(noisy):
    radiance, variance = noisy
    radiance[20, 30], variance[20, 30] = (500.0, 300.0, 100.0), np.square((500.0, 300.0, 100.0))
    return radiance, variance


def test_pixels_without_noise_get_no_light(with_firefly, plain):
    radiance, variance = with_firefly
    variance[:, 32:] = 0.0
    spread, _, _ = spread_fireflies(radiance, variance, plain, DIM)
    np.testing.assert_array_equal(spread[:, 32:], radiance[:, 32:])
    np.testing.assert_allclose(spread.sum((0, 1)), radiance.sum((0, 1)), rtol=SUM_ROUNDING)


@pytest.fixture
def two_glasses(plain) -> Guides:
    """A glass of 16 x 16 px, and another one to its right."""
    instance = np.zeros((48, 64), np.uint32)
    instance[12:28, 22:38], instance[12:28, 38:54] = 2, 3
    return replace(plain, glass=instance > 0, instance=instance)


def test_a_firefly_in_glass_is_spread_over_the_same_glass(noisy, two_glasses):
    radiance, variance = noisy
    radiance[20, 36], variance[20, 36] = (5.0, 3.0, 1.0), np.square((5.0, 3.0, 1.0))
    spread, _, glints = spread_fireflies(radiance, variance, two_glasses, 0.5)
    assert not glints.any()
    assert spread[20, 36].max() < 5.0 / 3.0
    np.testing.assert_allclose(spread.sum((0, 1)), radiance.sum((0, 1)), rtol=SUM_ROUNDING)
    others = two_glasses.instance != 2
    np.testing.assert_array_equal(spread[others], radiance[others])
    assert (spread[18:22, 33:36] > radiance[18:22, 33:36]).all()


def test_a_firefly_on_the_outline_of_a_glass_stays_on_it(noisy, two_glasses):
    """A rim shines where the rest of a glass is dark: spread inwards, it made a glass of seed 207 8 % too bright."""
    radiance, variance = noisy
    radiance[12, 30], variance[12, 30] = (5.0, 3.0, 1.0), np.square((5.0, 3.0, 1.0))
    spread, _, glints = spread_fireflies(radiance, variance, two_glasses, 0.5)
    assert not glints.any()
    np.testing.assert_array_equal(spread[13:27, 23:37], radiance[13:27, 23:37])
    assert (spread[12, 28:33] > radiance[12, 28:33])[[0, 1, 3, 4]].all()
    np.testing.assert_allclose(spread.sum((0, 1)), radiance.sum((0, 1)), rtol=SUM_ROUNDING)


def test_a_firefly_that_would_bleach_its_glass_stays_where_it_is(with_firefly, two_glasses):
    radiance, variance = with_firefly
    rest, less, glints = spread_fireflies(radiance, variance, two_glasses, 0.5)
    np.testing.assert_allclose(rest + glints, radiance, rtol=1e-6)
    assert rest[20, 30].mean() == pytest.approx(np.median(radiance[18:23, 28:33].mean(axis=2)), rel=1e-5)
    assert less[20, 30].max() < 1e-4 * variance[20, 30].max()
    others = np.ones((48, 64), bool)
    others[20, 30] = False
    assert not glints[others].any()


def test_glass_gets_nothing_of_fireflies_beside_it(with_firefly, two_glasses):
    radiance, variance = with_firefly
    moved = replace(two_glasses, glass=np.roll(two_glasses.glass, 12, axis=1))
    beside, _, glints = spread_fireflies(radiance, variance, moved, DIM)
    assert not glints.any()
    np.testing.assert_array_equal(beside[moved.glass], radiance[moved.glass])
    assert beside[20, 27].sum() > radiance[20, 27].sum()


def test_another_side_of_a_body_gets_next_to_nothing(with_firefly, plain):
    radiance, variance = with_firefly
    normal = plain.normal.copy()
    normal[:, 32:] = (1.0, 0.0, 0.0)
    spread, _, _ = spread_fireflies(radiance, variance, replace(plain, normal=normal), DIM)
    given = np.maximum(spread - radiance, 0.0)
    # The normals are 0.92 apart: a weight of exp(-0.5 (0.92 / 0.25)^2) = 0.0012 against 1, over about as many pixels.
    assert given[:, 32:].sum() < 2e-3 * given[:, :32].sum()


def test_the_light_has_no_border():
    radiance, variance = np.full((128, 256, 3), 0.5, np.float32), np.full((128, 256, 3), 0.05**2, np.float32)
    radiance[64, 128], variance[64, 128] = 500.0, 500.0**2
    spread, _, _ = spread_fireflies(radiance, variance, grey(128, 256), DIM)
    given = (spread - radiance)[64, 129:, 0]
    assert (np.diff(given) <= 0.0).all()
    # The biweight kernel of radius 16 px falls to (1 - (16 / 17)^2)^2 = 0.013 at its last pixel.
    ends = given[given > 0.0]
    assert ends[-1] < 0.02 * ends[0]


def test_fireflies_that_stay_are_removed_where_a_scene_asks_for_it(noisy, plain):
    radiance, variance = noisy
    radiance[20, 30], variance[20, 30] = (500.0, 300.0, 100.0), np.square((500.0, 300.0, 100.0))
    image = NoisyImage(radiance, variance, plain, PictureNoise(spp=16, noise=None), 1.0, 0.0)
    kept, removed = denoise_image(image), denoise_image(image, "remove")
    assert kept[20, 30].max() > 400.0
    assert removed.max() < 1.0
    changed = (kept != removed).any(axis=2)
    assert changed[20, 30]
    assert changed.sum() == 1
