"""The random lamps."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from glassware.core.assets import asset
from glassware.procedural.description.surroundings import (
    AreaLight,
    Block,
    ConstantEnvironment,
    RoomEnvironment,
    SkyEnvironment,
    Window,
)
from glassware.procedural.surroundings.file_light import shows_open_sky
from glassware.procedural.surroundings.hdri import hdri_files, read_hdri
from glassware.procedural.surroundings.lamps import LAMPS, lamp_flux, lamp_luminance
from glassware.procedural.surroundings.lights import aimed, draw_lights
from glassware.procedural.surroundings.photometry import photometry
from glassware.procedural.surroundings.room_places import CLEARANCE, fits_in_room, room_corners
from glassware.procedural.surroundings.rooms import draw_room
from glassware.procedural.surroundings.settings import LightSettings
from glassware.procedural.surroundings.shipped_light import shipped_maps
from glassware.procedural.surroundings.skies import draw_sky

SETTINGS = LightSettings()
REACH = 1.1
DARK = np.zeros((4, 8, 3), dtype=np.float32)
ROOMS = [draw_room(np.random.default_rng(1000 + seed)) for seed in range(300)]
MANY = [draw_lights(np.random.default_rng(seed), SETTINGS, REACH, room, DARK) for seed, room in enumerate(ROOMS)]
LIGHTS = [light for drawn in MANY for light in drawn]


def room(**changes) -> RoomEnvironment:
    window = Window(wall="+x", centre=(2.0, 1.5), size=(1.0, 1.0), radiance=(1.0, 1.0, 1.0))
    values = {"size": (6.0, 5.0, 3.0), "eye": (2.0, 3.0, 0.7), "wall_colours": ((0.5,) * 3,) * 6}
    return RoomEnvironment(**{**values, "windows": (window,), "seed": 1, **changes})


def lamp(centre: tuple[float, float, float], size=(0.4, 0.4), **changes) -> AreaLight:
    pose = aimed(np.array(centre), np.array(centre) - [0.0, 0.0, 1.0], 0.0)
    return AreaLight(**{"world_T_light": pose, "size": size, "radiance": (1.0, 1.0, 1.0), **changes})


def test_rooms_have_none_to_three_lamps():
    assert {len(drawn) for drawn in MANY} == {0, 1, 2, 3}


def test_under_an_open_sky_there_are_no_lamps():
    for seed in range(40):
        rng = np.random.default_rng(seed)
        assert draw_lights(rng, SETTINGS, REACH, draw_sky(rng), DARK) == ()


def test_drawn_lamps_measure_what_real_ones_do():
    assert {light.kind for light in LIGHTS} == set(SETTINGS.kinds)
    for light in LIGHTS:
        kind = LAMPS[light.kind]
        assert kind.length[0] <= light.size[0] <= kind.length[1]
        width = kind.length if kind.width is None else kind.width
        assert width[0] <= light.size[1] <= width[1]
        flux = lamp_flux(light)
        assert kind.flux[0] * (1 - 1e-9) <= flux <= kind.flux[1] * (1 + 1e-9)
        assert lamp_luminance(light) == pytest.approx(flux / (math.pi * light.size[0] * light.size[1]), rel=1e-9)
        assert lamp_luminance(light) <= kind.most_luminance * (1 + 1e-9)


def test_lamps_hang_inside_their_room_clear_of_walls_and_furniture():
    steps = np.linspace(-0.5, 0.5, 13)
    for number, drawn in enumerate(MANY):
        home = ROOMS[number]
        cos, sin = math.cos(home.rotation), math.sin(home.rotation)
        room_T_world = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        for light in drawn:
            local = np.array([[u * light.size[0], v * light.size[1], 0.0, 1.0] for u in steps for v in steps])
            points = (local @ light.world_T_light.T)[:, :3] @ room_T_world.T + home.eye
            assert points.min() >= CLEARANCE
            assert (points <= np.array(home.size) - CLEARANCE).all()
            for block in home.blocks:
                outside = (points < np.array(block.lower) - CLEARANCE) | (points > np.array(block.upper) + CLEARANCE)
                assert outside.any(axis=1).all()


def test_lamps_do_not_cross_each_other():
    for drawn in MANY:
        for number, light in enumerate(drawn):
            for other in drawn[:number]:
                apart = np.linalg.norm(light.world_T_light[:3, 3] - other.world_T_light[:3, 3])
                assert apart > 0.5 * (math.hypot(*light.size) + math.hypot(*other.size))


def test_no_point_of_a_lamp_is_within_the_cameras_reach():
    for light in LIGHTS:
        steps = np.linspace(-0.5, 0.5, 9)
        local = np.array([[u * light.size[0], v * light.size[1], 0.0, 1.0] for u in steps for v in steps])
        points = (local @ light.world_T_light.T)[:, :3]
        assert np.linalg.norm(points, axis=1).min() >= REACH + SETTINGS.margin
        assert points[:, 2].min() > 0.0


def test_lamps_have_rigid_poses_and_look_near_the_centre():
    for light in LIGHTS:
        rotation, centre = light.world_T_light[:3, :3], light.world_T_light[:3, 3]
        np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-12)
        assert np.linalg.det(rotation) > 0.0
        hit = centre - rotation[:, 2] * centre[2] / rotation[2, 2]
        assert np.linalg.norm(hit) <= SETTINGS.aim + 1e-9


def test_lamps_are_warm_to_white():
    for light in LIGHTS:
        red, _, blue = light.radiance
        assert 0.0 < blue / red < 1.1


def test_a_small_lamp_lights_the_table_by_the_inverse_square():
    # Straight above, facing down: a Lambertian source of 1000 lm has 1000 / pi cd towards its normal.
    size, flux, height = 0.02, 1000.0, 1.5
    level = 1e-3 * flux / (math.pi * size**2)
    bulb = lamp((0.0, 0.0, height), (size, size), kind="bulb", radiance=(level,) * 3)
    found = photometry(ConstantEnvironment(radiance=(0.0, 0.0, 0.0)), (bulb,))
    assert found.lamps[0].flux == pytest.approx(flux, rel=1e-9)
    assert found.lamps[0].luminance == pytest.approx(flux / (math.pi * size**2), rel=1e-9)
    # The lamp is a hundredth of its distance wide: the square of that is left out.
    assert found.illuminance == pytest.approx(flux / math.pi / height**2, rel=2e-4)
    assert found.environment_illuminance == 0.0


def test_an_even_sky_lights_the_table_by_pi_times_its_luminance():
    found = photometry(ConstantEnvironment(radiance=(0.2, 0.2, 0.2), strength=3.0), ())
    assert found.illuminance == pytest.approx(math.pi * 600.0, rel=1e-6)
    assert found.sun_illuminance is None
    sky = SkyEnvironment(
        sun_elevation=1.0,
        sun_illuminance=80.0,
        sun_radius=0.01,
        turbidity=3.0,
        cloudiness=0.0,
        ground=(0.2, 0.2, 0.2),
        seed=1,
    )
    assert photometry(sky, ()).sun_illuminance == pytest.approx(80e3)


def test_a_lamp_fits_where_no_part_of_it_is_beyond_a_wall():
    # The table's centre is 2 m and 3 m from the corner, the ceiling 2.3 m above it.
    assert fits_in_room(room(), lamp((0.0, 0.0, 2.2)))
    assert not fits_in_room(room(), lamp((0.0, 0.0, 2.26)))
    assert not fits_in_room(room(), lamp((-1.9, 0.0, 1.0)))
    assert fits_in_room(room(), lamp((-1.74, 0.0, 1.0)))
    # Turned by a quarter, the wall 2 m away at -x is at -y.
    turned = room(rotation=math.pi / 2)
    assert fits_in_room(turned, lamp((0.0, -1.74, 1.0)))
    assert not fits_in_room(turned, lamp((0.0, -1.9, 1.0)))
    np.testing.assert_allclose(room_corners(turned, lamp((0.0, -1.0, 1.0))).mean(axis=0), [1.0, 3.0, 1.7], atol=1e-12)


def test_a_lamp_that_a_block_pierces_has_no_place():
    # The post goes through the middle of the lamp; no corner is in it.
    post = Block(lower=(2.95, 2.95, 0.0), upper=(3.05, 3.05, 2.5), colour=(0.5, 0.5, 0.5))
    with_post = room(blocks=(post,))
    assert not fits_in_room(with_post, lamp((1.0, 0.0, 1.0)))
    assert fits_in_room(with_post, lamp((1.31, 0.0, 1.0)))
    assert fits_in_room(with_post, lamp((1.0, 0.0, 1.9)))


def test_the_kinds_can_be_chosen_and_no_lamps_asked_for():
    settings = LightSettings(kinds=("tube",), max_count=2)
    drawn = [draw_lights(np.random.default_rng(seed), settings, REACH, ROOMS[seed], DARK) for seed in range(20)]
    assert {light.kind for lights in drawn for light in lights} == {"tube"}
    none = LightSettings(max_count=0)
    assert draw_lights(np.random.default_rng(0), none, REACH, ROOMS[0], DARK) == ()


def test_in_a_room_without_a_place_there_are_no_lamps():
    assert draw_lights(np.random.default_rng(1), SETTINGS, 12.0, ROOMS[0], DARK) == ()


@pytest.mark.parametrize("bad", [{"max_count": -1}, {"kinds": ()}, {"kinds": ("candle",)}, {"elevation": (1.0, 0.5)}])
def test_settings_out_of_range_name_the_field(bad):
    with pytest.raises(ValidationError, match=next(iter(bad))):
        LightSettings(**bad)


def test_real_maps_are_told_outdoors_from_indoors(shared_assets: Path):
    found = {path.stem: shows_open_sky(read_hdri(asset(path))) for path in hdri_files(shared_assets / "hdri")}
    outdoors = {name for name, open_sky in found.items() if open_sky}
    assert outdoors == {"city", "dawn", "forest", "park", "venice"}


def test_shipped_maps_are_told_outdoors_from_indoors():
    outdoors = {path.stem for path in shipped_maps() if shows_open_sky(read_hdri(asset(path)))}
    assert outdoors == {"city", "forest", "night", "sunrise", "sunset"}
