"""A film of air between two media, against the series of reflections in it."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.render.interfaces.air_film import film_reflectance, scatter_at_film
from glassware.render.interfaces.dielectric import InterfaceHit

GLASS, WATER = 1.52, 1.333


def _amplitudes(n_i: float, n_t: float, cos_i: np.ndarray, cos_t: np.ndarray) -> np.ndarray:
    """Return Fresnel's amplitudes, perpendicular and parallel, in the form of sines and tangents."""
    i, t = np.arccos(cos_i), np.arccos(cos_t)
    return np.stack([-np.sin(i - t) / np.sin(i + t), np.tan(i - t) / np.tan(i + t)])


def _series(before: float, behind: float, cos_i: np.ndarray) -> np.ndarray:
    """Return the reflectance of a film by following light through 200 reflections in it."""
    sine = before * np.sqrt(1.0 - cos_i**2)
    cos_air, cos_t = np.sqrt(1.0 - sine**2), np.sqrt(1.0 - (sine / behind) ** 2)
    first = _amplitudes(before, 1.0, cos_i, cos_air) ** 2
    second = _amplitudes(1.0, behind, cos_air, cos_t) ** 2
    found, inside = first.copy(), 1.0 - first
    for _ in range(200):
        inside = inside * second
        found += inside * (1.0 - first)
        inside = inside * first
    return found.mean(0)


@pytest.mark.parametrize(("before", "behind"), [(GLASS, WATER), (WATER, GLASS), (1.9, WATER)])
def test_reflectance_is_the_series_of_all_reflections_in_the_film(backend, before, behind):
    import mitsuba as mi

    critical = np.arcsin(1.0 / before)
    cos_i = np.cos(np.linspace(0.01, critical - 1e-3, 50))
    found = np.array(film_reflectance(mi.Float(cos_i.astype(np.float32)), mi.Float(before), mi.Float(behind)))
    np.testing.assert_allclose(found, _series(before, behind, cos_i), atol=2e-3)
    np.testing.assert_allclose(found[:40], _series(before, behind, cos_i[:40]), atol=2e-5)


def test_light_beyond_the_critical_angle_against_air_is_reflected_whatever_lies_behind(backend):
    import mitsuba as mi

    angle = np.arcsin(1.0 / GLASS) + np.array([1e-3, 0.1, 0.3, 0.7])
    cos_i = mi.Float(np.cos(angle).astype(np.float32))
    assert np.array_equal(np.array(film_reflectance(cos_i, mi.Float(GLASS), mi.Float(WATER))), np.ones(4))


def test_events_share_light_out_as_the_reflectance_says_and_follow_snell(backend):
    import drjit as dr
    import mitsuba as mi

    count, angle = 200_000, 0.5
    wi = mi.Vector3f(float(np.sin(angle)), 0.0, float(np.cos(angle)))
    coin = mi.Float(((np.arange(count) + 0.5) / count).astype(np.float32))
    up = mi.Normal3f(0.0, 0.0, 1.0)
    hit = InterfaceHit(wi, up, up, mi.Float(WATER / GLASS), mi.Float(0.0), coin, dr.zeros(mi.UInt32, count))
    event = scatter_at_film(hit, mi.Float(GLASS))
    transmitted = np.array(event.transmitted)
    assert 1.0 - transmitted.mean() == pytest.approx(_series(GLASS, WATER, np.cos([angle]))[0], abs=2e-5)
    directions = np.array(event.direction).T
    sine = GLASS * np.sin(angle) / WATER
    down, back = (-sine, 0.0, -np.sqrt(1.0 - sine**2)), (-np.sin(angle), 0.0, np.cos(angle))
    np.testing.assert_allclose(directions, np.where(transmitted[:, None], down, back), atol=1e-5)
    np.testing.assert_allclose(np.array(event.weight)[transmitted], (GLASS / WATER) ** 2, rtol=1e-5)
