"""Light through vessels with something in them, on them and around them: no segment is in a wrong medium."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from glassware.procedural.description.scene import Scene
from glassware.procedural.scene.twins import painted
from glassware.render.pictures.picture import MediumError, trace_picture
from glassware.render.renderer import Renderer
from glassware.render.scene.loaded_scene import load

#: What a vessel has in it or on it, by name: its family, other settings of vessels, and contents that are certain.
CASES: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "ice": ("tumbler", {}, {"ice": 1.0}),
    "straw": ("beaker", {}, {"standing": 1.0, "standing_kinds": ("straw",)}),
    "spoon": ("tumbler", {}, {"standing": 1.0, "standing_kinds": ("spoon",)}),
    "stirring rod": ("beaker", {}, {"standing": 1.0, "standing_kinds": ("stirring rod",)}),
    "beads": ("tumbler", {}, {"beads": 1.0}),
    "bubbles": ("tumbler", {}, {"bubbles": 1.0}),
    "layers": ("tumbler", {}, {"layered": 1.0}),
    "espresso": ("cup", {}, {"turbid": 1.0, "turbid_liquids": ("espresso",)}),
    "milk and spoon": (
        "mug",
        {},
        {"turbid": 1.0, "turbid_liquids": ("milk",), "standing": 1.0, "standing_kinds": ("spoon",)},
    ),
    "label and cap": ("square bottle", {"closed_probability": 1.0, "label_probability": 1.0}, {}),
    "rack": ("test tube", {}, {}),
}


@pytest.fixture(scope="module")
def vessel_with(drawn, all_clear):
    """(case, light) -> a scene of one vessel that is filled and has what the case says."""

    def draw(case: str, light: str) -> Scene:
        family, settings, contents = CASES[case]
        vessels = {"fill_probability": 1.0, "fill": (0.4, 0.7), "rough_probability": 0.0, "categories": (family,)}
        return drawn(
            2,
            vessel_count=(1, 1),
            prop_count=(0, 0),
            vessels=all_clear | vessels | settings | {"contents": all_clear["contents"] | contents},
            cameras={"views": 1, "width": 64, "height": 48},
            picture={"spp": 8, "light": light},
        )

    return draw


@pytest.mark.parametrize("part", ["liquid_surface", "wet_wall"])
def test_a_missing_surface_of_a_turbid_liquid_is_caught_though_all_its_others_are_opaque(backend, vessel_with, part):
    scene = vessel_with("milk and spoon", "path")
    vessel = scene.vessels[0]
    milk = [item for item in vessel.interfaces if item.opaque is not None]
    gone = next(item for item in milk if item.part == part)
    assert len(milk) > 1
    kept = tuple(item for item in vessel.interfaces if item is not gone)
    spoiled = scene.model_copy(update={"vessels": (vessel.model_copy(update={"interfaces": kept}),)})
    trace_picture(load(scene), scene.cameras[0], "left", seed=1)
    with pytest.raises(MediumError, match="interface is missing"):
        trace_picture(load(spoiled), scene.cameras[0], "left", seed=1)


def test_paths_that_shading_normals_lead_into_a_painted_vessel_count_for_nothing_at_its_wetted_wall(
    backend, vessel_with
):
    scene = painted(vessel_with("straw", "path"))
    scene = scene.model_copy(update={"picture": scene.picture.model_copy(update={"spp": 64})})
    assert any(item.opaque is None for item in scene.vessels[0].interfaces)
    assert trace_picture(load(scene), scene.cameras[0], "left", seed=1).violations == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("light", ["shared", "path"])
@pytest.mark.parametrize("case", CASES)
def test_pictures_are_finite_the_same_again_and_their_light_is_checked(backend, vessel_with, case, light):
    scene = vessel_with(case, light)
    renderer = Renderer(scene)
    first, second = renderer.frame(0), Renderer(scene).frame(0)
    for eye in ("left", "right"):
        assert np.isfinite(getattr(first, eye)).all()
        np.testing.assert_array_equal(getattr(first, eye), getattr(second, eye))
    assert (renderer.light_check is not None) == (light == "shared")
