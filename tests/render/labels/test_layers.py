"""K layers against the geometry, a point-in-solid test and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.mesh import as_trimesh
from glassware.dataset.format.ray_files import read_layers, read_refraction, write_layers, write_refraction
from glassware.procedural.description.material_list import materials_of
from glassware.procedural.description.scene import glass_solid, liquid_solid
from glassware.render.frame import PARTS
from glassware.render.labels.geometry import trace_straight
from glassware.render.labels.refraction import trace_refraction
from glassware.render.scene.loaded_scene import load

#: Middles of segments shorter than this are nearer to a surface than the winding number can tell [m].
SHORTEST = 5e-5
#: Share of segments that a seam may spoil.
DOUBTFUL = 5e-3
LAYERS = 16


@pytest.fixture(scope="module")
def traced(backend, glasses):
    camera = glasses.cameras[0]
    return glasses, camera, *trace_straight(load(glasses), camera, LAYERS)


def test_the_first_layer_is_the_first_surface(traced):
    _, _, geometry, layers = traced
    np.testing.assert_array_equal(layers.Z[0], geometry.Z)
    np.testing.assert_array_equal(layers.id[0], geometry.id)
    np.testing.assert_array_equal(layers.normal[0], geometry.normal.astype(np.float16))


def test_the_first_opaque_layer_is_the_background(traced):
    _, _, geometry, layers = traced
    opaque = (layers.part == PARTS.index("opaque")) & (layers.id > 0)
    first = opaque.argmax(axis=0)[None]
    Z = np.where(opaque.any(axis=0), np.take_along_axis(layers.Z, first, axis=0)[0], np.inf)
    ids = np.where(opaque.any(axis=0), np.take_along_axis(layers.id, first, axis=0)[0], 0)
    whole = layers.count <= LAYERS
    np.testing.assert_array_equal(Z[whole], geometry.background_Z[whole])
    np.testing.assert_array_equal(ids[whole], geometry.background_id[whole])


def test_layers_are_in_order_and_counted(traced):
    _, _, _, layers = traced
    filled = layers.id > 0
    np.testing.assert_array_equal(filled.sum(axis=0), np.minimum(layers.count, LAYERS))
    assert (filled[1:] <= filled[:-1]).all()
    assert np.isinf(layers.Z[~filled]).all()
    assert (layers.Z[1:][filled[1:]] >= layers.Z[:-1][filled[1:]] - 1e-6).all()


def test_fewer_layers_are_the_first_of_more_with_the_same_count(loaded_glasses, traced):
    _, camera, geometry, layers = traced
    again, fewer = trace_straight(loaded_glasses, camera, 3)
    for field in ("Z", "normal", "id", "part", "material", "entering"):
        np.testing.assert_array_equal(getattr(fewer, field), getattr(layers, field)[:3])
    np.testing.assert_array_equal(fewer.count, layers.count)
    np.testing.assert_array_equal(again.reached, geometry.reached)
    assert layers.count.max() > 3


def test_normals_are_unit_and_face_the_camera(traced):
    _, camera, _, layers = traced
    rows, columns = np.mgrid[: camera.height, : camera.width]
    ray = np.stack([columns - camera.centre[0], rows - camera.centre[1], np.full(rows.shape, camera.focal)], axis=-1)
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    filled = layers.id > 0
    normal = layers.normal.astype(float)
    assert np.abs(np.linalg.norm(normal, axis=-1)[filled] - 1).max() < 2.0**-10  # half has 11 bits
    assert ((normal * ray).sum(axis=-1)[filled] < 2.0**-10).all()


def test_the_material_of_a_layer_is_what_a_point_behind_it_lies_in(traced):
    scene, camera, _, layers = traced
    materials = materials_of(scene)
    rows, columns = np.nonzero(layers.count >= 4)
    rows, columns = rows[::3], columns[::3]
    ray = np.stack([columns - camera.centre[0], rows - camera.centre[1], np.full(rows.shape, camera.focal)], axis=-1)
    found, expected = [], []
    bodies = [(vessel, glass_solid(vessel), vessel.glass) for vessel in scene.vessels]
    bodies += [(vessel, liquid_solid(vessel), vessel.liquid.medium) for vessel in scene.vessels if vessel.liquid]
    solids = [(as_trimesh(mesh, vessel.world_T_object), materials.index(m)) for vessel, mesh, m in bodies]
    for i in range(4):
        near, far = layers.Z[i][rows, columns], layers.Z[i + 1][rows, columns]
        # Behind an opaque surface is its own material, whatever stands there.
        use = np.isfinite(far) & (far - near > SHORTEST) & (layers.part[i][rows, columns] > 0)
        middle = ray[use] / camera.focal * ((near + far) / 2)[use, None].astype(float)
        world = middle @ camera.world_T_camera[:3, :3].T + camera.world_T_camera[:3, 3]
        truth = np.zeros(len(world), int)
        for solid, material in solids:
            truth[_inside(solid.triangles, world)] = material
        found.append(layers.material[i][rows, columns][use])
        expected.append(truth)
    found, expected = np.concatenate(found), np.concatenate(expected)
    assert len(found) > 200
    assert len(set(expected.tolist())) >= 4  # air, glass and more than one liquid
    assert (found != expected).mean() < DOUBTFUL


def _inside(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether the solid angle of a closed surface is a whole turn (van Oosterom and Strackee 1983)."""
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    inside = ((points > low) & (points < high)).all(axis=1)
    for i in np.flatnonzero(inside):
        a, b, c = np.moveaxis(triangles - points[i], 1, 0)
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        top = np.einsum("ij,ij->i", a, np.cross(b, c))
        low = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        inside[i] = 2 * np.arctan2(top, low).sum() > 2 * np.pi
    return inside


def test_a_slab_has_its_two_faces_as_layers(backend, optical_bench):
    camera = optical_bench.camera((0.0, 0.0, 0.5))
    slab = optical_bench.box((3.0, 3.0, 0.05), (0.013, 0.007, 0.2))
    _, layers = trace_straight(load(optical_bench.scene(slab, optical_bench.medium(1.52), camera)), camera, 5)
    whole = layers.count == 4
    assert whole.mean() > 0.99  # rays that meet the seam of two triangles may slip through
    Z = np.array([0.275, 0.325, 0.5, 0.52])
    np.testing.assert_allclose(layers.Z[:4, whole], np.repeat(Z[:, None], whole.sum(), axis=1), atol=5e-6)
    outside, opaque = PARTS.index("outside"), PARTS.index("opaque")
    met = [(2, outside, 2, True), (2, outside, 0, False), (1, opaque, 1, True), (1, 0, 0, False)]
    for i, expected in enumerate(met):
        fields = (layers.id[i], layers.part[i], layers.material[i], layers.entering[i])
        assert [set(field[whole].tolist()) for field in fields] == [{value} for value in expected]
    assert (opaque, met[-1][1]) == (0, 0)
    np.testing.assert_allclose(layers.normal[:4, whole].astype(float).reshape(-1, 3) @ [0, 0, 1], -1.0)


def test_layers_and_refraction_come_back_from_their_files(traced, loaded_glasses, tmp_path):
    _, camera, _, layers = traced
    write_layers(tmp_path / "layers.exr", layers)
    found = read_layers(tmp_path / "layers.exr")
    depth = min(LAYERS, int(layers.count.max()))
    for field in ("Z", "normal", "id", "part", "material", "entering"):
        before, after = getattr(layers, field), getattr(found, field)
        assert before.dtype == after.dtype
        np.testing.assert_array_equal(after, before[:depth])
    np.testing.assert_array_equal(found.count, layers.count)

    (refraction,) = trace_refraction(loaded_glasses, [camera])
    write_refraction(tmp_path / "refraction.exr", refraction)
    again = read_refraction(tmp_path / "refraction.exr")
    for field in vars(refraction):
        assert getattr(again, field).dtype == getattr(refraction, field).dtype
        np.testing.assert_array_equal(getattr(again, field), getattr(refraction, field))
