"""Vessels with something dry in them: they stand, and what is in them is a body."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.dataset.settings.draw import draw
from glassware.procedural.description.bodies import GlassBody
from glassware.procedural.description.edits import in_world, solid_of
from glassware.procedural.description.scene import Scene, content_solid
from glassware.procedural.physics.bodies import mechanics_of
from glassware.procedural.placement.overlap import contains
from glassware.procedural.primitives.bodies import ball
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.scene.validate import check_scene

BEADS = dict.fromkeys(("layered", "turbid", "ice", "bubbles", "standing"), 0.0) | {"beads": 0.5}
SKY = {"room_share": 0.0, "shipped_share": 0.0}


def _drawn(seed: int, categories: list[str], **physics: float) -> Scene:
    settings = {
        "vessels": {"categories": categories, "fill_probability": 0.0, "contents": BEADS},
        "vessel_count": (3, 3),
        "prop_count": (3, 3),
        "props": {"kinds": ["orange", "lemon"]},
        "physics": physics,
        "environment": SKY,
        "cameras": {"views": 1},
    }
    return draw_scene(SceneSettings.model_validate(settings), seed, 0)


def test_vessels_with_beads_stand_where_empty_ones_lie() -> None:
    vessels = [item for seed in range(2) for item in _drawn(seed, ["tumbler", "beaker"], lying_probability=1.0).vessels]
    assert {bool(item.contents) for item in vessels} == {True, False}
    for item in vessels:
        assert (item.world_T_object[2, 2] > 0.999) == bool(item.contents), item.name


def test_beads_are_a_part_of_the_body_that_others_meet() -> None:
    vessel = next(item for item in _drawn(0, ["bowl"]).vessels if item.contents)
    beads = _points(vessel, 0).reshape(vessel.contents[0].count, -1, 3)
    assert contains(solid_of(vessel), beads.mean(axis=1)).all()


@pytest.mark.slow
def test_an_orange_does_not_come_to_rest_in_the_beads_of_a_cup() -> None:
    """It did, and the picture was refused: paths in a bead met the orange without leaving the glass."""
    scene = draw(97, 154, preset="train")
    orange = next(item for item in scene.props if item.category == "orange")
    filled = [item for item in scene.vessels if item.contents and not item.liquids]
    assert filled
    beads = [_points(item, number) for item in filled for number in range(len(item.contents))]
    assert not contains(solid_of(orange), np.concatenate(beads)).any()


def _points(vessel: GlassBody, number: int) -> np.ndarray:
    """The vertices of one of its contents, in the world."""
    return in_world(content_solid(vessel, number), vessel.world_T_object).points


def test_what_is_in_a_liquid_changes_nothing_of_the_body_with_it() -> None:
    """Ice in water lies within the body as others meet it; counted twice, it would be a hole."""
    settings = {
        "vessels": {"categories": ["beaker"], "fill_probability": 1.0, "contents": BEADS | {"beads": 0.0, "ice": 1.0}},
        "vessel_count": (1, 1),
        "prop_count": (0, 0),
        "environment": SKY,
        "cameras": {"views": 1},
    }
    (vessel,) = draw_scene(SceneSettings.model_validate(settings), 0, 0).vessels
    assert vessel.liquid is not None
    below = content_solid(vessel, 0).vertices[:, 2] < vessel.liquid.level - 1e-3
    assert below.sum() > 10
    assert contains(solid_of(vessel), _points(vessel, 0)[below][:50]).all()


def test_a_ball_has_no_place_in_beads_that_rise_out_of_a_shallow_liquid() -> None:
    scene = _with_beads_in_shallow_water()
    (bowl,) = scene.vessels
    points = _points(bowl, 0)
    top = points[points[:, 2].argmax()]
    assert bowl.liquid is not None
    assert top[2] - bowl.world_T_object[2, 3] > bowl.liquid.contact + 2e-3
    glass = ball(0.005, bowl.glass, centre=tuple(top.tolist()), name="marble")
    with pytest.raises(InputError, match=r"^marble: expected a place of its own .*, found that it overlaps vessel-00$"):
        scene.add(glass)
    check_scene(scene)


def test_beads_weigh_what_their_volume_does_beside_the_liquid_that_they_displace() -> None:
    (bowl,) = _with_beads_in_shallow_water().vessels
    found = mechanics_of(bowl)
    (beads,) = bowl.contents
    assert bowl.liquid is not None
    assert bowl.liquid.medium.density is not None
    assert beads.medium.density is not None
    assert found.empty is not None
    wanted = bowl.liquid.volume * bowl.liquid.medium.density + beads.volume * beads.medium.density
    assert found.whole.mass - found.empty.mass == pytest.approx(wanted, rel=0.01)
    assert beads.volume * beads.medium.density > 0.1 * wanted


def _with_beads_in_shallow_water() -> Scene:
    vessels = {"categories": ["bowl"], "fill_probability": 1.0, "fill": (0.02, 0.1), "liquids": ["water"]}
    settings = {
        "vessels": vessels | {"contents": BEADS | {"beads": 1.0}},
        "vessel_count": (1, 1),
        "prop_count": (0, 0),
        "environment": SKY,
        "cameras": {"views": 1},
    }
    return draw_scene(SceneSettings.model_validate(settings), 1, 0)
