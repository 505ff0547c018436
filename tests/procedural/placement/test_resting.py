from __future__ import annotations

import numpy as np
import pytest
import trimesh

from glassware.core.mesh import Mesh
from glassware.procedural.placement.resting import lowered, resting_pose, stable_faces, turn_about_z

#: Positions are float32 of decimetres.
POSITION = 1e-7


def _box(x: float, y: float, z: float) -> Mesh:
    solid = trimesh.creation.box(extents=(x, y, z))
    return Mesh("box", solid.vertices, solid.faces)


def _moved(mesh: Mesh, pose: np.ndarray) -> np.ndarray:
    return mesh.vertices.astype(float) @ pose[:3, :3].T + pose[:3, 3]


def test_a_cube_rests_on_each_side_alike():
    normals, odds = stable_faces(_box(0.1, 0.1, 0.1).vertices.astype(float))
    assert len(normals) == 6
    np.testing.assert_allclose(odds, 1.0 / 6.0, atol=1e-6)
    np.testing.assert_allclose(np.sort(np.abs(normals), axis=1), [[0, 0, 1]] * 6, atol=1e-6)


def test_a_box_rests_on_its_sides_by_the_solid_angles_that_they_take():
    a, b, c = 0.1, 0.06, 0.02
    normals, odds = stable_faces(_box(a, b, c).vertices.astype(float))

    def solid_angle(width, height, distance):
        # Of a rectangle seen from over its middle (Khadjavi 1968, eq. 5).
        return 4.0 * np.arctan(width * height / (2.0 * distance * np.sqrt(4.0 * distance**2 + width**2 + height**2)))

    sides = [solid_angle(b, c, a / 2), solid_angle(a, c, b / 2), solid_angle(a, b, c / 2)]
    assert sum(sides) == pytest.approx(2.0 * np.pi)
    for axis in range(3):
        found = odds[np.abs(normals[:, axis]) > 0.99]
        np.testing.assert_allclose(found, sides[axis] / (4.0 * np.pi), rtol=1e-5)


def test_a_body_never_rests_where_its_centre_of_mass_is_not_over_the_face():
    # A leaning prism: its top hangs over, so that it falls off its small base.
    base = np.array([[0, 0, 0], [0.02, 0, 0], [0.02, 0.02, 0], [0, 0.02, 0]])
    top = base + np.array([0.1, 0.0, 0.05])
    normals, odds = stable_faces(np.concatenate([base, top]))
    assert odds.sum() == pytest.approx(1.0)
    assert not (np.abs(normals[:, 2]) > 0.999).any()


@pytest.mark.parametrize("seed", range(5))
def test_a_resting_body_touches_the_table_on_a_face_and_nowhere_sinks(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, 3)) * [0.05, 0.03, 0.02]
    hull = trimesh.convex.convex_hull(points)
    mesh = Mesh("rock", hull.vertices, hull.faces)
    pose = resting_pose(mesh, rng)
    placed = _moved(mesh, pose)
    assert abs(placed[:, 2].min()) < POSITION
    touching = placed[placed[:, 2] < 10 * POSITION]
    assert len(touching) >= 3
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-9)
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    # The centre of mass stands over the touching corners' hull.
    centre = trimesh.Trimesh(placed, mesh.faces).center_mass[:2]
    from scipy.spatial import ConvexHull

    sides = ConvexHull(touching[:, :2]).equations
    assert (sides[:, :2] @ centre + sides[:, 2]).max() < 1e-6


def test_faces_are_drawn_by_their_probabilities():
    mesh, count = _box(0.1, 0.06, 0.02), 500
    rng = np.random.default_rng(1)
    up = [np.abs(resting_pose(mesh, rng)[2, :3]).argmax() for _ in range(count)]
    normals, probabilities = stable_faces(mesh.vertices.astype(float))
    for axis in range(3):
        p = probabilities[np.abs(normals[:, axis]) > 0.99].sum()
        # Four standard deviations of a binomial fraction.
        assert abs(np.mean(np.array(up) == axis) - p) < 4.0 * np.sqrt(p * (1 - p) / count)


def test_lowering_moves_along_z_alone():
    mesh, pose = _box(0.1, 0.06, 0.02), turn_about_z(0.3)
    pose[:3, 3] = [1.0, 2.0, 3.0]
    after = lowered(pose, mesh)
    np.testing.assert_array_equal(after[:3, :3], pose[:3, :3])
    np.testing.assert_array_equal(after[:2, 3], pose[:2, 3])
    assert abs(_moved(mesh, after)[:, 2].min()) < POSITION
