"""Light that cannot be is refused by name."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.description.scene import Scene
from glassware.procedural.description.surroundings import (
    AreaLight,
    Block,
    LampKind,
    RoomEnvironment,
    SkyEnvironment,
    Window,
)
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives import bodies, scenes
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.scene.validate import check_scene
from glassware.procedural.surroundings.lamps import LAMPS
from glassware.procedural.surroundings.lights import aimed
from glassware.procedural.surroundings.sun import SUN_RADIUS

GLASS = Medium(name="glass", eta=1.5, sigma_a=(0.0, 0.0, 0.0))


def _sky(**changes) -> SkyEnvironment:
    values = {"sun_elevation": 0.8, "sun_illuminance": 90.0, "sun_radius": SUN_RADIUS, "turbidity": 3.0}
    values |= {"cloudiness": 0.0, "ground": (0.2, 0.2, 0.2), "seed": 1}
    return SkyEnvironment(**{**values, **changes})


def _room() -> RoomEnvironment:
    window = Window(wall="+x", centre=(2.0, 1.5), size=(1.0, 1.0), radiance=(1.0, 1.0, 1.0))
    shelf = Block(lower=(0.0, 2.0, 0.0), upper=(0.5, 4.0, 2.0), colour=(0.5, 0.5, 0.5))
    return RoomEnvironment(
        size=(5.0, 6.0, 3.0),
        eye=(2.5, 3.0, 0.7),
        wall_colours=((0.5, 0.5, 0.5),) * 6,
        windows=(window,),
        blocks=(shelf,),
        seed=1,
    )


def _lamp(centre=(0.0, 0.5, 1.5), flux: float = 3500.0, size=(0.6, 0.6), kind: LampKind = "panel") -> AreaLight:
    level = 1e-3 * flux / (math.pi * size[0] * size[1])
    pose = aimed(np.array(centre), np.array([0.0, 0.0, -0.1]), 0.0)
    return AreaLight(kind=kind, world_T_light=pose, size=size, radiance=(level, level, level))


def _scene(environment=None, *lights: AreaLight) -> Scene:
    ball = bodies.glass_body(bodies.ball_mesh(0.05, 3, "ball", (0.0, 0.0, 0.06)), GLASS)
    camera = scenes.camera((0.0, -0.8, 0.5))
    return scenes.scene((ball,), (camera,), environment=environment or _room(), lights=lights)


def _refused(scene: Scene) -> str:
    with pytest.raises(InputError) as caught:
        check_scene(scene)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_light_that_can_be_passes():
    check_scene(_scene(_sky()))
    check_scene(_scene(None, _lamp()))


@pytest.mark.parametrize("radius", [0.0045, 0.1])
def test_a_sun_of_another_size_is_refused(radius):
    assert _refused(_scene(_sky(sun_radius=radius))).startswith(
        "environment.sun_radius: expected the sun's 0.00465 rad"
    )


@pytest.mark.parametrize("changes", [{"sun_illuminance": 140.0}, {"sun_illuminance": 100.0, "strength": 1.4}])
def test_a_sun_brighter_than_above_the_atmosphere_is_refused(changes):
    said = _refused(_scene(_sky(**changes)))
    assert said == "environment.sun_illuminance: expected at most 133.8 klx, as above the atmosphere, found 140 klx"


@pytest.mark.parametrize("kind", LAMPS)
def test_a_lamp_brighter_than_its_kind_can_be_is_refused(kind):
    lamp = LAMPS[kind]
    size = (lamp.length[0], (lamp.width or lamp.length)[0])
    centre = (0.0, 0.5, 1.5)
    check_scene(_scene(None, _lamp(centre, lamp.flux[1], size, kind)))
    said = _refused(_scene(None, _lamp(centre, 1.01 * lamp.flux[1], size, kind)))
    assert said.startswith(f"light 0, radiance: expected at most the luminance of a {kind}")
    large = (lamp.length[1], (lamp.width or lamp.length)[1])
    said = _refused(_scene(None, _lamp(centre, 1.01 * lamp.flux[1], large, kind)))
    assert said.startswith(f"light 0, radiance: expected at most the luminous flux of a {kind}, {lamp.flux[1]:g} lm")


@pytest.mark.parametrize("centre", [(0.0, 0.5, 2.4), (2.6, 0.0, 1.0), (-2.2, 0.0, 0.9)])
def test_a_lamp_outside_its_room_or_in_a_block_is_refused(centre):
    said = _refused(_scene(None, _lamp(centre)))
    assert said.startswith("light 0, world_T_light: expected a place in the room, outside its furniture")
    # A rectangle stands for no thing in the room: files from before the kinds have them anywhere.
    check_scene(_scene(None, _lamp(centre, kind="rectangle")))


def test_a_lamp_in_an_object_the_table_or_an_eye_is_refused():
    assert "in body" in _refused(_scene(None, _lamp((0.0, 0.0, 0.06), size=(0.3, 0.3), kind="rectangle")))
    table = AreaLight(world_T_light=_upright(-0.01), size=(0.2, 0.2), radiance=(1.0, 1.0, 1.0))
    assert "in the table" in _refused(_scene(None, table))
    assert "an eye of camera 0 in it" in _refused(_scene(None, _lamp((0.0, -0.8, 0.5), kind="rectangle")))


def _upright(height: float) -> np.ndarray:
    pose = np.eye(4)
    pose[2, 3] = height
    return pose


def test_a_lamp_without_area_is_refused():
    flat = _lamp().model_copy(update={"size": (0.5, 0.0)})
    assert _refused(_scene(None, flat)).startswith("light 0, size: expected sides above 0 m")


def test_drawn_scenes_of_many_seeds_have_light_that_can_be():
    settings = SceneSettings(vessel_count=(0, 1), prop_count=(0, 0))
    kinds = set()
    for seed in range(6):
        scene = draw_scene(settings, seed, 0)
        check_scene(scene)
        kinds |= {scene.environment.kind, *(light.kind for light in scene.lights)}
    assert {"sky", "room"} < kinds
