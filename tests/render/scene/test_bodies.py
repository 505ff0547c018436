"""Meshes cut finer keep their shape, their shading and their texture, and have no cracks."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from glassware.core.mesh import Mesh, as_trimesh
from glassware.render.scene.bodies import refined

#: Longest edge that is asked for; the ball's are 0.1 to 0.2.
LONGEST = 0.04


@pytest.fixture(scope="module")
def meshes(backend):
    solid = trimesh.creation.icosphere(subdivisions=2, radius=0.5)
    # Stretched, so that triangles have one, two and three long edges.
    points = np.asarray(solid.vertices) * [1.0, 0.3, 0.1]
    slope = np.array([[0.3, -0.2], [0.1, 0.5], [-0.4, 0.2]])
    mesh = Mesh("ball", points, solid.faces, np.asarray(solid.vertices) / 0.5, points @ slope)
    return mesh, refined(mesh, LONGEST, 10**6), slope


def test_no_edge_is_longer_than_asked(meshes) -> None:
    _, fine, _ = meshes
    corners = fine.vertices[fine.faces]
    assert np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=-1).max() <= LONGEST


def test_the_surface_stays_closed_and_has_the_same_area_and_volume(meshes) -> None:
    mesh, fine, _ = meshes
    before, after = as_trimesh(mesh), as_trimesh(fine)
    assert after.is_watertight
    assert len(after.faces) > 2 * len(before.faces)
    # Float32 coordinates of a body of this size are exact to 6e-8.
    assert after.area == pytest.approx(before.area, rel=1e-5)
    assert after.volume == pytest.approx(before.volume, rel=1e-5)


def test_texture_coordinates_are_interpolated(meshes) -> None:
    _, fine, slope = meshes
    np.testing.assert_allclose(fine.uv, fine.vertices @ slope, atol=1e-6)


def test_faces_look_the_way_they_did(meshes) -> None:
    _, fine, _ = meshes
    a, b, c = (fine.vertices[fine.faces[:, k]] for k in range(3))
    outward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c)
    assert (outward > 0.0).all()


def test_a_mesh_that_is_fine_enough_is_left_alone(meshes) -> None:
    mesh, *_ = meshes
    np.testing.assert_array_equal(refined(mesh, 10.0, 10**6).faces, mesh.faces)
