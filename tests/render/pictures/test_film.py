"""The running sums of a picture against the same statistics taken from all its samples at once."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.render.pictures.film import Film

#: Sums in another order differ by rounding of float64.
ROUNDING = 1e-9


@pytest.fixture
def tally():
    return Film


@pytest.fixture
def groups() -> list[tuple[int, int, np.ndarray]]:
    """Groups of 3 colours: (pixel, size, mean), of unequal numbers and sizes."""
    rng = np.random.default_rng(5)
    sizes = {0: [2, 2, 4, 4, 4], 1: [2, 2], 2: [2, 4, 4]}
    return [(pixel, size, rng.gamma(2.0, size=3)) for pixel, all_sizes in sizes.items() for size in all_sizes]


def _added(made, groups):
    for size in (2, 4):
        some = [(pixel, mean) for pixel, n, mean in groups if n == size]
        counts = np.array([sum(pixel == k for pixel, _ in some) for k in range(3)])
        made.add(counts, size, np.array([size * mean for _, mean in some]).T)
    return made


def test_the_mean_weighs_each_group_by_its_samples(tally, groups):
    made = _added(tally(3), groups)
    for pixel in range(3):
        sizes, means = zip(*[(n, m) for k, n, m in groups if k == pixel], strict=True)
        assert made.samples[pixel] == sum(sizes)
        assert made.means[:, pixel] == pytest.approx(np.average(means, axis=0, weights=sizes), rel=ROUNDING)


def test_the_variance_is_that_of_a_weighted_mean(tally, groups):
    made = _added(tally(3), groups)
    for pixel in range(3):
        sizes, means = zip(*[(n, m) for k, n, m in groups if k == pixel], strict=True)
        n, m = np.array(sizes, float)[:, None], np.array(means)
        mean = (n * m).sum(0) / n.sum()
        expected = (n**2 * (m - mean) ** 2).sum(0) / (n.sum() ** 2 - (n**2).sum())
        assert made.variance[:, pixel] == pytest.approx(expected, rel=ROUNDING)


def test_the_variance_of_the_mean_is_right_on_the_average_for_groups_of_unequal_size(tally):
    # Normal samples of variance 1: the mean of 40 of them has the variance 1/40. 4000 pixels with 7 degrees of freedom
    # or more leave a standard error of at most sqrt(2 / 7 / 4000 / 3) = 0.5 %; four of these is the bound.
    rng, pixels = np.random.default_rng(9), 4000
    made = tally(pixels)
    for size, count in ((8, 3), (2, 8)):
        sums = rng.normal(10.0, 1.0, (3, pixels * count, size)).sum(-1)
        made.add(np.full(pixels, count), size, sums)
    assert made.variance.mean() * 40.0 == pytest.approx(1.0, rel=0.02)


def test_of_one_group_nothing_is_known(tally):
    made = tally(2)
    made.add(np.array([1, 1]), 4, np.ones((3, 2)))
    assert (made.variance == 0.0).all()
    assert made.noise(1.0) is None


def test_the_noise_is_the_root_of_the_mean_relative_variance(tally):
    made = tally(1)
    made.add(np.array([4]), 1, np.array([[1.0, 2.0, 3.0, 2.0]] * 3))
    # Variance of the mean: 2/3 over 4 samples; the mean is 2; exposure 0.5 makes white of it.
    assert made.noise(0.5) == pytest.approx(np.sqrt(0.25 * (2.0 / 3.0) / 4.0 / (1.0 + 0.01)), rel=ROUNDING)
