"""The map of bright light knows where the lamps are, and the coins that it steers stay fair."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.surroundings.colour import luminance
from glassware.render.cache.guiding import (
    CELLS,
    EmissionMap,
    emission_along,
    emission_from,
    emission_map,
    guided_reflect_probability,
    hits_lamp,
    octahedral,
    path_guide,
)
from glassware.render.interfaces.dielectric import InterfaceHit, scatter


@pytest.fixture(scope="module")
def lamp_scene(drawn):
    """A scene with one lamp at least."""
    for seed in range(20, 60):
        # Of at least the size of the map's cells.
        lights = {"max_count": 3, "kinds": ("panel", "soft-box")}
        scene = drawn(seed, vessel_count=(1, 1), prop_count=(0, 0), lights=lights)
        if scene.lights:
            return scene
    raise AssertionError("no scene of forty has a lamp")


@pytest.fixture(scope="module")
def bright(backend, lamp_scene):
    return emission_map(lamp_scene)


def _directions(count: int) -> np.ndarray:
    vectors = np.random.default_rng(5).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _looked_up(bright, directions: np.ndarray) -> np.ndarray:
    import mitsuba as mi

    return np.array(emission_from(bright, mi.Vector3f(np.ascontiguousarray(directions.T, np.float32))))


def test_every_direction_is_looked_up_where_it_was_stored(bright) -> None:
    import mitsuba as mi

    row, column = np.mgrid[:CELLS, :CELLS]
    middle = octahedral((column + 0.5) / CELLS, (row + 0.5) / CELLS).reshape(-1, 3)
    numbered = EmissionMap(mi.Float(np.arange(CELLS**2, dtype=np.float32)), ())
    np.testing.assert_array_equal(_looked_up(numbered, middle), np.arange(CELLS**2))


def test_towards_a_lamp_it_is_bright(bright, lamp_scene) -> None:
    for lamp in lamp_scene.lights:
        towards = lamp.world_T_light[:3, 3] / np.linalg.norm(lamp.world_T_light[:3, 3])
        radiance, dim = float(luminance(np.array(lamp.radiance))), np.median(np.array(bright.cells))
        # A cell is wider than some lamps, and it is seen from all over the table: a share of it is left.
        assert _looked_up(bright, towards[None])[0] > dim + 0.05 * radiance


def test_a_ray_that_meets_a_lamp_is_told_so_wherever_it_starts(backend, bright, lamp_scene) -> None:
    import mitsuba as mi

    rng = np.random.default_rng(6)
    starts = rng.uniform((-0.6, -0.6, 0.0), (0.6, 0.6, 0.3), (4096, 3))
    for lamp in lamp_scene.lights:
        pose = lamp.world_T_light
        local = rng.uniform(-1.5, 1.5, (4096, 2))
        aims = pose[:3, 3] + (0.5 * np.array(lamp.size) * local) @ pose[:3, :2].T
        rays = (aims - starts) / np.linalg.norm(aims - starts, axis=1, keepdims=True)
        front = rays @ pose[:3, 2] < 0.0
        p, d = (kind(*np.ascontiguousarray(v.T, np.float32)) for kind, v in ((mi.Point3f, starts), (mi.Vector3f, rays)))
        expected = _looked_up(bright, rays)
        for other in lamp_scene.lights:
            shines = np.float32(luminance(np.array(other.radiance)))
            expected = np.where(hits_lamp(other, starts, rays), np.maximum(expected, shines), expected)
        meets = front & (np.abs(local) < 1.0).all(1)
        sure = np.abs(np.abs(local) - 1.0).min(1) > 1e-4  # float32 cannot tell on the very edge
        assert min(meets[sure].sum(), (~meets)[sure].sum()) > 500
        np.testing.assert_array_equal(hits_lamp(lamp, starts, rays)[sure], meets[sure])
        np.testing.assert_array_equal(np.array(emission_along(bright, p, d))[sure], expected[sure])


@pytest.mark.parametrize("index", [1.0, 1.33, 1.52])
def test_no_outcome_of_a_steered_coin_counts_more_than_twice(bright, index) -> None:
    import mitsuba as mi

    facet, wi = _directions(20_000), _directions(20_000)
    wi *= np.sign((wi * facet).sum(1, keepdims=True))
    R = np.random.default_rng(6).uniform(0.0, 1.0, len(wi)).astype(np.float32)
    columns = (np.ascontiguousarray(x.T, np.float32) for x in (wi, facet))
    kinds = (mi.Vector3f, mi.Normal3f)
    eye, normal = (kind(column) for kind, column in zip(kinds, columns, strict=True))
    share = np.array(guided_reflect_probability(bright, eye, normal, mi.Float(index), mi.Float(R)), np.float64)
    assert (share >= 0.5 * R - 1e-6).all()
    assert (1.0 - share >= 0.5 * (1.0 - R) - 1e-6).all()
    total = guided_reflect_probability(bright, eye, normal, mi.Float(index), mi.Float(np.ones_like(R)))
    np.testing.assert_array_equal(np.array(total), 1.0)


def test_steering_leaves_the_mean_of_an_interface_as_it_is(bright) -> None:
    import drjit as dr
    import mitsuba as mi

    count = 1 << 16
    wi = mi.Vector3f(np.ascontiguousarray(np.tile([[0.6], [0.0], [0.8]], count), np.float32))
    up, seed = mi.Normal3f(0.0, 0.0, 1.0), dr.arange(mi.UInt32, count)
    coin = (mi.Float(seed) + 0.5) / count  # every coin once: sums over them are integrals, exact to one coin
    for eta in (1.5, 1.0 / 1.2):
        hit = InterfaceHit(wi, up, up, mi.Float(eta), mi.Float(0.0), coin, seed)
        event = scatter(hit, path_guide(bright, mi.Float(1.0), mi.Float(1.0)))
        plain = scatter(hit)
        for mirrored in (True, False):
            sums = [np.array(x.weight)[np.array(x.transmitted) != mirrored].sum() / count for x in (event, plain)]
            # One coin at the border of the outcomes, of a weight of at most 2 / eta^2, and float32.
            assert sums[0] == pytest.approx(sums[1], abs=4.0 * max(1.0, eta**-2) / count + 1e-5)


def test_what_counts_much_already_is_tossed_as_fresnel_says(bright) -> None:
    import mitsuba as mi

    R = np.linspace(0.01, 1.0, 100, dtype=np.float32)
    wi, up = mi.Vector3f(0.6, 0.0, 0.8), mi.Normal3f(0.0, 0.0, 1.0)
    np.testing.assert_array_equal(np.array(path_guide(bright, mi.Float(1.0), mi.Float(2.1))(wi, up, mi.Float(R))), R)
    assert (np.array(path_guide(bright, mi.Float(1.0), mi.Float(1.9))(wi, up, mi.Float(R)))[:-1] != R[:-1]).any()
