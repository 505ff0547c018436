"""Cavities of solids: where they are, what they hold, and how thick the wall is."""

from __future__ import annotations

import time
from types import ModuleType

import numpy as np
import pytest
import trimesh

from glassware.core.mesh import Mesh, check_closed, joined, turned, volume_of
from glassware.procedural.cavities.interior import Interior, filled, interior_of, most_volume
from glassware.procedural.cavities.polygon import triangulated
from glassware.procedural.placement.overlap import Solid, contains

#: What the issue asks of volumes and of walls.
VOLUME_ERROR, WALL_ERROR = 0.01, 0.05


def solid(mesh: trimesh.Trimesh) -> Mesh:
    return Mesh("a-solid", np.asarray(mesh.vertices), np.asarray(mesh.faces))


def inside(mesh: trimesh.Trimesh) -> Interior:
    return interior_of(solid(mesh))


def test_a_beaker_holds_its_inner_prism_up_to_the_rim(own_shapes: ModuleType) -> None:
    found = inside(own_shapes.beaker())
    assert len(found.hollows) == 1
    assert found.volume == pytest.approx(own_shapes.capacity(), rel=VOLUME_ERROR)
    assert found.hollows[0].brim == pytest.approx(own_shapes.HEIGHT, abs=1e-6)
    assert found.hollows[0].floor == pytest.approx(own_shapes.WALL, abs=1e-6)


@pytest.mark.parametrize("wall", [0.0008, 0.002, 0.005])
def test_the_wall_is_as_thick_as_it_is(own_shapes: ModuleType, wall: float) -> None:
    assert inside(own_shapes.beaker(wall=wall)).wall == pytest.approx(wall, rel=WALL_ERROR)


def test_the_volume_of_a_filling_is_that_of_points_which_rays_find_in_it(own_shapes: ModuleType) -> None:
    body = solid(own_shapes.beaker())
    found = interior_of(body)
    parts, fillings = filled(body, found, 0.6 * found.volume, ("o", "w", "s"))
    liquid = joined([turned(parts.wet_wall), parts.liquid_surface], "liquid")
    low, high = liquid.bounds
    points = low + np.random.default_rng(5).random((6000, 3)) * (high - low)
    within = contains(Solid(liquid.vertices.astype(float), liquid.faces), points).mean()
    # Three standard deviations of the share of points are added to the error that is allowed.
    allowed = VOLUME_ERROR + 3.0 * np.sqrt((1.0 - within) / within / len(points))
    assert within * np.prod(high - low) == pytest.approx(0.6 * found.volume, rel=allowed)
    assert volume_of(liquid) == pytest.approx(0.6 * own_shapes.capacity(), rel=VOLUME_ERROR)
    level = own_shapes.WALL + 0.6 * (own_shapes.HEIGHT - own_shapes.WALL)
    assert fillings[0].level == pytest.approx(level, abs=1e-4)


def test_the_cut_parts_close_glass_and_liquid_bit_for_bit(own_shapes: ModuleType) -> None:
    body = solid(own_shapes.beaker())
    found = interior_of(body)
    for fraction in (0.05, 0.31, 0.5, 0.9):
        parts, _ = filled(body, found, fraction * found.volume, ("o", "w", "s"))
        check_closed("glass", joined([parts.outside, parts.wet_wall], "glass"))
        check_closed("liquid", joined([turned(parts.wet_wall), parts.liquid_surface], "liquid"))


def test_the_hole_of_a_handle_and_a_bubble_hold_nothing(own_shapes: ModuleType) -> None:
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.02)
    bubble = trimesh.creation.icosphere(subdivisions=2, radius=0.01)
    bubble.invert()
    assert not inside(own_shapes.with_bodies(ball, bubble)).hollows
    assert not inside(own_shapes.handle()).hollows
    assert inside(ball).wall is None


def test_every_cavity_gets_the_same_part_of_what_it_holds(own_shapes: ModuleType) -> None:
    body = solid(
        own_shapes.with_bodies(own_shapes.beaker(), own_shapes.beaker(wall=0.008).apply_translation([0.1, 0.0, 0.02]))
    )
    found = interior_of(body)
    assert len(found.hollows) == 2
    parts, _ = filled(body, found, 0.5 * found.volume, ("o", "w", "s"))
    assert len(np.unique(parts.liquid_surface.vertices[:, 2])) == 2
    content = volume_of(joined([turned(parts.wet_wall), parts.liquid_surface], "liquid"))
    assert content == pytest.approx(0.5 * (own_shapes.capacity() + own_shapes.capacity(wall=0.008)), rel=VOLUME_ERROR)


def test_a_spout_decides_how_much_a_cup_holds(own_shapes: ModuleType) -> None:
    cup = own_shapes.beaker(rows=2)
    notch = np.flatnonzero(
        (cup.vertices[:, 2] == own_shapes.HEIGHT) & (np.arctan2(*cup.vertices[:, [1, 0]].T) % 6.28 < 0.2)
    )
    vertices = np.array(cup.vertices)
    vertices[notch, 2] -= 0.02
    found = inside(trimesh.Trimesh(vertices, cup.faces, process=False))
    assert found.hollows[0].brim == pytest.approx(own_shapes.HEIGHT - 0.02, abs=1e-3)


def test_a_floor_with_a_hump_keeps_a_ring_of_liquid() -> None:
    profile = [(0, 0), (0.03, 0), (0.03, 0.08), (0.028, 0.08), (0.028, 0.002), (0.012, 0.002), (0.01, 0.03), (0, 0.03)]
    body = solid(trimesh.creation.revolve(np.array(profile, float), sections=48))
    found = interior_of(body)
    parts, fillings = filled(body, found, 0.2 * found.volume, ("o", "w", "s"))
    assert fillings[0].level < 0.03
    radii = np.hypot(*parts.liquid_surface.vertices[:, :2].T)
    assert radii.min() > 0.009
    check_closed("liquid", joined([turned(parts.wet_wall), parts.liquid_surface], "liquid"))


def test_the_level_stays_below_the_brim(own_shapes: ModuleType) -> None:
    found = inside(own_shapes.beaker())
    assert 0.9 < most_volume(found) / found.volume < 0.98


def test_a_mesh_of_a_hundred_thousand_triangles_is_understood_in_time(own_shapes: ModuleType) -> None:
    body = solid(own_shapes.beaker(sections=250, rows=100))
    assert len(body.faces) > 95_000
    start = time.process_time()
    found = interior_of(body)
    filled(body, found, 0.5 * found.volume, ("o", "w", "s"))
    assert time.process_time() - start < 5.0


def test_outlines_with_holes_become_triangles_of_the_same_area() -> None:
    around = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    circle = np.stack([np.cos(around), np.sin(around)], axis=1)
    star = circle * (1.0 + 0.3 * np.cos(5.0 * around))[:, None]
    points = np.concatenate([star, 0.2 * circle + [0.3, 0.1], 0.15 * circle - [0.3, 0.1]])
    loops = [np.arange(40), np.arange(40, 80)[::-1], np.arange(80, 120)[::-1]]
    a, b, c = (points[triangulated(points, loops)[:, k]] for k in range(3))
    areas = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])

    def area(ring: np.ndarray) -> float:
        x, y = points[ring].T
        return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))

    assert (areas > 0.0).all()
    assert areas.sum() == pytest.approx(sum(map(area, loops)), rel=1e-12)
