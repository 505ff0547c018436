from __future__ import annotations

import numpy as np
import pytest

from glassware.core.images import srgb8
from glassware.dataset.cameras.colour import balance, encoded, from_sensor, to_sensor
from glassware.dataset.cameras.model import ColourCamera
from glassware.dataset.cameras.presets import CAMERAS

PHONE = CAMERAS["phone"]


def seen_by(camera: ColourCamera, colour: np.ndarray) -> np.ndarray:
    return np.broadcast_to(to_sensor(camera) @ colour, (8, 8, 3)).astype(np.float32)


def test_a_grey_card_under_coloured_light_is_grey_after_white_balance() -> None:
    camera = PHONE.model_copy(update={"white_balance": 1.0, "white_balance_error": 0.0})
    card = seen_by(camera, 0.18 * np.array([1.5, 1.0, 0.6]))
    balanced = card[0, 0] * balance(camera, card, np.random.default_rng(0))
    assert balanced == pytest.approx(np.full(3, balanced[1]), rel=1e-6)
    picture = from_sensor(camera)[1] @ balanced
    assert picture == pytest.approx(np.full(3, picture[1]), rel=1e-6)


def test_without_balancing_daylight_is_white_and_colours_come_back() -> None:
    camera = PHONE.model_copy(update={"white_balance": 0.0, "white_balance_error": 0.0})
    for colour in ([1.0, 1.0, 1.0], [0.4, 0.2, 0.1], [0.1, 0.3, 0.6]):
        signal = seen_by(camera, np.array(colour))
        gains = balance(camera, signal, np.random.default_rng(0))
        assert from_sensor(camera)[1] @ (gains * signal[0, 0]) == pytest.approx(colour, rel=1e-5)
    assert to_sensor(camera)[1].sum() == pytest.approx(1)  # white saturates green


def test_a_part_of_the_balance_is_that_part_of_the_logarithm() -> None:
    def red(part: float) -> float:
        camera = ColourCamera(name="own", white_balance=part)
        return balance(camera, seen_by(camera, np.array([0.3, 0.2, 0.2])), np.random.default_rng(0))[0]

    assert red(1.0) == pytest.approx(2 / 3)
    assert red(0.5) == pytest.approx(np.sqrt(2 / 3))


def test_the_tone_curve_is_srgb_and_the_smooth_step_on_top_of_it() -> None:
    linear = np.linspace(0, 1, 999, dtype=np.float32).reshape(9, 37, 3)
    assert np.abs(encoded(linear, 0.0).astype(int) - srgb8(linear, 1.0)).max() <= 1  # of 2^14 entries
    y = srgb8(linear, 1.0) / 255
    assert np.abs(encoded(linear, 1.0) / 255 - (3 * y**2 - 2 * y**3)).max() < 1.5 * 1.5 / 255  # its slope is up to 1.5
