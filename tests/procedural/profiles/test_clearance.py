"""Distances from glass that are sought within a bound are those that are sought without one."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.randomness import stream
from glassware.procedural.contents.room import MeshRoom, RevolvedRoom, Room, room_of
from glassware.procedural.optics.catalogue import soda_lime
from glassware.procedural.shaped_vessels.draw import draw_shaped_vessel
from glassware.procedural.vessels.draw import draw_vessel
from glassware.procedural.vessels.settings import VesselSettings


def room(category: str) -> Room:
    """The inside of a drawn vessel: of revolution, or of any shape."""
    settings = VesselSettings.model_validate({"categories": [category], "fill_probability": 0.0, "chord_error": 2e-4})
    given = {"id": 2, "name": "vessel", "glass": soda_lime()}
    if category == "square glass":
        found = room_of(draw_shaped_vessel(stream(2, 0, "vessel"), settings, **given)[0])
    else:
        found = room_of(draw_vessel(stream(2, 0, "vessel"), settings, **given))
    assert found is not None
    return found


@pytest.mark.parametrize(("category", "kind"), [("tumbler", RevolvedRoom), ("square glass", MeshRoom)])
@pytest.mark.parametrize("within", [0.0005, 0.004])
def test_a_bound_changes_no_distance_below_it(category, kind, within):
    found = room(category)
    assert isinstance(found, kind)
    reach = 1.3 * found.widest
    points = np.random.default_rng(3).uniform([-reach, -reach, -0.01], [reach, reach, 1.2 * found.brim], (4000, 3))
    every, near = found.clearance(points), found.clearance(points, within)
    known = np.isfinite(near)
    np.testing.assert_array_equal(near[known], every[known])
    assert known[np.abs(every) <= within].all()
    assert 0 < known.sum() < len(points)
