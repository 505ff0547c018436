"""The check of the irradiance cache finds what is wrong on one object, and only that object is path traced."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from glassware.core.mesh import Mesh
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import TABLE_ID
from glassware.procedural.primitives import bodies, scenes
from glassware.procedural.surroundings.colour import luminance
from glassware.render.cache import scene_cache
from glassware.render.cache.draft import draft_picture
from glassware.render.cache.light_check import BOUND, _luminances, regions_of
from glassware.render.cache.stored_caustics import path_tracer_with_caustics
from glassware.render.scene.loaded_scene import load


@pytest.fixture(scope="module")
def blocks(backend):
    """Two grey blocks on a board in even light, loaded for the cache."""
    camera = scenes.camera((0.4, 0.1, 0.35), width=96, height=72)
    props = [scenes.block(_at(x), scenes.matte(), id=number) for number, x in ((2, -0.06), (3, 0.06))]
    return load(scenes.scene((), (camera,), props=props, picture=Picture(spp=8), seed=4), for_cache=True)


def _at(x: float) -> Mesh:
    return bodies.box_mesh((0.05, 0.08, 0.06), "block", (0.0, x, 0.03))


@pytest.fixture(scope="module")
def cache(blocks):
    return scene_cache.fill_scene_cache(blocks)


def _brighter(blocks, cache, id: int, factor: float):
    """Return the cache with the light of one object changed."""
    instance = np.array(blocks.surfaces.instance)
    moments, start = cache.moments.copy(), cache.points.grid_count
    for number, body in enumerate(blocks.opaque_bodies):
        if instance[body.row] == id:
            moments[start + np.flatnonzero(cache.points.mesh == number), :6] *= factor
    return replace(cache, moments=moments)


def test_regions_are_the_halves_of_each_prop_and_the_parts_of_the_table(blocks, cache):
    names = {(region.id, region.part) for region in regions_of(blocks, cache)}
    assert {(2, "lit"), (2, "shaded"), (3, "lit"), (3, "shaded"), (1, "open")} <= names


def test_light_that_is_right_passes(blocks):
    _, check, _ = scene_cache.make_tracer(blocks)
    assert check.mode == "shared"
    assert check.traced == ()
    assert len(check.regions) >= 5


def test_a_prop_whose_light_is_wrong_is_path_traced_alone(blocks, cache, monkeypatch):
    wrong = _brighter(blocks, cache, 3, 1.15)
    monkeypatch.setattr(scene_cache, "fill_scene_cache", lambda loaded: wrong)
    _, check, _ = scene_cache.make_tracer(blocks)
    assert check.mode == "shared"
    assert check.traced == (3,)
    assert {region.id for region in check.failed} == {3}
    assert {region.remedy for region in check.failed} == {"object path traced"}
    # Direct light in a convex block's cache is nearly all of it, so the pictures are as much brighter.
    assert all(region.difference == pytest.approx(0.15, abs=0.03) for region in check.failed)
    again = [region for region in check.regions if region.id == 3]
    assert len(again) == 2
    assert all(abs(region.difference) < max(BOUND, 4.0 * region.standard_error) for region in again)


def test_a_table_whose_light_is_wrong_is_path_traced_alone(blocks, cache, monkeypatch):
    moments = cache.moments.copy()
    moments[: cache.points.grid_count, :6] *= 1.1
    monkeypatch.setattr(scene_cache, "fill_scene_cache", lambda loaded: replace(cache, moments=moments))
    _, check, _ = scene_cache.make_tracer(blocks)
    assert check.mode == "shared"
    assert TABLE_ID in check.traced
    assert any(region.difference == pytest.approx(0.1, abs=0.03) for region in check.failed if region.id == TABLE_ID)


def test_a_prop_that_only_the_second_comparison_finds_is_path_traced_too(blocks, monkeypatch):
    """Noise hides a fault from one comparison; then the scene is not path traced as a whole."""
    real, faults = scene_cache.check_regions, {0: 2, 1: 3}

    def with_fault(loaded, tracer, reference, regions, which=0):
        found = real(loaded, tracer, reference, regions, which)
        wrong = faults.get(which)
        return [replace(one, difference=0.5, standard_error=0.01) if one.id == wrong else one for one in found]

    monkeypatch.setattr(scene_cache, "check_regions", with_fault)
    _, check, _ = scene_cache.make_tracer(blocks)
    assert check.mode == "shared"
    assert check.traced == (2, 3)


def test_a_draft_shows_the_light_that_pictures_are_compared_with(blocks, cache):
    found = draft_picture(blocks).radiance.astype(np.float64)
    pixel = np.arange(found.shape[0] * found.shape[1])
    reference = path_tracer_with_caustics(blocks, cache)
    expected = _luminances(blocks, reference, np.zeros_like(pixel), pixel, 5).reshape(found.shape[:2])
    # Means over squares of 12 pixels: 2,300 paths of the draft, each of which is off by less than its mean, and some
    # ten squares of forty-eight with an edge between light and dark.
    means = [each.reshape(6, 12, 8, 12).mean(axis=(1, 3)) for each in (luminance(found), expected)]
    np.testing.assert_allclose(*means, rtol=0.08)
