"""Denoising: noise goes, errors are reported, and what has no noise stays."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.render.pictures.denoise import blend, denoise, with_mean_of


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


def test_a_caustic_that_the_denoiser_removes_stays(rng):
    truth = _even(48, 64, 0.5)
    truth[20:28, 30:38] = 1.5
    noise = rng.normal(0.0, 0.02, truth.shape).astype(np.float32)
    found = blend(truth + noise, np.full_like(truth, 0.02**2), _even(48, 64, 0.5))
    # By the formula 99 % of the caustic's middle stays: 0.02^2 over 0.02^2 + 1, here averaged over the window.
    assert found[22:26, 32:36].mean() == pytest.approx(1.5, abs=0.02)


def test_noise_that_the_denoiser_removes_goes(rng):
    truth, sigma = _even(96, 128, 0.5), 0.05
    noisy = truth + rng.normal(0.0, sigma, truth.shape).astype(np.float32)
    found = blend(noisy, np.full_like(truth, sigma**2), truth)
    # The window averages 40 pixels: the estimate of the difference is 22 % off, which is the part of noise that stays.
    assert found.std() < 0.25 * sigma


def test_a_picture_without_known_noise_is_not_changed(rng):
    noisy = rng.uniform(0.0, 1.0, (24, 32, 3)).astype(np.float32)
    np.testing.assert_array_equal(blend(noisy, np.zeros_like(noisy), _even(24, 32, 0.5)), noisy)


def test_a_region_keeps_the_mean_of_the_noisy_picture(rng) -> None:
    inside = np.zeros((64, 64), bool)
    inside[16:48, 16:48] = True
    noisy = np.where(inside[..., None], rng.gamma(4.0, 0.25, (64, 64, 3)), 0.5).astype(np.float32)
    clean = np.where(inside[..., None], _even(64, 64, 0.9), 0.45).astype(np.float32)  # too dark
    found = with_mean_of(noisy, clean, inside, np.zeros((64, 64), int))
    assert found[inside].sum(0) == pytest.approx(noisy[inside].sum(0), rel=1e-5)
    # Gamma of shape 4 has a deviation of a half; a window averages some hundred pixels.
    assert found[inside].std() < 0.05
    np.testing.assert_array_equal(found[~inside], clean[~inside])


def test_light_that_the_denoiser_takes_off_one_object_is_not_given_to_another(rng) -> None:
    inside, instance = np.zeros((64, 64), bool), np.full((64, 64), 2)
    inside[16:48, 8:56] = True
    instance[:, 32:] = 3
    noisy = np.where(instance[..., None] == 2, 0.02, 1.0) * np.ones((64, 64, 3), np.float32)
    clean = noisy.copy()
    noisy[32, 34] = 200.0  # a glint beside the border
    found = with_mean_of(noisy.astype(np.float32), clean.astype(np.float32), inside, instance)
    np.testing.assert_array_equal(found[instance == 2], clean[instance == 2].astype(np.float32))
    lit = inside & (instance == 3)
    assert found[lit].sum() == pytest.approx(noisy[lit].sum(), rel=1e-5)


def test_what_is_returned_to_glass_goes_where_light_is() -> None:
    inside = np.ones((64, 64), bool)
    clean = np.full((64, 64, 3), 0.01, np.float32)
    clean[:, 32:] = 1.0
    noisy = clean * 1.1
    found = with_mean_of(noisy, clean, inside, np.zeros((64, 64), int))
    # 0.1 of the window's mean, which is nearly 1 there, is what black gets beside light: a hundredth of it.
    assert found[:, 24:32].max() < 0.03
    assert found.sum() == pytest.approx(noisy.sum(), rel=1e-4)
