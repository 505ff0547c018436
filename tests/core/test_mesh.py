"""Closed surfaces: what is wrong with those that are not, and where."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from glassware.core.errors import InputError
from glassware.core.mesh import Mesh, check_closed

BOX = trimesh.creation.box(extents=(0.2, 0.2, 0.2))


def found(faces: np.ndarray, vertices: np.ndarray = BOX.vertices) -> str:
    with pytest.raises(InputError) as error:
        check_closed("body", Mesh("m", vertices, faces))
    return str(error.value).partition("found ")[2]


def test_a_box_is_closed() -> None:
    check_closed("body", Mesh("m", BOX.vertices, BOX.faces))


def test_holes_are_counted_and_the_first_is_placed() -> None:
    line = found(BOX.faces[1:])
    assert line.startswith("3 edges with one triangle (holes), the first at (")
    place = np.array([float(text) for text in line.partition("at (")[2].rstrip(") m").split(", ")])
    corners = BOX.vertices[BOX.faces[0]]
    middles = 0.5 * (corners + np.roll(corners, 1, axis=0))
    assert np.abs(middles - place).max(axis=1).min() < 1e-4


def test_edges_of_more_than_two_triangles_are_a_reason_of_their_own() -> None:
    # Two boxes with a common edge: every edge is passed as often forth as back.
    other = BOX.vertices + np.array([0.2, 0.2, 0.0])
    line = found(np.concatenate([BOX.faces, BOX.faces + 8]), np.concatenate([BOX.vertices, other]))
    assert line.startswith("1 edges that more than two triangles share, the first at (0.1, 0.1, 0)")


def test_a_triangle_that_is_turned_is_a_reason_of_its_own() -> None:
    turned = BOX.faces.copy()
    turned[0] = turned[0][::-1]
    assert "3 edges between triangles of opposite turn" in found(turned)
