"""White balance and highlights of 8-bit pictures."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.images import KNEE, Tone, balance_of, srgb8, toned


def test_a_soft_shoulder_changes_nothing_below_the_knee_and_reaches_white_where_it_is_stated() -> None:
    ramp = np.linspace(0.0, 14.0, 2801)[None, :, None].repeat(3, axis=2)
    soft = toned(ramp, 1.0, Tone(white=12.0))[0, :, 0]
    x = ramp[0, :, 0]
    np.testing.assert_array_equal(soft[x <= KNEE], x[x <= KNEE])
    rising = (x > KNEE) & (x <= 12.0)
    assert (np.diff(soft[rising]) > 0.0).all()
    assert soft[x >= 12.0] == pytest.approx(1.0, abs=1e-12)
    # Without a kink: the slope begins at 1.
    above = np.flatnonzero(rising)[:2]
    assert np.diff(soft[above])[0] / np.diff(x[above])[0] == pytest.approx(1.0, abs=0.15)


def test_balanced_to_a_light_a_grey_card_in_it_is_grey_and_as_bright() -> None:
    light = np.array([3.0, 2.0, 0.9])
    card = (0.18 * light)[None, None]
    shown = toned(card, 1.0, Tone(balance=balance_of(light)))[0, 0]
    assert np.ptp(shown) < 1e-12
    # The luminance of white is kept: factors weigh 1 together.
    assert np.dot([0.2126, 0.7152, 0.0722], balance_of(light)) == pytest.approx(1.0)


def test_grey_world_makes_the_mean_grey(rng) -> None:
    picture = rng.uniform(0.0, 0.6, (20, 30, 3)) * [1.0, 0.7, 0.4]
    mean = toned(picture, 1.0, Tone(balance="grey-world")).reshape(-1, 3).mean(axis=0)
    assert np.ptp(mean) < 1e-9


def test_no_tone_is_the_plain_curve() -> None:
    picture = np.array([[[0.1, 0.5, 3.0]]], np.float32)
    assert srgb8(picture, 0.5).tolist() == srgb8(picture, 0.5, Tone()).tolist() == [[[63, 137, 255]]]
