"""Lines of vessels: circles of a solid of revolution, whichever way they are found."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.annotate.outlines import boundary, fill_lines, holes_at, openings
from glassware.dataset.settings.draw import draw
from glassware.procedural.description.scene import Vessel, glass_solid
from glassware.procedural.primitives.bodies import box_mesh


@pytest.fixture(scope="module")
def tumbler(analytic):
    return analytic.scene(views=1).vessels[0]


def _radii(line):
    return np.hypot(line[:, 0], line[:, 1])


def test_the_mouth_of_a_vessel_is_the_circle_on_its_rim(analytic, tumbler):
    (mouth,) = openings(tumbler)
    np.testing.assert_allclose(_radii(mouth), (analytic.RADIUS + analytic.BORE) / 2)
    np.testing.assert_allclose(mouth[:, 2], analytic.HEIGHT / 2)


def test_the_holes_of_a_solid_at_a_height_are_those_of_its_cavities(analytic, tumbler):
    (hole,) = holes_at(glass_solid(tumbler), 0.0)
    assert _radii(hole).max() <= analytic.BORE + 1e-6
    assert _radii(hole).min() >= analytic.BORE * np.cos(np.pi / analytic.SEGMENTS) - 1e-6
    np.testing.assert_allclose(hole[:, 2], 0.0, atol=1e-9)
    assert holes_at(glass_solid(tumbler), -analytic.HEIGHT / 2 + analytic.FLOOR / 2) == []  # through the floor
    assert holes_at(box_mesh((0.1, 0.1, 0.1), "box"), 0.01) == []


def test_the_edge_of_an_open_surface_is_found_and_a_closed_one_has_none(tumbler):
    assert boundary(glass_solid(tumbler)) == []


def test_a_fill_line_is_the_contact_line():
    # Families of revolution, upright and with one liquid: where their wall is at a height follows from their profile.
    kinds = {"categories": ["tumbler", "bottle"], "contents": {"layered": 0.0, "ice": 0.0}}
    settings = {"vessel_count": [2, 2], "prop_count": [0, 0], "physics": {"piled_probability": 0.0}}
    vessels = draw(1, vessels=kinds | {"fill_probability": 1.0}, **settings).vessels
    for body in vessels:
        assert isinstance(body, Vessel)
        assert body.liquid is not None
        (line,) = fill_lines(body)
        np.testing.assert_allclose(line[:, 2], body.liquid.contact, atol=1e-6)
        inner = np.array(body.inner)
        np.testing.assert_allclose(_radii(line), np.interp(body.liquid.contact, inner[:, 1], inner[:, 0]), atol=1e-5)
