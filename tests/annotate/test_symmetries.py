"""Symmetries are those of the shapes, found without being told."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from glassware.annotate.symmetries import is_ball, motions_of
from glassware.core.mesh import Mesh
from glassware.procedural.props.blocks import extrusion
from glassware.procedural.props.shapes import SHAPES, draw_shape


def shape(category: str, seed: int = 1):
    return SHAPES[category](np.random.default_rng(seed), 0.1, "shape")


def block(*size: float) -> Mesh:
    box = trimesh.creation.box(size)
    return Mesh("block", box.vertices, box.faces)


def polygon(sides: int) -> Mesh:
    turn = 2 * np.pi * np.arange(sides) / sides
    return extrusion("prism", np.stack([np.cos(turn), np.sin(turn)], axis=1), 0.6)[0]


@pytest.mark.parametrize(
    ("size", "count"), [((1.0, 2.0, 3.0), 4), ((1.0, 1.0, 3.0), 8), ((2.0, 1.0, 1.0), 8), ((1.0, 1.0, 1.0), 24)]
)
def test_a_block_has_the_rotations_of_its_sides(size, count):
    """D2, D4 about any axis, and the cube's O: orders 4, 8 and 24."""
    assert len(motions_of(block(*size))) == count


@pytest.mark.parametrize("sides", [3, 5, 6, 7, 8])
def test_a_prism_has_the_rotations_of_its_polygon(sides):
    """The dihedral group: as many turns as sides, and as many half turns across. Its middle need not be the frame's."""
    motions = motions_of(polygon(sides))
    assert len(motions) == 2 * sides
    np.testing.assert_array_equal(motions[0], np.eye(4))


@pytest.mark.parametrize(
    ("category", "count"), [("cylinder", 2), ("plain can", 2), ("ring", 2), ("capsule", 2), ("cone", 1), ("cup", 1)]
)
def test_a_solid_of_revolution_may_stand_upside_down_where_both_ends_are_alike(category, count):
    mesh = shape(category).mesh
    assert len(motions_of(mesh, turns=True)) == count
    assert not is_ball(mesh)


def test_only_a_ball_is_a_ball():
    assert is_ball(shape("ball").mesh)


@pytest.mark.parametrize(("category", "count"), [("box", 4), ("superellipsoid", 4), ("stone", 1), ("plain book", 2)])
def test_other_shapes_have_their_half_turns(category, count):
    assert len(motions_of(shape(category).mesh)) == count


@pytest.mark.parametrize("seed", range(20))
def test_every_motion_puts_the_surface_onto_itself(seed):
    drawn = draw_shape(np.random.default_rng(seed), 0.1, "shape")
    vertices = drawn.mesh.vertices.astype(np.float64)
    for motion in motions_of(drawn.mesh, drawn.symmetric):
        np.testing.assert_allclose(motion[:3, :3] @ motion[:3, :3].T, np.eye(3), rtol=0, atol=1e-12)
        assert np.linalg.det(motion[:3, :3]) == pytest.approx(1.0)
        moved = vertices @ motion[:3, :3].T + motion[:3, 3]
        far = cKDTree(vertices).query(moved)[0] > 1e-3 * 0.1
        # The middle of a prism's end is where its faces meet, and no place of its own.
        assert far.sum() <= (2 if drawn.category == "prism" else 0)
