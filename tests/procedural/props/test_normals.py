"""Shading normals with creases."""

from __future__ import annotations

import numpy as np
import trimesh

from glassware.procedural.props.normals import creased


def test_a_cube_keeps_its_edges() -> None:
    cube = trimesh.creation.box()
    vertices, faces, normals, _ = creased(cube.vertices, cube.faces)
    assert len(vertices) == 24
    assert np.allclose(normals[faces], cube.face_normals[:, None])


def test_a_ball_is_smooth() -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    vertices, _, normals, _ = creased(ball.vertices, ball.faces)
    assert len(vertices) == len(ball.vertices)
    # Faces of 4 degrees average to the radial direction within a small part of that.
    assert np.sum(vertices * normals, axis=1).min() > np.cos(np.radians(1.0))


def test_the_angle_decides() -> None:
    """Two squares that meet at 30 degrees are one surface, at 50 degrees two."""
    for angle, count in ((30, 4), (50, 6)):
        up = np.radians(angle)
        vertices = np.array([[0, 0, 0], [0, 1, 0], [-1, 0, 0], [np.cos(up), 0, np.sin(up)]])
        faces = np.array([[0, 1, 2], [0, 3, 1]])
        assert len(creased(vertices, faces)[0]) == count


def test_texture_seams_do_not_show_in_the_shading() -> None:
    """Vertices doubled for their texture coordinates share their normal."""
    vertices = np.array([[0, 0, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0.2], [0, 0, 0], [0, 1, 0]], float)
    faces = np.array([[0, 1, 2], [4, 3, 5]])
    uv = np.arange(12.0).reshape(6, 2)
    _, corner, normals, kept = creased(vertices, faces, uv)
    assert np.array_equal(normals[corner[0, 0]], normals[corner[1, 0]])
    assert np.array_equal(kept[corner], uv[faces])
