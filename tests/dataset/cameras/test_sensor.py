from __future__ import annotations

import numpy as np
import pytest

from glassware.dataset.cameras.model import Sensor
from glassware.dataset.cameras.sensor import demosaiced, exposed, mosaic, noise_variance, summed_pixels

SENSOR = Sensor(width=1920, full_well=6000, read_noise=3, gain=(1, 1), bits=10, black_level=0.0625)
DRAWS = 40_000
#: Six standard errors: of a mean, and of a variance of Gaussian values (sqrt(2 / n)).
MEAN_ERROR, VARIANCE_ERROR = 6 / np.sqrt(DRAWS), 6 * np.sqrt(2 / DRAWS)


@pytest.mark.parametrize("gain", [1.0, 8.0])
@pytest.mark.parametrize("pixels", [1.0, 9.0])
def test_mean_and_variance_over_a_ramp_are_those_of_the_photon_transfer(gain: float, pixels: float) -> None:
    rng = np.random.default_rng(3)
    for level in (0.0, 0.01, 0.05, 0.2, 0.5, 0.8):
        found = exposed(np.full((DRAWS // 100, 100), level, np.float32), SENSOR, gain, rng, pixels)
        expected = noise_variance(np.array(level), SENSOR, gain, pixels)
        step = 1 / 1023 / (1 - 0.0625)
        if np.sqrt(expected) < step:  # finer noise is not spread evenly over a step
            assert found.mean() == pytest.approx(level, abs=step / 2)
        else:
            assert found.mean() == pytest.approx(level, abs=MEAN_ERROR * np.sqrt(expected))
            assert found.var() == pytest.approx(expected, rel=VARIANCE_ERROR)


def test_saturated_pixels_are_one_and_dark_ones_may_be_below_zero() -> None:
    rng = np.random.default_rng(4)
    assert np.all(exposed(np.full((50, 50), 3.0, np.float32), SENSOR, 4, rng) == pytest.approx(1, abs=1e-6))
    assert exposed(np.zeros((50, 50), np.float32), SENSOR, 16, rng).min() < 0


@pytest.mark.parametrize("size", [(12, 16), (13, 15)])
def test_mosaic_and_demosaicing_keep_an_even_colour(size: tuple[int, int]) -> None:
    colour = np.array([0.2, 0.7, 0.5], np.float32)
    picture = np.broadcast_to(colour, (*size, 3))
    assert np.abs(demosaiced(mosaic(picture)) - colour).max() < 1e-6


def test_demosaicing_keeps_what_the_mosaic_saw_and_linear_ramps() -> None:
    y, x = np.mgrid[:20, :24].astype(np.float32)
    picture = np.dstack([0.3 + 0.01 * x, 0.1 + 0.02 * y, 0.8 - 0.01 * x]).astype(np.float32)
    seen = mosaic(picture)
    assert np.array_equal(seen[::2, ::2], picture[::2, ::2, 0])
    assert np.array_equal(seen[::2, 1::2], picture[::2, 1::2, 1])
    assert np.array_equal(seen[1::2, 1::2], picture[1::2, 1::2, 2])
    grey = np.repeat((0.2 + 0.01 * x + 0.02 * y)[..., None], 3, axis=2)
    assert np.abs(demosaiced(mosaic(grey)) - grey)[2:-2, 2:-2].max() < 1e-5


def test_pictures_of_few_pixels_sum_whole_cells_of_the_mosaic() -> None:
    assert summed_pixels(SENSOR, 1280) is None
    assert summed_pixels(SENSOR, 640) == pytest.approx([9 / 4, 9 / 2, 9 / 4])
