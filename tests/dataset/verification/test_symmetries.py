"""Stated symmetries are motions of the shape onto itself, and others are found."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.annotate.keypoints import scene_keypoints
from glassware.core.randomness import stream
from glassware.dataset.format.objects_file import ContinuousSymmetry, objects_file
from glassware.dataset.verification.symmetries import reach_of, symmetry_faults
from glassware.procedural.optics.medium import Medium
from glassware.procedural.placement.resting import turn_about_z
from glassware.procedural.shaped_vessels.draw import draw_shaped_vessel
from glassware.procedural.vessels.draw import draw_vessel
from glassware.procedural.vessels.settings import SHAPED, VesselSettings

GLASS = Medium(name="test glass", eta=1.52)
#: A faceted glass of seven sides: the middle of its box is 1.4 mm beside its axis.
SEVEN = ("faceted glass", 32)
#: One in the quick suite, all families in the slow one.
DRAWN = [SEVEN, *(pytest.param((name, seed), marks=pytest.mark.slow) for name in sorted(SHAPED) for seed in range(6))]


@pytest.fixture
def stated(optical_bench):
    """A drawn vessel and its record: family and seed in."""

    def draw(category, seed):
        settings = VesselSettings(categories=(category,), fill_probability=0.0)
        rng = stream(seed, 0, "vessel")
        if category in SHAPED:
            vessel = draw_shaped_vessel(rng, settings, id=2, name="vessel", glass=GLASS)[0]
        else:
            vessel = draw_vessel(rng, settings, id=2, name="vessel", glass=GLASS)
        scene = optical_bench.surrounded((vessel,), (optical_bench.camera((0.0, 0.0, 1.0)),))
        return vessel, objects_file(scene, scene_keypoints(scene)).objects[0]

    return draw


@pytest.mark.parametrize("drawn", DRAWN)
def test_turns_of_drawn_vessels_put_them_onto_themselves_but_for_their_irregularities(stated, drawn):
    vessel, record = stated(*drawn)
    assert symmetry_faults(vessel, record, "objects.json") == []


def test_turns_about_the_middle_of_the_box_are_found(stated):
    """An odd number of sides has no opposite ones: its box stands off its axis."""
    vessel, record = stated(*SEVEN)
    assert len(record.symmetries_discrete) == 6
    beside = [np.asarray(motion)[:2, 3] for motion in record.symmetries_discrete]
    assert np.linalg.norm(beside, axis=1).max() > 1e-3
    turns = tuple(turn_about_z(2.0 * np.pi * number / 7.0) for number in range(1, 7))
    wrong = symmetry_faults(vessel, record.model_copy(update={"symmetries_discrete": turns}), "objects.json")
    assert len(wrong) >= 4


def test_an_axis_of_revolution_beside_the_body_is_found(stated):
    vessel, record = stated("tumbler", 1)
    assert symmetry_faults(vessel, record, "objects.json") == []
    beside = 1.2 * reach_of(vessel, turns=True)
    axes = (ContinuousSymmetry(axis=(0.0, 0.0, 1.0), offset=(beside, 0.0, 0.0)),)
    (fault,) = symmetry_faults(vessel, record.model_copy(update={"symmetries_continuous": axes}), "objects.json")
    assert fault.check == "objects"
    assert "symmetries" in fault.where
