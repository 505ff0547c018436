"""Photons bring the light that paths from the surface would find, from every emitter."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.pose import aimed_frame
from glassware.procedural.description.scene import GlassBody
from glassware.procedural.description.surroundings import AreaLight
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives import bodies, scenes
from glassware.procedural.surroundings.metering import form_factor
from glassware.render.cache.cache_points import cache_points_of, point_areas
from glassware.render.cache.fill_cache import fill_cache
from glassware.render.cache.light_sources import targets_of
from glassware.render.cache.photon_map import photon_moments
from glassware.render.scene.loaded_scene import load

#: A table that reflects nothing: all of its light comes from the emitters at once.
BLACK = scenes.board((0.6, 0.6, 0.02), scenes.matte((0.0, 0.0, 0.0)))
#: The same, so small that glass a decimetre above does not reflect it.
SPECK = scenes.board((0.04, 0.04, 0.001), scenes.matte((0.0, 0.0, 0.0)))
GLASS = Medium(name="glass", eta=1.5)


def _scene(*glass: GlassBody, lights=(), environment=None, table=BLACK):
    camera = scenes.camera((0.5, 0.0, 0.6), width=64, height=48)
    return scenes.scene(glass, (camera,), table=table, lights=lights, environment=environment, seed=5)


def _glass(mesh) -> GlassBody:
    return bodies.glass_body(mesh, GLASS)


def _grid(loaded, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x, y and the values of the table's grid."""
    points = cache_points_of(loaded)
    x, y = (axis.coordinate(np.arange(axis.lines)) for axis in points.axes)
    return np.tile(x, len(y)), np.repeat(y, len(x)), values[: points.grid_count]


@pytest.mark.parametrize(
    "body",
    [
        bodies.ball_mesh(0.1, 5, centre=(0.0, 0.0, 0.2)),
        bodies.box_mesh((0.4, 0.1, 0.1), centre=(0.0, 0.0, 0.2)),  # long: several spheres overlap around it
    ],
    ids=["ball", "beam"],
)
def test_in_even_light_a_table_under_clear_glass_is_lit_as_if_there_were_none(backend, body) -> None:
    loaded = load(_scene(_glass(body), table=SPECK), for_cache=True)
    points = cache_points_of(loaded)
    found = fill_cache(loaded, points, 256, seed=1, photons=1 << 20).moments[: points.grid_count, 0]
    photons = np.mean(photon_moments(loaded, points, 1 << 20, seed=1), axis=0)[: points.grid_count, 0]
    # Photons bring the light of the directions that the glass fills, weighted with the cosine: (r / d)^2 of a ball's.
    assert photons.mean() > 0.15 * np.pi
    # Some ten thousand photons and as many paths: 1 % of what each brings. The glass reflects the black table: 0.3 %.
    assert found.mean() == pytest.approx(np.pi, rel=0.01)


def test_light_through_glass_is_even_on_a_prop_under_it(backend) -> None:
    """Photons on a mesh are filtered, as on the table: few land on a vertex, and what they leave is seen as a pattern.

    Under clear glass in even light the black plate gets pi of irradiance everywhere, most of it through the glass.
    """
    plate = scenes.block(bodies.box_mesh((0.12, 0.12, 0.01), centre=(0.0, 0.0, 0.015)), BLACK.material, id=9)
    ball = _glass(bodies.ball_mesh(0.1, 5, centre=(0.0, 0.0, 0.15)))
    scene = scenes.scene((ball,), _scene(ball).cameras, props=(plate,), table=SPECK, seed=5)
    loaded = load(scene, for_cache=True)
    points = cache_points_of(loaded)
    photons = np.mean(photon_moments(loaded, points, 1 << 17, seed=1), axis=0)[points.grid_count :, 0]
    found = fill_cache(loaded, points, 64, seed=1, photons=1 << 17).moments[points.grid_count :, 0]
    inside = np.abs(points.positions[:, :2]).max(1) < 0.05
    top = (points.normals[:, 2] > 0.9) & ~points.back & inside
    assert top.sum() > 200
    assert found[top].mean() == pytest.approx(np.pi, rel=0.02)
    assert photons[top].std() > 0.2 * np.pi
    # Smoothing over dozens of vertices leaves a few per cent of the variance; a tenth, 0.3 of the deviation, is asked.
    assert found[top].std() < 0.3 * photons[top].std()


def test_a_lamp_above_a_plate_lights_the_table_by_fresnels_equations(backend) -> None:
    lamp = AreaLight(
        world_T_light=aimed_frame(
            np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0]), 0.0
        ),
        size=(0.1, 0.1),
        radiance=(100.0, 50.0, 25.0),
    )
    dark = scenes.scene((), (scenes.camera((0.5, 0.0, 0.6)),)).environment.model_copy(update={"strength": 1e-12})
    plate = bodies.box_mesh((0.3, 0.3, 0.001), centre=(0.0, 0.0, 0.05))
    loaded = load(_scene(_glass(plate), lights=(lamp,), environment=dark), for_cache=True)
    moments = np.mean(photon_moments(loaded, cache_points_of(loaded), 1 << 19, seed=1), axis=0)
    x, y, area = _grid(loaded, point_areas(cache_points_of(loaded)))
    middle = np.hypot(x, y) < 0.05
    found = (moments[: len(area), :3] * area[:, None])[middle].sum(0) / area[middle].sum()
    # Near the axis the plate's transmittance is that of two faces and all reflections between them: (1 - R) / (1 + R).
    R = (0.5 / 2.5) ** 2
    expected = np.pi * form_factor(lamp) * np.array(lamp.radiance) * (1.0 - R) / (1.0 + R)
    # Within 5 cm of the axis cos^4 is at least 0.995, and its mean 0.9975.
    np.testing.assert_allclose(found, 0.9975 * expected, rtol=0.01)


def test_photons_are_the_same_bit_for_bit(backend) -> None:
    loaded = load(_scene(bodies.ball(0.03, GLASS, (0.0, 0.0, 0.05))), for_cache=True)
    points = cache_points_of(loaded)
    one, two = (photon_moments(loaded, points, 1 << 14, seed=7) for _ in range(2))
    np.testing.assert_array_equal(one, two)


def test_a_scene_without_glass_has_no_photons(backend) -> None:
    loaded = load(_scene(), for_cache=True)
    assert not np.any(photon_moments(loaded, cache_points_of(loaded), 1 << 14, seed=7))


def test_spheres_cover_all_glass(drawn) -> None:
    scene = drawn(3, vessel_count=(4, 4), prop_count=(0, 0))
    targets = targets_of(scene)
    assert len(targets.radius) >= 4
    for vessel in scene.vessels:
        vertices = np.concatenate([interface.mesh.vertices for interface in vessel.interfaces])
        world = vertices @ vessel.world_T_object[:3, :3].T + vessel.world_T_object[:3, 3]
        distance = np.linalg.norm(world[:, None] - targets.centre, axis=2) - targets.radius
        assert (distance.min(axis=1) < 0.0).all()
