"""What opaque surfaces make of the stored light: gloss that costs little and is not noisy for it."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.render.cache import irradiance_cache
from glassware.render.cache.cache_points import cache_points_of
from glassware.render.cache.fill_cache import fill_cache
from glassware.render.cache.trace_cached import cached_tracer
from glassware.render.pictures.picture import camera_paths
from glassware.render.scene.loaded_scene import load
from glassware.render.scene.rays import pinhole

#: Samples of a pixel that variances come from.
SAMPLES = 256


@pytest.fixture(scope="module")
def polished(backend, drawn):
    """A polished table that mirrors the windows of a room, its light stored."""
    camera = {"views": 1, "width": 48, "height": 32, "slack": (1.0, 1.0)}
    room = {"room_share": 1.0, "shipped_share": 0.0}
    scene = drawn(17, vessel_count=(1, 1), prop_count=(0, 0), cameras=camera, environment=room, lights={"max_count": 0})
    material = scene.table.material.model_copy(update={"roughness": 0.15})
    scene = scene.model_copy(update={"table": scene.table.model_copy(update={"material": material})})
    kernel = load(scene, for_cache=True)
    return kernel, fill_cache(kernel, cache_points_of(kernel), 16, 1)


def _samples_of(kernel, stored, seed: int) -> np.ndarray:
    """Return the luminance of every sample, (pixels, SAMPLES)."""
    import mitsuba as mi

    camera = kernel.description.cameras[0]
    pixel = np.arange(camera.width * camera.height, dtype=np.uint32)
    ray, weight, points = camera_paths(pinhole(camera), pixel, np.zeros_like(pixel), SAMPLES, SAMPLES, seed)
    found = cached_tracer(kernel, stored).trace(kernel, ray, weight, points, kernel.description.picture)
    return np.array(mi.luminance(found.radiance), np.float64).reshape(len(pixel), SAMPLES)


def test_a_mean_direction_is_no_longer_than_one_whatever_a_filter_leaves_of_its_light() -> None:
    rng = np.random.default_rng(2)
    light = rng.uniform(0.0, 3.0, (50, 1))
    direction = rng.normal(size=(50, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    grey = np.repeat(light, 3, axis=1)
    moments = np.concatenate([grey, 0.1 * grey, 0.6 * light * direction, 0.1 * light * direction], axis=1)
    found = irradiance_cache.normalised(moments)
    np.testing.assert_allclose(found[:, 6:9], 0.6 * direction, rtol=1e-6)
    np.testing.assert_allclose(found[:, 9:12], direction, rtol=1e-6)
    # What is left of the light that grazes is rounding, and the directions are not.
    moments[:, 3:6] = 7e-17
    moments[:, 9:12] *= 1e-3
    np.testing.assert_allclose(irradiance_cache.normalised(moments)[:, 9:12], direction, rtol=1e-6)


@pytest.mark.slow
def test_the_light_that_a_drawn_scene_stores_has_bounded_directions(backend, drawn) -> None:
    kernel = load(drawn(17, cameras={"views": 1, "width": 24, "height": 18}), for_cache=True)
    stored = fill_cache(kernel, cache_points_of(kernel), 6, 1)
    for _, vector in irradiance_cache.DIRECTIONS:
        assert np.linalg.norm(stored.moments[:, vector], axis=1).max() < 1.0 + 1e-5


@pytest.mark.slow
def test_roulette_leaves_no_window_out_that_a_polished_table_mirrors(polished, monkeypatch) -> None:
    played = _samples_of(*polished, seed=3)
    monkeypatch.setattr(irradiance_cache, "_MIN_SURVIVAL", 1.0)
    followed = _samples_of(*polished, seed=4)
    error = np.sqrt((played.var(1) + followed.var(1)) / SAMPLES)
    difference = (played.mean(1) - followed.mean(1)) / np.maximum(error, 1e-9)
    # Two ways of the same mean: over many pixels the mean of normal deviates, within four of its deviations.
    assert abs(difference.mean()) < 4.0 / np.sqrt(difference.size)
    # A bounce that is left out would have brought a third of the diffuse part at most. By its weight alone, roulette
    # left windows out as well: 3.4 times the variance here.
    assert played.var(1).mean() < 1.5 * followed.var(1).mean()
