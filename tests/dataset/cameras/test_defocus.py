from __future__ import annotations

import numpy as np
import pytest

from glassware.dataset.cameras.defocus import circle, defocused, disc, focused_at, right_depth

SIZE, FOCAL = 61, 600.0


def test_the_circle_of_confusion_is_that_of_the_thin_lens() -> None:
    f, number, focus, z, pitch = 0.05, 2.0, 1.5, 0.9, 1e-5
    image, of_z = f * focus / (focus - f), f * z / (z - f)  # distances behind the lens, 1/f = 1/z + 1/v
    expected = (f / number) * abs(of_z - image) / of_z / pitch
    found = circle(np.array([[z]]), f / number, focus, image / pitch)[0, 0]
    assert abs(found) == pytest.approx(expected, rel=1e-6)
    assert found < 0  # nearer than the plane in focus


@pytest.mark.parametrize("Z", [0.4, 2.0])
def test_a_point_becomes_a_disc_of_that_diameter_and_keeps_its_light(Z: float) -> None:
    light = np.zeros((SIZE, SIZE, 3), np.float32)
    light[SIZE // 2, SIZE // 2] = 1
    diameter = circle(np.full((SIZE, SIZE), Z), 0.015, 0.7, FOCAL)
    blurred = defocused(light, diameter)[..., 0]
    assert blurred.sum() == pytest.approx(1, rel=1e-4)
    lit = (blurred > blurred.max() / 2).sum()
    assert 2 * np.sqrt(lit / np.pi) == pytest.approx(abs(diameter[0, 0]), abs=0.3)  # whole pixels
    spread = ((np.arange(SIZE) - SIZE // 2) ** 2 * blurred.sum(axis=0)).sum()
    assert 4 * np.sqrt(spread) == pytest.approx(abs(diameter[0, 0]), rel=0.03)  # variance d^2 / 16, and pixels' own


def test_what_is_in_focus_stays_sharp_and_an_even_picture_even() -> None:
    rng = np.random.default_rng(2)
    light = rng.random((SIZE, SIZE, 3), np.float32)
    assert defocused(light, np.full((SIZE, SIZE), 0.9, np.float32)) is light
    assert np.array_equal(disc(0.5), [[1]])
    Z = np.where(np.arange(SIZE) < 30, 0.5, np.inf) * np.ones((SIZE, 1))
    even = defocused(np.full((SIZE, SIZE, 3), 0.3, np.float32), circle(Z, 0.01, 0.8, FOCAL))
    assert np.abs(even - 0.3).max() < 1e-5


def test_autofocus_takes_the_middle_of_the_view() -> None:
    Z = np.full((30, 30), np.inf)
    assert focused_at(Z) == np.inf
    Z[12:18, 12:18] = 0.6
    Z[:4] = 0.1
    assert focused_at(Z) == 0.6


def test_depth_of_the_right_picture_moves_by_disparity_and_fills_with_what_is_behind() -> None:
    Z = np.full((4, 40), 2.0, np.float32)
    Z[:, 20:30] = 0.5
    right = right_depth(Z, 4.0)  # disparities 2 and 8 px
    assert np.all(right[:, 12:22] == 0.5)
    assert np.all(right[:, :12] == 2.0)
    assert np.all(right[:, 22:] == 2.0)
    assert np.isinf(right_depth(np.full((2, 8), np.inf, np.float32), 4.0)).all()
