"""Ids of categories: everything that is drawn without files has one, for good."""

from __future__ import annotations

import hashlib

import pytest

from glassware.dataset.exports.detection.category_ids import (
    CATEGORY_IDS,
    FIRST_OTHER,
    OPAQUE,
    TRANSPARENT,
    category_ids,
    category_name,
)
from glassware.procedural.contents.settings import STANDING
from glassware.procedural.description.bodies import GlassBody
from glassware.procedural.props.shapes import SHAPES
from glassware.procedural.scene.asset_files import AssetFiles
from glassware.procedural.scene.draw_vessels import draw_vessels
from glassware.procedural.things.kinds import KINDS
from glassware.procedural.vessels.settings import CATEGORIES, VesselSettings

#: Families with a cork and a label, a stopper and a scale, and a rack in the quick suite, all in the slow one.
DRAWN = [
    pytest.param(name, marks=[] if name in ("bottle", "volumetric flask", "test tube") else pytest.mark.slow)
    for name in CATEGORIES
]
#: Rows that data sets have been exported with, and the SHA-256 of them. New rows only add to both.
ROWS, DIGEST = 80, "8271ee163224a2f46f714100f9ea1d32c267f8fb7308fabed64b8ee12c6a1014"


def test_every_family_shape_thing_and_standing_object_has_an_id():
    assert set(CATEGORIES) <= set(TRANSPARENT)
    assert set(SHAPES) | set(KINDS) <= set(OPAQUE)
    assert set(STANDING) <= set(TRANSPARENT) | set(OPAQUE)


@pytest.mark.parametrize("family", DRAWN)
def test_every_part_of_a_vessel_has_an_id(family):
    settings = VesselSettings(
        categories=(family,), chord_error=2e-4, closed_probability=1.0, label_probability=1.0, fill_probability=0.0
    )
    (body,), parts = draw_vessels(settings, 0, 0, 1, AssetFiles())
    for part in parts[body.name]:
        assert part.category in (TRANSPARENT if isinstance(part, GlassBody) else OPAQUE)


def test_ids_and_names_are_unique_and_below_those_of_files():
    ids = [*TRANSPARENT.values(), *OPAQUE.values()]
    assert sorted(ids) == list(range(1, len(ids) + 1))
    assert len(CATEGORY_IDS) == len(ids)
    assert max(ids) < FIRST_OTHER


def test_ids_stay_what_they_were():
    rows = sorted((id, name) for name, id in CATEGORY_IDS.items() if id <= ROWS)
    assert hashlib.sha256(repr(rows).encode()).hexdigest() == DIGEST


def test_other_names_follow_in_their_order():
    assert category_ids(["wine", "mug", "apple", "ant"]) == {"mug": 13, "apple": 55, "ant": 1001, "wine": 1002}


def test_opaque_things_are_not_taken_for_glass_of_the_same_name():
    assert category_name("mug", "prop") == "opaque mug"
    assert category_name("mug", "vessel") == "mug"
    assert category_name("apple", "prop") == "apple"
    assert CATEGORY_IDS["opaque mug"] == OPAQUE["mug"] != TRANSPARENT["mug"]
