"""What is in drawn vessels: what finds no room is left out and counted."""

from __future__ import annotations

import pytest

from glassware.core.errors import InputError
from glassware.core.randomness import stream
from glassware.procedural.contents.draw import draw_contents
from glassware.procedural.contents.settings import ContentsSettings
from glassware.procedural.optics.catalogue import soda_lime, water
from glassware.procedural.vessels.draw import draw_vessel
from glassware.procedural.vessels.settings import VesselSettings

#: As good as always, but not a demand.
ALMOST_SURE = 1.0 - 1e-9
NOTHING = dict.fromkeys(("layered", "turbid", "ice", "beads", "bubbles", "standing"), 0.0)


def _drawn(category, filled, fill=(0.4, 0.6), seed=1, **contents):
    chosen = {"categories": [category], "fill_probability": filled, "fill": fill, "chord_error": 2e-4}
    settings = VesselSettings.model_validate(chosen)
    given = {"id": 2, "name": "vessel", "glass": soda_lime(), "liquid_medium": water()}
    vessel = draw_vessel(stream(seed, 0, "vessel"), settings, **given)
    wanted = ContentsSettings.model_validate(NOTHING | contents)
    return draw_contents(lambda kind: stream(seed, 0, kind), wanted, vessel, may_stand=True).vessel


@pytest.mark.parametrize(("category", "radius", "found"), [("beaker", 0.004, 5), ("volumetric flask", 0.01, 0)])
def test_beads_that_cannot_come_in_are_counted(category, radius, found):
    vessel = _drawn(category, 0.0, beads=ALMOST_SURE, bead_radius=(radius, radius), bead_count=(5, 5))
    assert sum(content.count for content in vessel.contents) == found
    assert vessel.redrawn == (0 if found else 1)


def test_bubbles_without_room_are_counted():
    big = {"bubbles": ALMOST_SURE, "bubble_radius": (0.002, 0.002)}
    assert _drawn("beaker", 1.0, fill=(0.5, 0.5), **big).redrawn == 0
    # A puddle is shallower than they are.
    assert _drawn("beaker", 1.0, fill=(0.03, 0.03), **big).redrawn == 1


@pytest.mark.parametrize(
    ("category", "contents"),
    [
        ("volumetric flask", {"beads": 1.0, "bead_radius": (0.01, 0.01)}),
        ("beaker", {"bubbles": 1.0, "bubble_radius": (0.002, 0.002)}),
    ],
)
def test_what_is_always_asked_for_and_has_no_room_is_refused_by_its_setting(category, contents):
    name = next(iter(contents))
    with pytest.raises(InputError, match=rf"vessels\.contents\.{name}: expected a probability below 1.*{category}"):
        _drawn(category, 1.0, fill=(0.03, 0.03), **contents)


@pytest.mark.parametrize(("category", "seed"), [("test tube", 3), ("tumbler", 5)])
def test_a_vessel_that_is_nearly_full_takes_nothing_that_would_make_it_run_over(category, seed):
    full = {"fill": (0.93, 0.95), "seed": seed}
    vessel = _drawn(category, 1.0, **full, standing=ALMOST_SURE)
    assert vessel.redrawn == 3  # a straw, a spoon and a rod in turn
    alone = _drawn(category, 1.0, **full)
    assert [liquid.volume for liquid in vessel.liquids] == [liquid.volume for liquid in alone.liquids]
