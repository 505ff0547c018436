"""Following rays through glass: gathering those that are left changes nothing, and numbers stay uniform."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest

from glassware.render.cache.cache_points import cache_points_of
from glassware.render.cache.fill_cache import fill_cache
from glassware.render.cache.guiding import emission_map
from glassware.render.cache.irradiance_cache import cached_shader
from glassware.render.cache.trace_cached import rescaled_sample
from glassware.render.pictures.picture import camera_paths
from glassware.render.scene.loaded_scene import load
from glassware.render.scene.rays import pinhole

#: Chance that uniform numbers fail.
SIGNIFICANCE = 1e-4


@pytest.fixture(scope="module")
def lit(backend, drawn):
    """Two glasses with their light stored, and rays of a small camera."""
    scene = drawn(31, vessel_count=(2, 2), prop_count=(1, 1), cameras={"views": 1, "width": 24, "height": 16})
    kernel = load(scene, for_cache=True)
    stored = fill_cache(kernel, cache_points_of(kernel), 4, 1, photons=1 << 14)  # noise changes no bit's equality
    bright = emission_map(scene)
    return kernel, cached_shader(kernel, stored, bright), bright


def _followed(lit, seed: int = 4, **changes) -> tuple[np.ndarray, ...]:
    from glassware.render.cache.trace_cached import CachedTracing, trace_cached

    kernel, surface, bright = lit
    camera, picture = kernel.description.cameras[0], kernel.description.picture.model_copy(update=changes)
    pixel = np.arange(camera.width * camera.height, dtype=np.uint32)
    ray, _, points = camera_paths(pinhole(camera), pixel, np.zeros_like(pixel), 16, 16, seed)
    found = trace_cached(CachedTracing(kernel, points, picture, surface, bright, None), ray)
    return np.array(found.radiance), np.array(found.violations), np.array(found.segments)


@pytest.fixture(scope="module")
def usual(lit) -> tuple[np.ndarray, ...]:
    return _followed(lit)


@pytest.mark.parametrize("surfaces", [2, *(pytest.param(n, marks=pytest.mark.slow) for n in (1, 13, 1024))])
def test_gathering_the_rays_that_are_left_changes_no_bit(lit, usual, monkeypatch, surfaces) -> None:
    from glassware.render.cache import trace_cached

    assert usual[2].max() > trace_cached.FIRST_PASS_SURFACES, "no path is long enough to be gathered"
    monkeypatch.setattr(trace_cached, "FIRST_PASS_SURFACES", surfaces)
    for one, other in zip(usual, _followed(lit), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("few", [20, *(pytest.param(n, marks=pytest.mark.slow) for n in (0, 1 << 20))])
def test_following_the_last_rays_to_their_ends_at_once_changes_no_bit(lit, usual, monkeypatch, few) -> None:
    from glassware.render.cache import trace_cached

    monkeypatch.setattr(trace_cached, "MIN_PATHS_PER_PASS", few)
    for one, other in zip(usual, _followed(lit), strict=True):
        np.testing.assert_array_equal(one, other)


def test_paths_end_at_the_longest_that_is_asked_for(lit) -> None:
    for longest in (1, 4, 9):
        assert _followed(lit, max_depth=longest)[2].max() == longest


def test_what_is_left_of_a_number_is_uniform_and_new_when_it_is_used_up(backend) -> None:
    import drjit as dr
    import mitsuba as mi

    count = 100_000
    bits = mi.sample_tea_32(dr.arange(mi.UInt32, count), 7)[0]
    chance, left = mi.Float(np.random.default_rng(8).uniform(size=count).astype(np.float32)), mi.Float(1.0)
    shares = np.ones(count)
    for mirrored in (0.04, 0.6, 0.3, 0.04, 0.5, 0.04, 0.1, 0.04):
        transmitted = chance >= mirrored
        share = dr.select(transmitted, 1.0 - mirrored, mirrored)
        chance, left = rescaled_sample(chance, left, share, transmitted, bits)
        shares *= np.array(share)
        assert kstest(np.array(chance, np.float64), "uniform").pvalue > SIGNIFICANCE
    assert (np.array(left) >= 2.0**-12).all()
    assert (shares < 2.0**-12).any(), "no number was used up"
