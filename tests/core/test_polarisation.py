from __future__ import annotations

import numpy as np
import pytest

from glassware.core.polarisation import (
    angle_of_linear_polarisation,
    behind_filter,
    degree_of_linear_polarisation,
    degree_of_polarisation,
)


def linear(angle: float, level: float = 1.0) -> np.ndarray:
    """Light that is wholly polarised along an angle [rad]."""
    return level * np.array([1.0, np.cos(2 * angle), np.sin(2 * angle), 0.0])[:, None]


@pytest.mark.parametrize("angle", [-1.2, 0.0, 0.3, 1.5])
def test_polarised_light_behind_an_ideal_filter_follows_maluss_law(angle):
    axes = np.linspace(-np.pi, np.pi, 25)
    light = np.array([behind_filter(linear(angle, 3.0), axis)[0] for axis in axes])
    np.testing.assert_allclose(light, 3.0 * np.cos(axes - angle) ** 2, atol=1e-12)


def test_a_filter_passes_light_along_and_across_its_axis_in_its_extinction_ratio():
    along, across = (behind_filter(linear(angle), 0.4, 250.0)[0] for angle in (0.4, 0.4 + np.pi / 2))
    assert along / across == pytest.approx(250.0, rel=1e-9)
    assert along == pytest.approx(1.0, rel=1e-12)


def test_a_filter_passes_half_of_unpolarised_light():
    unpolarised = np.array([2.0, 0.0, 0.0, 0.0])[:, None]
    assert behind_filter(unpolarised, 0.7)[0] == pytest.approx(1.0)


def test_degree_and_angle_of_a_vector():
    vector = np.array([2.0, 0.6, -0.8, 1.0])[:, None]
    assert degree_of_linear_polarisation(vector)[0] == pytest.approx(0.5)
    assert degree_of_polarisation(vector)[0] == pytest.approx(np.sqrt(2.0) / 2)
    assert angle_of_linear_polarisation(linear(0.9))[0] == pytest.approx(0.9)
    assert degree_of_linear_polarisation(np.zeros((4, 1)))[0] == 0.0
