from __future__ import annotations

import numpy as np

from glassware.core.images import srgb8
from glassware.learn.data.augment import augmented, hue_turn, linear, with_noise
from glassware.learn.data.settings import AugmentSettings

NOTHING = {
    "hue": 0.0,
    "exposure": 0.0,
    "balance": 0.0,
    "view_exposure": 0.0,
    "shot_noise": 0.0,
    "read_noise": 0.0,
    "blur": 0.0,
    "jpeg": (100, 100),
}


def flat(level: int, side: int = 256) -> np.ndarray:
    return np.full((2, side, side, 3), level, np.uint8)


def test_every_level_comes_back_from_linear_light():
    levels = np.arange(256, dtype=np.uint8)
    np.testing.assert_array_equal(srgb8(linear(levels), 1.0), levels)


def test_no_change_is_no_change(rng):
    pictures = rng.integers(0, 256, (2, 16, 16, 3), dtype=np.uint8)
    np.testing.assert_array_equal(augmented(pictures, AugmentSettings(probability=0.0), rng), pictures)
    smooth = flat(130)
    # JPEG at its best quality keeps a flat picture to a level.
    changed = augmented(smooth, AugmentSettings(**NOTHING), rng)
    assert np.abs(changed.astype(int) - smooth).max() <= 1


def test_exposure_is_shared_by_the_views_and_counted_in_stops(rng):
    gains = []
    for _ in range(200):
        first, second = augmented(flat(100, 16), AugmentSettings(**{**NOTHING, "exposure": 0.5}), rng)
        assert first.mean() == second.mean()
        gains.append(np.log2(linear(first).mean() / linear(np.array(100, np.uint8))))
    # Half a level of 8 bits at level 100 is 0.02 stops.
    assert -0.53 < min(gains) < -0.4
    assert 0.4 < max(gains) < 0.53


def test_noise_has_the_variance_of_light_and_of_the_dark(rng):
    count = 100_000
    for light in (0.0, 0.05, 0.8):
        noise = with_noise(np.full(count, light, np.float32), 0.05, 0.01, rng) - light
        expected = 0.05**2 * light + 0.01**2
        # A sample variance deviates by sqrt(2 / n) of itself; five of them.
        assert abs(noise.var() - expected) < 5 * np.sqrt(2 / count) * expected
        assert abs(noise.mean()) < 5 * np.sqrt(expected / count)


def test_views_differ_in_their_noise(rng):
    first, second = augmented(flat(100), AugmentSettings(**{**NOTHING, "shot_noise": 0.1}), rng)
    assert (first != second).any()


def test_a_turn_of_hues_keeps_grey_and_takes_red_to_green_to_blue():
    third = hue_turn(2.0 * np.pi / 3.0)
    np.testing.assert_allclose(third @ np.eye(3), np.roll(np.eye(3), 1, axis=0), atol=1e-6)
    for angle in (0.1, 1.0, 3.0):
        np.testing.assert_allclose(hue_turn(angle) @ np.ones(3), np.ones(3), atol=1e-6)
        np.testing.assert_allclose(hue_turn(angle) @ hue_turn(angle).T, np.eye(3), atol=1e-6)
