"""Polygons as triangles: the areas of outlines that are not convex."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.mesh_files.polygons import triangulated

NOTCHED = np.array([[0, 0], [9, 0], [9, 9], [6, 9], [6, 3], [3, 3], [3, 9], [0, 9]], float)


def _area(outline: np.ndarray) -> float:
    x, y = outline.T
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


@pytest.mark.parametrize("axes", [(0, 1, 2), (2, 0, 1), (1, 2, 0), (1, 0, 2)])
@pytest.mark.parametrize("turn", range(8))
def test_the_triangles_of_a_notched_outline_cover_it_and_face_as_it_does(axes: tuple, turn: int) -> None:
    flat = np.roll(NOTCHED, turn, axis=0)
    points = np.concatenate([flat, np.full((8, 1), 2.0)], axis=1)[:, axes]
    triangles, owner = triangulated(np.arange(8), np.array([8]), points)
    corners = points[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert 0.5 * np.linalg.norm(cross, axis=1).sum() == pytest.approx(_area(NOTCHED))
    assert (cross @ cross[0] > 0).all()
    assert (owner == 0).all()


def test_a_star_and_a_dented_quadrilateral_are_covered() -> None:
    angle = np.arange(14) * np.pi / 7
    star = np.stack([np.cos(angle), np.sin(angle)], 1) * np.where(np.arange(14) % 2, 0.4, 1.0)[:, None]
    dented = np.array([[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]])
    for outline in (star, *(np.roll(dented, k, axis=0) for k in range(4))):
        points = np.pad(outline, ((0, 0), (0, 1)))
        corners = points[triangulated(np.arange(len(points)), np.array([len(points)]), points)[0]]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
        assert (cross > 0).all()
        assert 0.5 * cross.sum() == pytest.approx(_area(outline))


def test_polygons_of_several_sizes_keep_their_order() -> None:
    points = np.random.default_rng(0).normal(size=(20, 3))
    triangles, owner = triangulated(np.arange(14), np.array([3, 4, 2, 5]), points)
    assert owner.tolist() == [0, 1, 1, 3, 3, 3]
    assert triangles[0].tolist() == [0, 1, 2]
    assert set(triangles[1:3].ravel().tolist()) == {3, 4, 5, 6}
