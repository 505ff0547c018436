"""Surfaces of bodies, split where a liquid's surface meets them."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from glassware.core.mesh import Mesh, volume_of
from glassware.procedural.cavities.split import split_at, without_folds
from glassware.procedural.contents.shapes import rod


@pytest.fixture(scope="module")
def leaning_rod() -> Mesh:
    """A stirring rod of 5 mm, leaning by 30 degrees; its facets are ten times as long as wide."""
    straight = rod(0.0025, 0.2, "rod")
    turn = Rotation.from_euler("y", 0.5).as_matrix()
    return Mesh("rod", (straight.vertices @ turn.T).astype(np.float32), straight.faces)


def _levels(mesh: Mesh) -> np.ndarray:
    """Heights by which vertices of the rod's side lie, a hair above or below them."""
    heights = mesh.vertices[(mesh.vertices[:, 2] > 0.05) & (mesh.vertices[:, 2] < 0.12), 2].astype(np.float64)
    return (heights[::7, None] + np.array([-3e-6, -3e-7, -1e-8, 1e-8, 3e-7, 3e-6])).ravel()


def test_points_of_the_line_are_one_or_far_enough_apart_to_stay_two_in_another_frame(leaning_rod):
    levels = _levels(leaning_rod)
    assert len(levels) > 60
    for level in levels:
        halves = split_at(leaning_rod, lambda points, level=level: points[:, 2] - level)
        assert len(halves.rings) == 1
        ring = halves.rings[0].astype(np.float64)
        assert np.linalg.norm(ring - np.roll(ring, -1, axis=0), axis=1).min() > 1e-7
        assert np.abs(ring[:, 2] - level).max() < 3e-7


def test_both_halves_together_are_the_body(leaning_rod):
    whole = volume_of(leaning_rod)
    for level in _levels(leaning_rod)[::5]:
        halves = split_at(leaning_rod, lambda points, level=level: points[:, 2] - level)
        assert halves.below is not None
        assert halves.above is not None
        volumes = []
        for half in (halves.below, halves.above):
            corners = half.vertices.astype(np.float64)[half.faces] - [0.0, 0.0, level]  # about a point of the cut
            volumes.append(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0)
        assert sum(volumes) == pytest.approx(whole, rel=1e-4)


def test_two_faces_that_lie_on_each_other_face_down_are_left_out():
    box = trimesh.creation.box()
    flap = np.array([[1, 2, 7], [1, 7, 2], [3, 4, 4]])
    faces = np.concatenate([flap[:1], box.faces, flap[1:]])
    kept = without_folds(Mesh("box", box.vertices.astype(np.float32), faces))
    assert kept.faces.tolist() == box.faces.tolist()
