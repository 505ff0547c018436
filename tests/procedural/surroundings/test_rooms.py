"""Rooms as environments."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glassware.procedural.description.surroundings import Block, RoomEnvironment, Window
from glassware.procedural.surroundings.colour import luminance
from glassware.procedural.surroundings.metering import irradiance
from glassware.procedural.surroundings.room_geometry import boxes_of, cast
from glassware.procedural.surroundings.room_light import cells_of, solve
from glassware.procedural.surroundings.room_map import EDGE_CONTRAST, bake_room
from glassware.procedural.surroundings.rooms import draw_room
from glassware.procedural.surroundings.windows import LAMP_RIM, coverage, outside_of

WHITE = (0.5, 0.5, 0.5)


def room(windows, reflectance: float = 0.5, size=(4.0, 4.0, 4.0), **more) -> RoomEnvironment:
    middle = tuple(side / 2 for side in size)
    return RoomEnvironment(
        size=size, eye=middle, wall_colours=((reflectance,) * 3,) * 6, windows=windows, seed=1, **more
    )


def lamp(wall="ceiling", centre=(2.0, 2.0), size=(1.0, 1.0), radiance=(10.0, 10.0, 10.0)) -> Window:
    return Window(kind="lamp", wall=wall, centre=centre, size=size, radiance=radiance)


def solved(description: RoomEnvironment) -> list[np.ndarray]:
    return solve(description, boxes_of(description), outside_of(description))


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
    grids = solved(black)
    # A small lamp seen from (0.875, 1.125, 0): L A cos^2 / d^2; its fading rim takes some of it.
    floor = grids[5][3, 4]
    squared = 1.125**2 + 0.875**2 + 16.0
    expected = 0.25 * (16.0 / squared) / squared * np.array([1.0, 2.0, 4.0])
    # 4 x 4 midpoints of a lamp 0.12 of its distance wide.
    np.testing.assert_allclose(floor, expected, rtol=0.02)


def test_interreflection_keeps_the_energy():
    # All walls of reflectance r: the light absorbed equals the light emitted, (1 - r) sum(E A) = flux, less what falls
    # back on the lamp, whose share of the area is 0.25 %.
    half = room((lamp(size=(0.5, 0.5)),), reflectance=0.5)
    grids = solved(half)
    absorbed = 0.5 * np.mean([grid[..., 0].mean() for grid in grids]) * 6 * 16.0
    flux = math.pi * 10.0 * 0.25
    # 64 rays per point and 16 x 16 cells per wall.
    assert absorbed == pytest.approx(flux, rel=0.03)


def test_a_block_casts_a_shadow():
    table = Block(lower=(1.5, 1.5, 1.0), upper=(2.5, 2.5, 1.1), colour=WHITE)
    small = lamp(size=(0.3, 0.3))
    free, shaded = solved(room((small,), 0.0))[5], solved(room((small,), 0.0, blocks=(table,)))[5]
    assert free[8, 8, 0] > 0.0
    assert shaded[8, 8, 0] == 0.0
    assert shaded[1, 1, 0] == pytest.approx(free[1, 1, 0])


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


def test_cells_know_their_places():
    boxes = boxes_of(room((lamp(),), size=(3.0, 4.0, 2.5)))
    cells = cells_of(boxes)
    sides = np.array([[4.0, 2.5], [4.0, 2.5], [3.0, 2.5], [3.0, 2.5], [3.0, 4.0], [3.0, 4.0]])
    numbers = cells.at(cells.face, cells.coordinates / sides[cells.face])
    np.testing.assert_array_equal(numbers, np.arange(len(cells.face)))


def test_a_rectangle_covers_the_area_that_it_has():
    cover = coverage((1.1, 0.9), (0.5, 0.33), np.zeros(2), np.array([2.0, 3.0]), np.array([7, 11]))
    assert cover.sum() * (2.0 / 7) * (3.0 / 11) == pytest.approx(0.5 * 0.33, rel=1e-5)
    assert cover.max() <= 1.0


def test_rays_from_one_origin_meet_what_rays_from_many_meet():
    # Rays from one origin are first compared with each box's bounding sphere; rays from many are not.
    drawn = draw_room(np.random.default_rng(1))
    assert len(drawn.blocks) == 7
    ways = np.random.default_rng(0).normal(size=(20000, 3)).astype(np.float32)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    eye = np.array([drawn.eye], np.float32)
    one, many = (cast(boxes_of(drawn), origins, ways) for origins in (eye, eye.repeat(len(ways), axis=0)))
    assert (many[0] >= 6).any()
    for found, expected in zip(one, many, strict=True):
        np.testing.assert_array_equal(found, expected)


def test_supersampling_edges_alone_gives_the_map_of_supersampling_everything():
    # 512 rows, so that mullions are as wide as a texel and none is missed by the first rays.
    drawn = draw_room(np.random.default_rng(0))
    sparse, full = bake_room(drawn), bake_room(drawn, edge_contrast=-1.0)
    same = (sparse == full).all(axis=-1)
    assert 0.05 < same.mean() < 1.0
    # Elsewhere the radiance over three texels is within the contrast, so a texel's middle and its mean are, too; of
    # the largest value near by, which is at most 1 / (1 - contrast) times the mean.
    rest = ~same
    bound = EDGE_CONTRAST / (1.0 - EDGE_CONTRAST)
    within = np.abs(sparse[rest] - full[rest]) <= bound * full[rest]
    # Joints of the floor's boards, 3 mm wide, are the only features narrower than a texel.
    assert within.all(axis=-1).mean() > 0.999
    # The signs of these errors are mixed: the light on the table is that of the full map to 0.1 %.
    np.testing.assert_allclose(irradiance(sparse, 1.0, ()), irradiance(full, 1.0, ()), rtol=1e-3)


def test_the_map_of_a_lamp_has_its_irradiance():
    black = room((lamp(size=(1.0, 1.0)),), reflectance=0.0)
    # A square of half side a, 2 m over the patch: four corner rectangles (Siegel and Howell, configuration 4). The
    # fading rim is a stack of squares.
    half = 0.5 * (1.0 - 2.0 * LAMP_RIM * (np.arange(64) + 0.5) / 64) / 2.0
    corner = 2.0 * half / np.sqrt(1.0 + half**2) * np.arctan(half / np.sqrt(1.0 + half**2)) / (2.0 * math.pi)
    expected = math.pi * 10.0 * 4.0 * corner.mean()
    # Texels of 0.7 degrees, four rays each, on a lamp 28 degrees wide whose rim is linear over 1.1 degrees: the
    # trapezoidal rule is off by at most (step / width)^2 = (0.35 / 28)^2 there, and by the cosine within a texel.
    found = irradiance(bake_room(black, 256), 1.0, ())[0]
    assert found == pytest.approx(expected, rel=1e-3)


def test_a_white_room_keeps_the_energy_in_any_shape():
    flat = room((lamp(size=(0.5, 0.5)),), reflectance=0.8, size=(6.0, 3.0, 2.5))
    sides = (3.0 * 2.5, 3.0 * 2.5, 6.0 * 2.5, 6.0 * 2.5, 6.0 * 3.0, 6.0 * 3.0)
    absorbed = 0.2 * sum(side * grid[..., 0].mean() for side, grid in zip(sides, solved(flat), strict=True))
    # The midpoints of the lamp's 4 x 4 parts lie within its rim: they all have the full radiance.
    flux = math.pi * 10.0 * 0.25
    # The lamp is 0.25 / 81 of all faces and absorbs what falls on it, at each of 1 / (1 - 0.8) bounces: 1.5 %. After 24
    # bounces 0.8^25 = 0.4 % of the light is left. The rest of the 3 % is for 64 rays a cell.
    assert absorbed == pytest.approx(flux, rel=0.03)
