from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chisquare
from scipy.stats.qmc import Sobol

from glassware.render.pictures.sampler import hashed_seed, sample_4d, sobol, sobol_sampler

#: Chance that a right sampler fails one of these tests with another seed; these seeds pass or fail always.
SIGNIFICANCE = 1e-4
#: The same for correlations of n numbers, in standard deviations 1 / sqrt(n).
SIGMAS = 4.0


@pytest.fixture
def points(backend):
    """(pixels, indices, count, seed, set) -> the four coordinates, (n, 4)."""
    import drjit as dr
    import mitsuba as mi

    def draw(pixel, index, count, seed=1, number=0):
        index = np.asarray(index, np.uint32)
        pixel = np.broadcast_to(np.asarray(pixel, np.uint32), index.shape).copy()
        columns = sample_4d(
            sobol_sampler(mi.UInt32(pixel), mi.UInt32(index), count, seed), dr.opaque(mi.UInt32, number)
        )
        return np.stack([np.array(column, np.float64) for column in columns], axis=1)

    return draw


@pytest.mark.parametrize("m", [0, 1, 5, 10])
def test_the_sequence_is_that_of_scipy_up_to_its_order(backend, m):
    ours = sobol(1 << m).astype(np.float64) / 2.0**32
    theirs = Sobol(4, scramble=False, bits=32).random_base2(m)
    np.testing.assert_array_equal(ours[np.lexsort(ours.T)], theirs[np.lexsort(theirs.T)])


@pytest.mark.parametrize("number", [0, 1, 17])
def test_every_prefix_of_a_power_of_two_is_stratified_in_each_axis(points, number):
    drawn = points(3, np.arange(1024), 1024, number=number)
    for m in range(11):
        cells = np.floor(drawn[: 1 << m] * (1 << m)).astype(int)
        for axis in range(4):
            np.testing.assert_array_equal(np.sort(cells[:, axis]), np.arange(1 << m))


@pytest.mark.parametrize("number", [0, 1, 17])
def test_every_prefix_is_a_net_in_the_first_two_axes(points, number):
    drawn = points(3, np.arange(1024), 1024, number=number)
    for m in range(11):
        x, y = drawn[: 1 << m, :2].T
        for k in range(m + 1):
            cells = np.floor(x * (1 << k)) * (1 << (m - k)) + np.floor(y * (1 << (m - k)))
            np.testing.assert_array_equal(np.sort(cells), np.arange(1 << m))


def test_a_set_of_another_size_than_a_power_of_two_has_no_point_twice(points):
    drawn = points(3, np.arange(100), 100)
    assert len(np.unique(drawn[:, 0])) == 100


def test_coordinates_are_in_the_half_open_unit_interval(points):
    drawn = points(np.arange(1 << 16), np.zeros(1 << 16), 16)
    assert drawn.min() >= 0.0
    assert drawn.max() < 1.0


def test_points_beyond_the_table_are_stratified_anew(points):
    first, later = (points(3, start + np.arange(1024), 1 << 16) for start in (0, 1 << 14))
    np.testing.assert_array_equal(np.sort(np.floor(later[:, 0] * 1024)), np.arange(1024))
    assert not np.intersect1d(first[:, 0], later[:, 0]).size > 5  # of 2^24 values two in 1024 may coincide by chance


@pytest.mark.parametrize("axes", [(0, 1), (2, 3), (0, 3)])
def test_over_pixels_the_points_are_uniform(points, axes):
    count = 1 << 16
    drawn = points(np.arange(count), np.full(count, 5), 16)[:, axes]
    seen = np.histogram2d(*drawn.T, bins=16, range=((0, 1), (0, 1)))[0]
    assert chisquare(seen.ravel()).pvalue > SIGNIFICANCE


@pytest.mark.parametrize("other", ["next pixel", "next sample", "next set", "next seed", "far set"])
def test_what_should_be_independent_is_uncorrelated(points, other):
    count = 1 << 16
    pixel, index = np.arange(count), np.full(count, 5)
    one = points(pixel, index, 16)
    two = {
        "next pixel": lambda: points(pixel + 1, index, 16),
        # Samples of one pixel repel each other, by design; those of neighbours must not.
        "next sample": lambda: points(pixel + 1, index + 1, 16),
        "next set": lambda: points(pixel, index, 16, number=1),
        "next seed": lambda: points(pixel, index, 16, seed=2),
        "far set": lambda: points(pixel, index, 16, number=64),
    }[other]()
    correlation = np.corrcoef(one.T, two.T)[:4, 4:]
    assert np.abs(correlation).max() < SIGMAS / np.sqrt(count)


@pytest.mark.parametrize("number", [1, 2, 40])
def test_sets_of_one_pixel_are_independent_of_each_other(points, number):
    # A pair of sets, seen as one set of two dimensions, must not have the one's order in the other.
    count = 1 << 12
    one, two = points(9, np.arange(count), count), points(9, np.arange(count), count, number=number)
    for axis in range(4):
        seen = np.histogram2d(one[:, axis], two[:, axis], bins=8, range=((0, 1), (0, 1)))[0]
        assert chisquare(seen.ravel()).pvalue > SIGNIFICANCE


def test_seeds_of_walks_differ_for_every_path_and_event(backend):
    import mitsuba as mi

    pixel, index = np.mgrid[:256, :16].reshape(2, -1).astype(np.uint32)
    sets = sobol_sampler(mi.UInt32(pixel), mi.UInt32(index), 16, 7)
    seeds = np.stack([np.array(hashed_seed(sets, mi.UInt32(number))) for number in range(8)])
    # 32768 numbers of 32 bits: 0.125 pairs coincide by chance.
    assert len(np.unique(seeds)) >= seeds.size - 3
