"""Rooms as environments."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glassware.procedural.description.surroundings import Block, RoomEnvironment, Window
from glassware.procedural.surroundings.colour import luminance
from glassware.procedural.surroundings.room_geometry import boxes_of, cast
from glassware.procedural.surroundings.room_light import solve
from glassware.procedural.surroundings.rooms import bake_room, draw_room

WHITE = (0.5, 0.5, 0.5)


def room(windows, reflectance: float = 0.5, size=(4.0, 4.0, 4.0), **more) -> RoomEnvironment:
    middle = tuple(side / 2 for side in size)
    return RoomEnvironment(
        size=size, eye=middle, wall_colours=((reflectance,) * 3,) * 6, windows=windows, seed=1, **more
    )


def lamp(wall="ceiling", centre=(2.0, 2.0), size=(1.0, 1.0), radiance=(10.0, 10.0, 10.0)) -> Window:
    return Window(kind="lamp", wall=wall, centre=centre, size=size, radiance=radiance)


def at(pixels: np.ndarray, direction) -> np.ndarray:
    x, y, z = np.array(direction, float) / np.linalg.norm(direction)
    height = len(pixels)
    return pixels[int(math.acos(z) / math.pi * height), int(math.atan2(y, x) % (2 * math.pi) / math.pi * height)]


@pytest.mark.parametrize(
    ("wall", "direction"),
    [("+x", (1, 0, 0)), ("-x", (-1, 0, 0)), ("+y", (0, 1, 0)), ("-y", (0, -1, 0)), ("ceiling", (0, 0, 1))],
)
def test_a_lamp_is_seen_where_its_wall_is(wall, direction):
    pixels = bake_room(room((lamp(wall),)), 32)
    np.testing.assert_allclose(at(pixels, np.array(direction) + 1e-3), 10.0)
    dark = [way for way in np.vstack([np.eye(3), -np.eye(3)]) if way @ direction < 0.5]
    assert max(at(pixels, way + 1e-3).max() for way in dark) < 5.0


def test_a_lamp_off_the_middle_is_seen_on_the_right_side():
    pixels = bake_room(room((lamp("+x", centre=(3.0, 1.0)),)), 64)
    np.testing.assert_allclose(at(pixels, (2.0, 1.0, -1.0)), 10.0)


def test_the_direct_light_on_the_floor_follows_the_closed_form():
    black = room((lamp(size=(0.5, 0.5), radiance=(1.0, 2.0, 4.0)),), reflectance=0.0)
    grids = solve(black, boxes_of(black))
    # A small lamp seen from (0.875, 1.125, 0): L A cos^2 / d^2; its fading rim takes some of it.
    floor = grids[5, 3, 4]
    squared = 1.125**2 + 0.875**2 + 16.0
    expected = 0.25 * (16.0 / squared) / squared * np.array([1.0, 2.0, 4.0])
    # 4 x 4 midpoints of a lamp 0.12 of its distance wide.
    np.testing.assert_allclose(floor, expected, rtol=0.02)


def test_interreflection_keeps_the_energy():
    # All walls of reflectance r: the light absorbed equals the light emitted, (1 - r) sum(E A) = flux, less what falls
    # back on the lamp, whose share of the area is 0.25 %.
    half = room((lamp(size=(0.5, 0.5)),), reflectance=0.5)
    grids = solve(half, boxes_of(half))
    absorbed = 0.5 * grids[..., 0].mean() * 6 * 16.0
    flux = math.pi * 10.0 * 0.25
    # 64 rays per point and 16 x 16 points per wall.
    assert absorbed == pytest.approx(flux, rel=0.03)


def test_a_block_casts_a_shadow():
    table = Block(lower=(1.5, 1.5, 1.0), upper=(2.5, 2.5, 1.1), colour=WHITE)
    small = lamp(size=(0.3, 0.3))
    free = solve(room((small,), 0.0), boxes_of(room((small,), 0.0)))
    blocked_room = room((small,), 0.0, blocks=(table,))
    shaded = solve(blocked_room, boxes_of(blocked_room))
    assert free[5, 8, 8, 0] > 0.0
    assert shaded[5, 8, 8, 0] == 0.0
    assert shaded[5, 1, 1, 0] == pytest.approx(free[5, 1, 1, 0])


def test_rays_meet_the_nearest_of_walls_and_blocks():
    scene = room((lamp(),), blocks=(Block(lower=(3.0, 1.0, 1.0), upper=(3.5, 3.0, 3.0), colour=WHITE),))
    ways = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, 0, -1]], dtype=np.float32)
    faces, points = cast(boxes_of(scene), np.full((1, 3), 2.0, np.float32), ways)
    assert faces.tolist() == [7, 1, 2, 5]
    np.testing.assert_allclose(points, [[3, 2, 2], [0, 2, 2], [2, 4, 2], [2, 2, 0]], atol=1e-6)


def test_mullions_cross_a_window():
    pane = Window(wall="+x", centre=(2.0, 2.0), size=(2.0, 2.0), radiance=(5.0, 5.0, 5.0), bars=1)
    pixels = bake_room(room((pane,)), 128)
    bar, glass = at(pixels, (2.0, 0.005, 0.5)), at(pixels, (2.0, 0.4, 0.5))
    assert bar.max() < 0.6 * glass.min()


def test_the_same_room_bakes_to_the_same_pixels():
    drawn = draw_room(np.random.default_rng(3))
    assert drawn == draw_room(np.random.default_rng(3))
    np.testing.assert_array_equal(bake_room(drawn, 16), bake_room(drawn, 16))


def test_drawn_rooms_have_the_contrast_of_rooms():
    ratios = []
    for seed in range(5):
        pixels = bake_room(draw_room(np.random.default_rng(seed)), 48)
        assert pixels.shape == (48, 96, 3)
        assert np.isfinite(pixels).all()
        assert pixels.min() >= 0.0
        levels = luminance(pixels)
        ratios.append(np.percentile(levels, 99.5) / np.median(levels))
    # Lamps and windows of 2 to 12 kcd/m^2 over walls of 20 to 300 cd/m^2 (100 to 1500 lx on light paint).
    assert min(ratios) > 8.0
    assert max(ratios) < 400.0


def test_finer_maps_show_the_same_room():
    drawn = draw_room(np.random.default_rng(5))
    coarse, fine = bake_room(drawn, 32), bake_room(drawn, 64)
    pooled = fine.reshape(32, 2, 64, 2, 3).mean(axis=(1, 3))
    # Edges of bright lamps differ; the mean does not.
    assert pooled.mean() == pytest.approx(coarse.mean(), rel=0.02)
