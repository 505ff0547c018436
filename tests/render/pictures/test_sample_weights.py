"""More samples where glass is seen, and the same picture."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.stats import t as student

from glassware.core.errors import InputError
from glassware.render.pictures.picture import MIN_ADAPTIVE_SPP, trace_picture
from glassware.render.pictures.sample_weights import (
    SampleWeights,
    displayed_noise,
    first_counts,
    group_counts,
    remaining_counts,
)

#: Independent pictures of each kind, and the side of the blocks that are compared [px].
PICTURES, BLOCK = 10, 8
#: Chance that equal means fail with other seeds.
SIGNIFICANCE = 1e-3


@pytest.fixture
def counts():
    def counts(glass: np.ndarray, spp: int, size: int, polished: np.ndarray | None = None) -> np.ndarray:
        polished = np.zeros_like(glass) if polished is None else polished
        return group_counts(glass, polished, SampleWeights(glass=4.0, polished=2.0), spp / size)

    return counts


def _spot(height: int = 20, width: int = 30) -> np.ndarray:
    glass = np.zeros((height, width), bool)
    glass[8:12, 10:15] = True
    return glass


@pytest.mark.parametrize(("spp", "size"), [(4, 1), (8, 1), (16, 1), (64, 4), (100, 6)])
def test_all_samples_are_shared_out(counts, spp, size):
    shared = counts(_spot(), spp, size)
    assert shared.sum() == 600 * spp // size


def test_glass_and_what_touches_it_get_four_times_the_rest(counts):
    shared = counts(_spot(), 64, 4).reshape(20, 30)
    near = np.zeros((20, 30), bool)
    near[7:13, 9:16] = True
    # Whole groups: each pixel has its share or the next whole number, and the means are exact to one group.
    assert np.ptp(shared[near]) <= 1
    assert np.ptp(shared[~near]) <= 1
    assert shared[near].mean() / shared[~near].mean() == pytest.approx(4.0, rel=1.0 / shared[~near].sum() * near.size)


def test_polish_gets_its_share_and_glass_upon_polish_that_of_glass(counts):
    polished = np.zeros((20, 30), bool)
    polished[:, :14] = True
    shared = counts(_spot(), 256, 4, polished).reshape(20, 30)
    glass, near = np.zeros((2, 20, 30), bool)
    glass[7:13, 9:16], near[:, :15] = True, True
    rest = ~glass & ~near
    rounding = 1.0 / shared[rest].mean()  # whole groups: no mean is off by more than one
    assert shared[near & ~glass].mean() / shared[rest].mean() == pytest.approx(2.0, rel=rounding)
    assert shared[glass].mean() / shared[rest].mean() == pytest.approx(4.0, rel=rounding)


@pytest.mark.parametrize("everywhere", [False, True])
def test_a_picture_without_glass_or_full_of_it_is_sampled_evenly(counts, everywhere):
    assert (counts(np.full((9, 7), everywhere), 16, 1) == 16).all()


def test_every_pixel_gets_groups_enough_to_tell_its_noise(counts):
    mostly = np.ones((16, 16), bool)
    mostly[:4] = False
    for glass in (_spot(), mostly):
        assert counts(glass, MIN_ADAPTIVE_SPP, 1).min() >= 2


def test_noisy_glass_gets_more_of_the_same_number_of_samples():
    glass, weights = _spot(), SampleWeights(glass=4.0, polished=2.0)
    plain = group_counts(glass, np.zeros_like(glass), weights, 64)
    noise = np.where(np.arange(30) < 12, 0.01, 0.03) * np.ones((20, 1))
    wanted = group_counts(glass, np.zeros_like(glass), weights, 64, noise)
    assert wanted.sum() == plain.sum()
    first = first_counts(plain)
    rest = remaining_counts(wanted, first, int((plain - first).sum()))
    assert rest.min() >= 0
    assert (first + rest).sum() == plain.sum()
    both = (first + rest).reshape(20, 30)
    quiet, noisy = both[9:11, 10].mean(), both[9:11, 14].mean()
    # Three times the noise asks for 3^0.6 = 1.93 times the additional samples. Of 7 columns of glass and what touches
    # it, 4 have it; in the mean they get 3 more for each sample of the rest.
    less = 3.0 * 7.0 / (3.0 + 4.0 * 1.93)
    assert noisy / quiet == pytest.approx((1.0 + 1.93 * less) / (1.0 + less), rel=0.05)
    # What shows neither glass nor polish keeps its number.
    np.testing.assert_allclose(both[:5], plain.reshape(20, 30)[:5], atol=1)


def test_the_samples_of_a_pixel_do_not_decide_how_many_more_it_gets(rng):
    glass = _spot()
    means, variance = rng.uniform(0.2, 0.6, (20, 30)), np.full((20, 30), 1e-3)
    before = displayed_noise(means, variance, glass, 1.0)
    means[10, 12], variance[10, 12] = 50.0, 2500.0
    after = displayed_noise(means, variance, glass, 1.0)
    assert after[10, 12] == before[10, 12] > 0.0
    assert after[10, 13] > before[10, 13]
    assert not after[:5].any()


def test_noise_counts_as_it_is_displayed():
    glass = np.ones((8, 8), bool)
    # Noise of 0.01 about a level of 0.25: sRGB has the slope 1.055 / 2.4 * 0.25^(1 / 2.4 - 1) = 0.987 there.
    found = displayed_noise(np.full((8, 8), 0.5), np.full((8, 8), 4e-4), glass, 0.5)
    np.testing.assert_allclose(found, 0.00987, rtol=1e-3)
    # What is far above white is white, with any noise.
    assert not displayed_noise(np.full((8, 8), 9.0), np.ones((8, 8)), glass, 1.0).any()


@pytest.mark.parametrize("spp", [8, pytest.param(24, marks=pytest.mark.slow)])
def test_the_means_are_those_of_evenly_spread_samples(backend, loaded_glasses, spp):

    scene = loaded_glasses.description

    def blocks(adaptive: bool, seed: int) -> np.ndarray:
        picture = scene.picture.model_copy(update={"spp": spp, "adaptive": adaptive})
        kernel = replace(loaded_glasses, description=scene.model_copy(update={"picture": picture}))
        radiance = trace_picture(kernel, scene.cameras[0], "left", seed).radiance.astype(np.float64)
        height, width = (n // BLOCK * BLOCK for n in radiance.shape[:2])
        return radiance[:height, :width].reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean(axis=(1, 3))

    even, more = (
        np.array([blocks(adaptive, seed + 100 * adaptive) for seed in range(PICTURES)]) for adaptive in (False, True)
    )
    error = np.sqrt((even.var(0, ddof=1) + more.var(0, ddof=1)) / PICTURES)
    z = (more.mean(0) - even.mean(0)) / error
    # Welch's test; its degrees of freedom are at least PICTURES - 1. Bonferroni over all blocks and colours.
    assert np.abs(z).max() < student.isf(0.5 * SIGNIFICANCE / z.size, PICTURES - 1)
    # Over the whole picture as well: a small loss everywhere would not show in any one block.
    whole = (more.mean(axis=(1, 2)).mean(0) - even.mean(axis=(1, 2)).mean(0)) / np.sqrt(
        (even.mean(axis=(1, 2)).var(0, ddof=1) + more.mean(axis=(1, 2)).var(0, ddof=1)) / PICTURES
    )
    assert np.abs(whole).max() < student.isf(0.5 * SIGNIFICANCE / 3, PICTURES - 1)


def test_a_noise_target_takes_no_more_than_the_most_samples(loaded_glasses):

    scene = loaded_glasses.description
    picture = scene.picture.model_copy(update={"spp": 16, "noise": 1e-3, "max_spp": 6})
    kernel = replace(loaded_glasses, description=scene.model_copy(update={"picture": picture}))
    assert trace_picture(kernel, scene.cameras[0], "left", 1).sampling.spp == 6


def test_an_eye_that_a_camera_has_not_is_refused(loaded_glasses):
    eye: Any = "middle"
    with pytest.raises(InputError, match="eye: expected 'left' or 'right', found 'middle'"):
        trace_picture(loaded_glasses, loaded_glasses.description.cameras[0], eye, 1)
