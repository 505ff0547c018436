"""The denoiser removes noise and reports errors; fireflies are spread, not clamped: light is kept."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.render.pictures.denoise import denoise, spread_fireflies

#: float32 sums over a picture of 64 x 48.
SUM_ROUNDING = 1e-5


def _even(height: int, width: int, value: float) -> np.ndarray:
    return np.full((height, width, 3), value, np.float32)


def test_noise_on_an_even_wall_goes(rng) -> None:
    noisy = (_even(64, 96, 0.5) * rng.uniform(0.5, 1.5, (64, 96, 1))).astype(np.float32)
    found = denoise(noisy, _even(64, 96, 0.5), _even(64, 96, 0.577))
    # A tenth of the deviation of 0.14 at most: it is told that colour and normal are even.
    assert found.std() < 0.014
    assert found.mean() == pytest.approx(noisy.mean(), rel=0.01)


def test_a_guide_of_another_size_is_an_error_and_no_black_picture() -> None:
    with pytest.raises(RuntimeError, match="Open Image Denoise"):
        denoise(_even(64, 96, 0.5), _even(32, 48, 0.5), _even(64, 96, 0.577))


@pytest.fixture
def noisy(rng):
    radiance = rng.uniform(0.4, 0.6, size=(48, 64, 3)).astype(np.float32)
    return radiance, np.full_like(radiance, 0.05**2)


@pytest.mark.parametrize("place", [(20, 30), (0, 0), (47, 63), (0, 31)])
def test_a_firefly_is_gone_and_its_light_is_not(noisy, place):
    radiance, variance = noisy
    radiance[place], variance[place] = (500.0, 300.0, 100.0), np.square((500.0, 300.0, 100.0))
    spread = spread_fireflies(radiance, variance)
    assert spread[place].max() < 25.0  # in a corner a quarter of the square of 9 x 9 is left to share it
    np.testing.assert_allclose(spread.sum((0, 1)), radiance.sum((0, 1)), rtol=SUM_ROUNDING)


def test_what_is_bright_in_every_group_of_samples_is_left_alone(noisy):
    radiance, variance = noisy
    radiance[20, 30], variance[20, 30] = 500.0, 50.0**2  # a lamp's image: a tenth of its value in doubt
    np.testing.assert_array_equal(spread_fireflies(radiance, variance), radiance)


def test_a_picture_of_one_sample_of_which_nothing_is_known_is_left_alone(noisy):
    radiance, variance = noisy
    radiance[20, 30] = 500.0
    np.testing.assert_array_equal(spread_fireflies(radiance, np.zeros_like(variance)), radiance)


def test_noise_on_an_edge_is_no_firefly(noisy):
    radiance, variance = noisy
    radiance[:, 32:] *= 100.0
    variance[:, 32:] *= 100.0**2
    np.testing.assert_array_equal(spread_fireflies(radiance, variance), radiance)
