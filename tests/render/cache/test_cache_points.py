"""Nodes: what is stored at them is found again where a ray hits."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.primitives import bodies, scenes
from glassware.render.cache.cache_points import cache_points_of, interpolation_weights, lookup_of
from glassware.render.cache.sample_points import point_sampler, sample_points
from glassware.render.pictures.sampler import sobol_sampler
from glassware.render.scene.loaded_scene import load
from glassware.render.scene.surfaces import registry_id


@pytest.fixture(scope="module")
def cut(backend, drawn):
    return load(drawn(8, vessel_count=(1, 1), prop_count=(3, 3)), for_cache=True)


@pytest.fixture(scope="module")
def nodes(cut):
    return cache_points_of(cut)


def test_lines_of_the_grid_are_where_they_are_said_to_be(nodes) -> None:
    for axis in nodes.axes:
        place = np.linspace(0.0, axis.lines - 1.0, 999)
        np.testing.assert_allclose(axis.cell_position(axis.coordinate(place)), place, atol=1e-9 * axis.lines)
        assert axis.coordinate(np.array(axis.lines - 1)) >= axis.high - 1e-9
        inside = np.diff(axis.coordinate(np.arange(axis.lines)))
        np.testing.assert_allclose(inside[np.abs(inside - axis.step) > 1e-9], 6.0 * axis.step)


def test_a_linear_function_stored_at_the_nodes_is_exact_at_every_hit(cut, nodes) -> None:
    import drjit as dr
    import mitsuba as mi

    slope, x, y = np.array([0.7, -1.3, 2.1]), *(a.coordinate(np.arange(a.lines)) for a in nodes.axes)
    grid = np.stack([*(m.ravel() for m in np.meshgrid(x, y)), np.zeros(nodes.grid_count)], axis=1)
    values = mi.Float((np.concatenate([grid, nodes.positions]) @ slope).astype(np.float32))

    rng = np.random.default_rng(3)
    origin = rng.normal(size=(3, 20_000)) * [[0.5], [0.5], [0.2]] + [[0.0], [0.0], [0.5]]
    target = rng.uniform(-0.4, 0.4, size=origin.shape) * [[1.0], [1.0], [0.1]]
    direction = target - origin
    direction /= np.linalg.norm(direction, axis=0)
    ray = mi.Ray3f(mi.Point3f(origin.astype(np.float32)), mi.Vector3f(direction.astype(np.float32)))
    pi = cut.mi_scene.ray_intersect_preliminary(ray)
    si = pi.compute_surface_interaction(ray)
    row = registry_id(si.shape)
    hit = si.is_valid() & dr.gather(mi.Bool, cut.surfaces.opaque, row)
    on_table = dr.gather(mi.UInt32, cut.surfaces.instance, row) == 1
    index, weight = interpolation_weights(lookup_of(nodes), si, pi.prim_uv, -ray.d, on_table)
    found = sum(w * dr.gather(mi.Float, values, i, hit) for i, w in zip(index, weight, strict=True))
    hit, p = np.array(hit), np.array(si.p).T
    on_props = hit & ~np.array(on_table)
    assert hit.sum() > 5000
    assert on_props.sum() > 500
    # Positions are float32, and so are cells of 4 mm in a table of 1 m: 2^-24 * 250 of a cell.
    np.testing.assert_allclose(np.array(found)[hit], (p @ slope)[hit], atol=1e-4)
    np.testing.assert_allclose(np.array(sum(weight))[hit], 1.0, atol=1e-5)


def test_paths_start_on_the_surface_beside_their_node(cut, nodes) -> None:
    import drjit as dr
    import mitsuba as mi

    vertex = np.arange(0, len(nodes.positions), 7)
    node = np.repeat((nodes.grid_count + vertex).astype(np.uint32), 4)
    sampler = sobol_sampler(mi.UInt32(node), dr.arange(mi.UInt32, len(node)) % 4, 4, 9)
    start = sample_points(point_sampler(nodes), mi.UInt32(node), sampler)
    p, n, known = start.p, start.n, np.array(start.valid)
    assert known.mean() > 0.95
    away = np.linalg.norm(np.array(p).T - nodes.positions[np.repeat(vertex, 4)], axis=1)
    longest = np.linalg.norm(np.diff(nodes.positions[nodes.triangles][:, [0, 1, 2, 0]], axis=1), axis=-1).max()
    assert away[known].max() < longest
    # A short ray from just above the point, down along the normal, meets the surface there. (What stands on the table
    # is 0.1 mm away from it.)
    above = mi.Ray3f(p + 2e-5 * n, -n)
    met = np.array(cut.mi_scene.ray_intersect_preliminary(above).t)
    assert (np.abs(met[known] - 2e-5) < 2e-6).mean() > 0.99


def test_the_faces_of_flat_meshes_have_unit_normals(backend) -> None:
    """The filter of the cache compares them, and tells the sides of a thin board apart by them alone."""
    board = scenes.block(bodies.box_mesh((0.08, 0.05, 0.002)), scenes.matte(), id=9)
    scene = scenes.scene((), (scenes.camera((0.5, 0.0, 0.6), width=64, height=48),), props=(board,), seed=5)
    points = cache_points_of(load(scene, for_cache=True))
    of_board = points.mesh == points.mesh.max()
    assert of_board.sum() > 500
    np.testing.assert_allclose(np.linalg.norm(points.normals[of_board], axis=1), 1.0, rtol=1e-6)
    assert {tuple(np.rint(n).astype(int) + 0) for n in points.normals[of_board]} == {
        (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)
    }  # fmt: skip
