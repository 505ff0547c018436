"""Vertical lines meet the faces that they go through, and no others."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from glassware.procedural.cavities.columns import _crossings, solid_runs


def through(corners: np.ndarray, lines: np.ndarray) -> set[tuple[int, int]]:
    """Pairs of lines and faces, by each line's barycentric coordinates in every face seen from above."""
    found = set()
    for number, (a, b, c) in enumerate(corners):
        matrix = np.stack([b - a, c - a], axis=1)
        if abs(np.linalg.det(matrix)) > 0.0:
            u, v = np.linalg.solve(matrix, (lines - a).T)
            found |= {(int(line), number) for line in np.flatnonzero((u > 0.0) & (v > 0.0) & (u + v < 1.0))}
    return found


@pytest.mark.parametrize("seed", range(4))
def test_lines_go_through_the_faces_above_and_below_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    # Needles that lie askew, small faces, and faces as large as the grid; some edges are exactly along the rows.
    faces = np.arange(3 * 60).reshape(-1, 3)
    vertices = np.concatenate([rng.uniform(0.0, 9.0, (90, 3)), rng.uniform(3.0, 3.8, (90, 3))])
    vertices[1:30:3] = vertices[0:30:3] + rng.uniform(-0.01, 0.01, (10, 3))
    vertices[91:120:3, 0] = vertices[90:120:3, 0]
    nx, ny = 40, 40
    origin, pitch = np.array([-0.123, -0.077]), 0.25
    line, face, height, _ = _crossings(vertices, faces, origin, pitch, ny)
    x, y = np.divmod(np.arange(nx * ny), ny)
    lines = origin + pitch * np.stack([x, y], axis=1)
    assert set(zip(line.tolist(), face.tolist(), strict=True)) == through(vertices[faces][..., :2], lines)
    assert len(line) > 500
    # Heights are those of the faces' planes.
    a, b, c = (vertices[faces[face, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    place = np.column_stack([lines[line], height]) - a
    np.testing.assert_allclose(np.einsum("ij,ij->i", normal, place), 0.0, atol=1e-9)


def test_the_lines_in_a_slanted_box_sum_to_its_volume() -> None:
    box = trimesh.creation.box((0.08, 0.002, 0.05), trimesh.transformations.euler_matrix(0.3, 0.2, 0.7))
    pitch = 2e-4
    volume = solid_runs(np.asarray(box.vertices), np.asarray(box.faces), pitch).sum() * pitch**2
    assert volume == pytest.approx(box.volume, rel=2e-3)
