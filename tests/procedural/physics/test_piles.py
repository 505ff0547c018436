"""Drawn scenes with piles: the same everywhere, without overlap, filled vessels upright, faults in one line."""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import combinations

import numpy as np
import pytest

from glassware.annotate.keypoints import scene_keypoints
from glassware.core.errors import InputError
from glassware.dataset.format.dataset_file import PileCounts, counted_in
from glassware.dataset.format.objects_file import objects_file
from glassware.procedural.description.bodies import GlassBody
from glassware.procedural.description.edits import solid_of
from glassware.procedural.description.scene import Scene
from glassware.procedural.placement.overlap import overlap
from glassware.procedural.placement.placement import CONTACT_GAP
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.scene_file import load_scene, save_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.scene.validate import check_scene

SKY = {"room_share": 0.0, "shipped_share": 0.0}
PILE = {"physics": {"piled_probability": 1.0}, "environment": SKY, "cameras": {"views": 1}}
_DIGEST = """
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.scene_file import scene_digest
from glassware.procedural.scene.settings import SceneSettings
print(scene_digest(draw_scene(SceneSettings.model_validate({settings}), 4, 1)))
"""


def _settings(**more: object) -> SceneSettings:
    return SceneSettings.model_validate({**PILE, **more})


@pytest.fixture(scope="module")
def scene() -> Scene:
    return draw_scene(_settings(vessel_count=(2, 2), prop_count=(4, 4)), 4, 1)


def test_nothing_overlaps_and_nothing_is_in_the_table(scene):
    solids = [solid_of(item) for item in scene.objects]
    assert not any(overlap(first, second) for first, second in combinations(solids, 2))
    assert min(solid.points[:, 2].min() for solid in solids) >= 0.5 * CONTACT_GAP


@pytest.mark.slow
def test_no_vessel_that_leans_stands_in_the_table_with_its_rounded_foot():
    """Rays that leave its glass there meet the table first, and the picture is refused."""
    drawn = draw_scene(SceneSettings(), 61, 1)
    assert drawn.rest is not None
    vial = drawn.vessels[0]
    assert vial.category == "vial"
    assert vial.world_T_object[2, 2] < 1.0
    assert solid_of(vial).points[:, 2].min() >= 0.5 * CONTACT_GAP


def test_everything_touches_the_table_or_something_that_does(scene):
    assert scene.rest is not None
    reached, pairs = {1}, scene.rest.contacts
    for _ in pairs:
        reached |= {one for pair in pairs if reached & set(pair) for one in pair}
    assert reached == {1, *(item.id for item in scene.objects if item.part_of is None and item.within is None)}


def test_a_phone_whose_convex_parts_are_slivers_and_a_flask_with_a_scale_pile_up():
    # Cuts leave slivers of a phone that lie in a plane, of which a simulation cannot make a body.
    props = {"kinds": ["phone"]}
    vessels = {"categories": ["flask"], "label_probability": 1.0, "closed_probability": 0.0, "fill_probability": 0.0}
    drawn = draw_scene(_settings(vessel_count=(1, 1), prop_count=(2, 2), props=props, vessels=vessels), 3, 0)
    assert drawn.rest is not None
    assert [item.category for item in drawn.objects if item.part_of] == ["print"]


def test_a_full_vessel_of_four_corners_that_nothing_touches_does_not_spoil_a_pile():
    # On soft contacts it leans by a third of a milliradian, whatever falls beside it.
    vessels = {"categories": ["square glass"], "label_probability": 0.0, "fill_probability": 1.0}
    settings = _settings(vessel_count=(1, 1), prop_count=(1, 1), props={"kinds": ["carton"]}, vessels=vessels)
    rests = [draw_scene(settings, 4, number).rest for number in (1, 2, 5)]
    assert [rest.attempt for rest in rests if rest is not None] == [1, 1, 1]


def test_a_pile_survives_its_file(scene, tmp_path):
    save_scene(scene, tmp_path / "scene.json")
    found = load_scene(tmp_path / "scene.json")
    assert found.rest == scene.rest
    np.testing.assert_array_equal(found.objects[-1].world_T_object, scene.objects[-1].world_T_object)


@pytest.mark.slow
def test_the_same_seed_has_the_same_poses_whatever_the_number_of_threads():
    code = _DIGEST.format(settings={**PILE, "vessel_count": (2, 2), "prop_count": (4, 4)})
    found = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "2", "7")
    }
    assert len(found) == 1


@pytest.mark.slow
@pytest.mark.parametrize("number", range(6))
def test_filled_vessels_stand_exactly_upright(number):
    drawn = draw_scene(_settings(vessels={"fill_probability": 1.0}), 6, number)
    for item in drawn.objects:
        if isinstance(item, GlassBody) and item.liquid is not None:
            np.testing.assert_array_equal(item.world_T_object[2], [0.0, 0.0, 1.0, item.world_T_object[2, 3]])


def test_an_empty_vessel_lies_where_it_should():
    lying = {"physics": {"piled_probability": 0.0, "lying_probability": 1.0}, "vessels": {"fill_probability": 0.0}}
    drawn = draw_scene(_settings(vessel_count=(2, 2), prop_count=(0, 0), **lying), 2, 0)
    for vessel in drawn.vessels:
        assert abs(vessel.world_T_object[2, 2]) < np.cos(np.radians(29.0))


def test_a_pile_that_cannot_come_to_rest_is_refused_with_its_settings(monkeypatch):
    from glassware.procedural.physics import rest

    monkeypatch.setattr(rest, "STILL_DISTANCE", -1.0)  # nothing is that still
    settings = _settings(
        vessel_count=(0, 0), prop_count=(1, 1), physics={"piled_probability": 1.0, "attempts": 2, "longest_time": 2.0}
    )
    with pytest.raises(InputError, match=r"physics\.attempts, physics\.longest_time: expected a pile that comes"):
        draw_scene(settings, 1, 0)


def test_a_pile_that_nobody_asked_for_and_cannot_come_to_rest_stands_apart_and_is_counted(monkeypatch):
    from glassware.procedural.physics import rest

    monkeypatch.setattr(rest, "STILL_DISTANCE", -1.0)  # nothing is that still
    physics = {"piled_probability": 0.999, "attempts": 2, "longest_time": 2.0}
    scene = draw_scene(_settings(vessel_count=(0, 0), prop_count=(3, 3), physics=physics), 1, 0)
    assert scene.rest is not None
    assert scene.rest.given_up
    check_scene(scene)
    standing = draw_scene(
        _settings(vessel_count=(0, 0), prop_count=(3, 3), physics=physics | {"piled_probability": 0.0}), 1, 0
    )
    for prop, apart in zip(scene.props, standing.props, strict=True):
        np.testing.assert_array_equal(prop.world_T_object, apart.world_T_object)
    assert objects_file(scene, scene_keypoints(scene)).objects[0].touches is None
    assert counted_in(PileCounts(), scene.rest) == PileCounts(drawn_again=1, given_up=1)


@pytest.mark.parametrize(
    ("physics", "line"),
    [
        ({"drop_height": (0.05, 0.01)}, "expected the smaller number first"),
        ({"piled_probability": 1.2}, "less than or equal to 1"),
        ({"longest_time": 0.0}, "greater than or equal to 2"),
    ],
)
def test_impossible_settings_are_refused(physics, line):
    with pytest.raises(ValueError, match=line):
        _settings(physics=physics)
