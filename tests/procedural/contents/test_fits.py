"""Places of bodies in vessels."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.contents.fits import bead_places, ice_places
from glassware.procedural.contents.room import RevolvedRoom
from glassware.procedural.description.floating import GAP

#: A vial: a body of 9.8 mm, a shoulder, and a neck of 7.4 mm [m].
INNER = np.array([[0.0, 0.0], [0.0098, 0.0], [0.0098, 0.025], [0.0074, 0.030], [0.0074, 0.040]])
OUTER = np.array([[0.0, -0.001], [0.0108, -0.001], [0.0108, 0.0255], [0.0084, 0.0305], [0.0084, 0.040]])


@pytest.mark.parametrize("seed", range(6))
def test_beads_on_top_of_each_other_stay_clear_of_a_shoulder(seed: int) -> None:
    room, radius = RevolvedRoom(OUTER, INNER), 0.0055
    places = bead_places(np.random.default_rng(seed), room, radius, 12, [])
    assert len(places) >= 2
    assert room.clearance(places).min() >= radius
    apart = np.linalg.norm(places[:, None] - places, axis=2)[np.triu_indices(len(places), 1)]
    assert apart.min() >= 2.0 * radius + 0.5 * GAP


def test_ice_that_sinks_has_room_down_to_the_floor() -> None:
    inner, outer = [[0.0, 0.0], [0.04, 0.0], [0.04, 0.12]], [[0.0, -0.001], [0.041, -0.001], [0.041, 0.12]]
    room = RevolvedRoom(np.array(outer), np.array(inner))
    bead = np.random.default_rng(0).normal(size=(4000, 3))
    bead = 0.008 * bead / np.linalg.norm(bead, axis=1, keepdims=True) + [0.0, 0.0, 0.009]
    edges, half = np.array([0.02]), 0.01
    for seed in range(20):
        places = ice_places(np.random.default_rng(seed), room, edges, 0.08, [bead], sinks=True)
        assert places is not None
        x, y, turn = places[0]
        c, s = np.cos(turn), np.sin(turn)
        local = (bead[:, :2] - [x, y]) @ np.array([[c, -s], [s, c]])
        assert np.abs(local).max(1).min() > half
