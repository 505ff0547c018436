from __future__ import annotations

import numpy as np

from glassware.procedural.profiles.curve import MAX_LENGTH, MAX_TURN, Curve, arc, simplified


def test_a_simplified_arc_keeps_its_chords_within_the_tolerance():
    dense = arc(np.array([0.05, 0.0]), 0.04, -1.5, 1.5)
    tolerance = 60e-6
    coarse = simplified(dense, tolerance)
    middles = 0.5 * (coarse.points[1:] + coarse.points[:-1])
    sagitta = 0.04 - np.hypot(*(middles - (0.05, 0.0)).T)
    # Dense points stand 1.4 mm apart here, so a chord may miss the arc by their own sagitta more.
    own = 0.04 * (1.0 - np.cos(np.radians(1.0)))
    assert sagitta.max() <= tolerance + own
    assert len(coarse.points) < len(dense.points)
    np.testing.assert_array_equal(coarse.points[[0, -1]], dense.points[[0, -1]])


def test_a_small_arc_is_limited_by_the_turn_of_its_normal():
    coarse = simplified(arc(np.array([0.05, 0.0]), 0.001, 0.0, np.pi), 1e-3)
    turns = np.arccos(np.clip((coarse.normals[1:] * coarse.normals[:-1]).sum(1), -1.0, 1.0))
    assert turns.max() <= MAX_TURN + 1e-9
    assert len(coarse.points) >= np.pi / MAX_TURN


def test_a_straight_line_is_cut_by_the_longest_segment_alone():
    z = np.linspace(0.0, 0.095, 951)
    line = Curve(np.stack([np.full_like(z, 0.03), z], -1), np.tile([1.0, 0.0], (len(z), 1)))
    coarse = simplified(line, 1e-6)
    assert np.hypot(*np.diff(coarse.points, axis=0).T).max() <= MAX_LENGTH
    assert len(coarse.points) <= 12
