"""What `bench/world.py` looks for: it finds faults that are put in, and none where there are none."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from glassware.procedural.contents.shapes import balls
from glassware.procedural.description.scene import Scene
from glassware.procedural.optics.catalogue import soda_lime
from glassware.procedural.primitives.bodies import vessel
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings

BENCH = Path(__file__).resolve().parents[2] / "bench"


@pytest.fixture(scope="module")
def checks():
    sys.path.insert(0, str(BENCH))
    yield import_module("world_checks")
    sys.path.remove(str(BENCH))


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Two tumblers with a liquid."""
    return draw_scene(
        SceneSettings.model_validate(
            {
                "vessel_count": (2, 2),
                "prop_count": (0, 0),
                "vessels": {
                    "categories": ["tumbler"],
                    "fill_probability": 1.0,
                    "contents": dict.fromkeys(("layered", "turbid", "ice", "beads", "bubbles", "standing"), 0.0),
                },
                "cameras": {"views": 1, "width": 64, "height": 48},
                "environment": {"room_share": 0.0, "shipped_share": 0.0},
            }
        ),
        1,
        0,
    )


def test_volumes_are_those_of_closed_forms(checks):
    ball = balls(np.zeros((1, 3)), np.array([0.03]), "ball", 4)
    assert checks.monte_carlo(ball, 1) == pytest.approx(4.0 / 3.0 * np.pi * 0.03**3, rel=5e-3)  # facets, and chance
    cone = np.array([[0.0, 0.0], [0.03, 0.09]])
    assert checks.below(cone, 0.06) == pytest.approx(np.pi / 3.0 * 0.02**2 * 0.06)


def test_a_sound_scene_has_no_faults(checks, scene):
    found = checks.checked(scene)
    assert (found["faults"], found["overlaps"], found["pairs"]) == ([], [], 1)
    for what, allowed in (("walls", checks.WALL), ("closed_forms", checks.VOLUME), ("volumes", checks.VOLUME)):
        assert len(found[what]) == 2
        assert all(abs(ratio - 1.0) < allowed for _, ratio in found[what].values()), what


def test_what_is_wrong_is_found(checks, scene):
    one, two = scene.vessels
    # As if a wall were asked for that is a tenth thicker, and a liquid held 2 % more than it does.
    assert one.liquid is not None
    wrong = one.liquid.model_copy(update={"volume": 1.02 * one.liquid.volume})
    thicker = one.model_copy(update={"wall": 1.1 * one.wall, "liquid": wrong})
    pose = two.world_T_object.copy()
    pose[:2, 3] = one.world_T_object[:2, 3] + [0.48 * (one.size[0] + two.size[0]), 0.0]
    inside = two.model_copy(update={"world_T_object": pose})
    found = checks.checked(scene.model_copy(update={"vessels": (thicker, inside)}))
    assert found["overlaps"] == [[one.name, two.name]]
    assert abs(found["walls"][one.name][1] - 1.0) > checks.WALL
    for what in ("closed_forms", "volumes"):
        assert abs(found[what][f"{one.name}/0"][1] - 1.0) > checks.VOLUME


def test_a_vessel_by_hand_has_the_wall_of_its_profiles(checks):
    made = vessel([(0.03, 0.0), (0.036, 0.12)], soda_lime())
    assert checks._wall_of_profile(made) == pytest.approx(made.wall, rel=checks.WALL)
