"""Counterfactual twins: one thing is changed, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.description.scene import Scene
from glassware.procedural.description.twin import TWIN_KINDS, TwinKind
from glassware.procedural.optics.medium import AIR
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.scene_file import load_scene, save_scene, scene_digest
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.scene.validate import check_scene
from glassware.render.frame import Geometry
from glassware.render.renderer import Renderer

SEED = 3


def _drawn(**settings: object) -> Scene:
    simple = {
        "vessel_count": (2, 2),
        "prop_count": (1, 1),
        "vessels": {
            "categories": ["tumbler"],
            "fill_probability": 1.0,
            "contents": {"ice": 0.999, "standing": 0.5, "layered": 0.0, "turbid": 0.0},
        },
        "props": {"kinds": ["shape"]},
        "physics": {"piled_probability": 0.0},
        "environment": {"room_share": 0.0, "shipped_share": 0.0},
        "cameras": {"views": 1, "width": 48, "height": 36},
        "picture": {"spp": 1, "light": "path", "denoise": False},
    }
    return draw_scene(SceneSettings.model_validate(simple | settings), SEED, 0)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return _drawn()


@pytest.fixture(scope="module")
def twins() -> dict[TwinKind, Scene]:
    return {kind: _drawn(twin=kind) for kind in TWIN_KINDS}


@pytest.mark.parametrize("kind", TWIN_KINDS)
def test_a_twin_can_exist_and_says_whose_it_is(scene, twins, kind, tmp_path):
    twin = twins[kind]
    check_scene(twin)
    assert (twin.twin.kind, twin.twin.of) == (kind, scene_digest(scene))
    save_scene(twin, tmp_path / "scene.json")
    assert scene_digest(load_scene(tmp_path / "scene.json")) == scene_digest(twin) != scene_digest(scene)


@pytest.mark.parametrize("kind", TWIN_KINDS)
def test_objects_that_a_twin_keeps_stand_where_they_stood_before_the_same_cameras(scene, twins, kind):
    twin, before = twins[kind], {item.name: item for item in scene.objects}
    assert [item.name for item in twin.props if item.within is None] == ["prop-00"]
    for item in twin.objects:
        assert item.id == before[item.name].id
        assert np.array_equal(item.world_T_object, before[item.name].world_T_object), item.name
    for camera, other in zip(twin.cameras, scene.cameras, strict=True):
        assert np.array_equal(camera.world_T_camera, other.world_T_camera)
        assert np.array_equal(camera.K, other.K)
        assert (camera.exposure == other.exposure) == (kind != "light")


def test_each_kind_of_twin_changes_what_it_is_named_after(scene, twins):
    assert all(body.liquids for body in scene.vessels if body.category == "tumbler")
    assert any(body.contents for body in scene.vessels)
    assert not any(body.liquids or body.contents for body in twins["empty"].vessels)
    assert twins["clean-plate"].vessels == ()
    assert [prop.name for prop in twins["clean-plate"].props] == ["prop-00"]
    assert twins["light"].environment != scene.environment
    lit = {name: getattr(scene, name) for name in ("environment", "lights", "cameras", "twin")}
    assert scene_digest(twins["light"].model_copy(update=lit)) == scene_digest(scene)
    media = twins["media"]
    assert [body.glass for body in media.vessels] != [body.glass for body in scene.vessels]
    assert (media.environment, media.lights) == (scene.environment, scene.lights)
    for body, other in zip(media.vessels, scene.vessels, strict=True):
        volumes = [sum(liquid.volume for liquid in one.liquids) for one in (body, other)]
        assert volumes[0] == pytest.approx(volumes[1], rel=1e-3)


def test_all_surfaces_of_glass_and_liquid_that_meet_the_air_are_painted(twins):
    twin = twins["opaque"]
    seen = [part for body in twin.vessels for part in body.interfaces if part.front == AIR]
    assert {part.part for part in seen} >= {"outside", "liquid_surface"}
    assert all(part.opaque is not None for part in seen)
    paints = [body.interfaces[0].opaque for body in twin.vessels if body.part_of is None]
    assert paints[0] != paints[1]


def test_the_first_surfaces_of_a_painted_twin_are_those_of_the_glass_bit_by_bit(scene, twins):
    glass, paint = (Renderer(one).frame(0).geometry for one in (scene, twins["opaque"]))
    assert np.isin(glass.id, [body.id for body in scene.vessels]).sum() > 50
    for name in ("Z", "normal", "id"):
        assert np.array_equal(getattr(glass, name), getattr(paint, name)), name
    assert _behind(glass, scene) > 0
    assert _behind(paint, scene) == 0


def _behind(geometry: Geometry, scene: Scene) -> int:
    """Return how many rays that meet glass go on to another object."""
    glass = np.isin(geometry.id, [body.id for body in scene.vessels])
    return int((glass & (geometry.background_id != geometry.id)).sum())
