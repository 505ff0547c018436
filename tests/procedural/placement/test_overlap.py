from __future__ import annotations

import numpy as np
import pytest
import trimesh

from glassware.procedural.placement.overlap import ALLOWANCE, Solid, contains, hulls_apart, overlap


def _solid(mesh: trimesh.Trimesh, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Solid:
    return Solid(np.asarray(mesh.vertices, float) + shift, np.asarray(mesh.faces))


BALL = trimesh.creation.icosphere(subdivisions=3, radius=0.03)
BOX = trimesh.creation.box(extents=(0.06, 0.06, 0.06))
BAR = trimesh.creation.box(extents=(0.3, 0.01, 0.01))


@pytest.mark.parametrize(("gap", "expected"), [(1e-4, False), (-0.5 * ALLOWANCE, False), (-3.0 * ALLOWANCE, True)])
@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, 0.6, 0.8), (-0.48, 0.6, 0.64)])
def test_two_balls_overlap_by_their_distance(gap, expected, direction):
    # The mesh of the ball lies up to 0.1 mm inside its sphere; vertices face each other along no direction.
    other = _solid(BALL, tuple((0.06 + gap) * np.array(direction)))
    assert overlap(_solid(BALL), other) is expected


def test_crossed_bars_overlap_though_no_vertex_is_inside():
    crossed = _solid(BAR.copy().apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (0, 0, 1))))
    bar = _solid(BAR)
    assert not contains(bar, crossed.points).any()
    assert overlap(bar, crossed)
    assert not overlap(bar, Solid(crossed.points + np.array([0.0, 0.0, 0.0101]), crossed.faces))


def test_a_body_inside_another_overlaps_and_one_in_its_hollow_does_not():
    small = _solid(trimesh.creation.icosphere(subdivisions=2, radius=0.008))
    assert overlap(_solid(BOX), small)
    ring = trimesh.creation.annulus(r_min=0.02, r_max=0.03, height=0.04)
    assert not hulls_apart(np.asarray(ring.vertices), small.points)
    assert not overlap(_solid(ring), small)
    assert overlap(_solid(ring), Solid(small.points + np.array([0.015, 0.0, 0.0]), small.faces))


def test_hulls_a_millimetre_apart_are_parted_by_a_plane(rng):
    for _ in range(50):
        turn = trimesh.transformations.random_rotation_matrix(rng.uniform(size=3))
        box = BOX.copy().apply_transform(turn)
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        ahead = (np.asarray(box.vertices) @ direction).max() - (np.asarray(BALL.vertices) @ direction).min()
        assert hulls_apart(np.asarray(box.vertices), np.asarray(BALL.vertices) + (ahead + 1e-3) * direction)
        assert not hulls_apart(np.asarray(box.vertices), np.asarray(BALL.vertices) + 0.5 * ahead * direction)


def test_points_inside_a_box_and_a_ball_are_found(rng):
    points = rng.uniform(-0.04, 0.04, (500, 3))
    np.testing.assert_array_equal(contains(_solid(BOX), points), (np.abs(points) < 0.03).all(1))
    radius = np.linalg.norm(points, axis=1)
    clear = np.abs(radius - 0.03) > 2e-4  # the mesh lies up to 0.1 mm inside its sphere
    np.testing.assert_array_equal(contains(_solid(BALL), points[clear]), radius[clear] < 0.03)
