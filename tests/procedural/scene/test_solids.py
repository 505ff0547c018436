"""What the cameras of a scene look at, and where they cannot stand."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives.bodies import ball
from glassware.procedural.primitives.scenes import board, camera
from glassware.procedural.scene.solids import EMPTY_RADIUS, workspace

GLASS = Medium(name="glass", eta=1.5)


@pytest.fixture(scope="module")
def space():
    """Two balls of 4 cm, 20 cm apart, over a board."""
    places = {"left": -0.1, "right": 0.1}
    balls = [ball(0.04, GLASS, (x, 0.0, 0.05), id=2 + i, name=name) for i, (name, x) in enumerate(places.items())]
    return workspace(balls, board())


def test_the_ball_around_the_objects_holds_them(space):
    assert space.centre == pytest.approx([0.0, 0.0, 0.05], abs=1e-3)
    assert space.radius == pytest.approx(0.14, abs=1e-3)
    empty = workspace([], board())
    assert (empty.radius, empty.centre.tolist()) == (EMPTY_RADIUS, [0.0, 0.0, 0.0])


def test_an_eye_in_a_body_or_in_the_table_is_blocked_and_says_how_high_it_is(space):
    for eye in ((-0.11, 0.0, 0.06), (-0.16, 0.001, 0.05)):  # the left eye, and the right one 6.5 cm beside it
        blocked = space.blocked(camera(eye, (eye[0], 1.0, eye[2])))
        assert blocked is not None
        assert blocked.found.endswith("in left")
        assert blocked.top == pytest.approx(0.09, abs=1e-3)
    below = space.blocked(camera((0.0, 0.0, -0.005), (1.0, 0.0, 0.3)))
    assert below is not None
    assert below.found.endswith("in the table")
    under = space.blocked(camera((0.1, 0.0, -0.3), (0.0, 0.0, 0.0)))
    assert under is not None
    assert under.found.endswith("under the table")
    assert space.blocked(camera((0.0, -0.3, 0.3))) is None


def test_a_vessel_is_shown_where_its_middle_is_in_both_pictures(space):
    assert space.shown(camera((0.0, -0.4, 0.3)))
    assert not space.shown(camera((0.0, -0.4, 0.3), (0.0, -0.8, 0.3)))
    # 5 cm before the ball at f = 640 px the right picture shows it 832 px farther left, out of its 640.
    near = camera((0.1, -0.05, 0.05), (0.1, 0.0, 0.05), baseline=0.065)
    left = np.linalg.inv(near.world_T_camera) @ [0.1, 0.0, 0.05, 1.0]
    assert left[:2] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert not space.shown(near)
