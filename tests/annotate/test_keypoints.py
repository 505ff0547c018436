from __future__ import annotations

import numpy as np
import trimesh

from glassware.annotate.keypoints import keypoint_states, keypoints, scene_keypoints
from glassware.annotate.surface import outside_vertices
from glassware.core.mesh import Mesh


def test_keypoints_of_a_block_are_its_corners(analytic):
    block = analytic.scene().objects[2]
    corners = {tuple(np.round(point, 6)) for point in keypoints(block).tolist()}
    half = np.array(analytic.BLOCK) / 2
    assert corners == {tuple(np.round(half * s, 6)) for s in np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, 8).T}


def test_keypoints_of_a_ball_lie_on_it_and_far_apart(analytic):
    points = keypoints(analytic.scene().objects[1])
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), analytic.BALL, rtol=1e-6)
    apart = np.linalg.norm(points[:, None] - points[None], axis=-1)[~np.eye(8, dtype=bool)]
    # Greedy farthest points are at least half as far apart as the best eight (Gonzalez 1985, doi:10.1016/0304-3975(85)
    # 90224-5), which for a sphere are 1.2156 radii apart (the square antiprism).
    assert apart.min() >= 1.2156 / 2 * analytic.BALL


def test_keypoints_of_a_vessel_lie_on_the_outside_of_its_glass(analytic):
    glass = analytic.scene().objects[0]
    for x, y, z in outside_vertices(glass):
        r = np.hypot(x, y)
        on_side = np.isclose(r, analytic.RADIUS, atol=1e-6)
        on_base = np.isclose(z, -analytic.HEIGHT / 2, atol=1e-6)
        on_rim = np.isclose(z, analytic.HEIGHT / 2, atol=1e-6) and r > (analytic.RADIUS + analytic.BORE) / 2 - 1e-6
        assert on_side or on_base or on_rim
    points = {tuple(point) for point in keypoints(glass)}
    assert points <= {tuple(point) for point in outside_vertices(glass)}


def test_keypoints_do_not_depend_on_the_order_of_vertices_and_faces(analytic, rng):
    ball = analytic.scene().objects[1]
    order = rng.permutation(len(ball.mesh.vertices))
    mixed = Mesh("ball", ball.mesh.vertices[order], np.argsort(order)[ball.mesh.faces][::-1])
    np.testing.assert_array_equal(keypoints(ball), keypoints(ball.model_copy(update={"mesh": mixed})))


def test_an_object_of_four_vertices_has_eight_keypoints_on_it(analytic):
    solid = trimesh.Trimesh(
        [[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    )
    prop = analytic.scene().objects[2].model_copy(update={"mesh": Mesh("tetra", solid.vertices, solid.faces)})
    points = keypoints(prop)
    assert len(np.unique(points, axis=0)) == 8
    heights = np.einsum("fpk,fk->pf", points[None] - solid.triangles[:, None, 0], solid.face_normals)
    np.testing.assert_allclose(heights.max(axis=1), 0.0, atol=1e-9)  # inside all faces' planes, and on one


def test_keypoints_in_the_world_are_those_of_the_object_moved_by_its_pose(analytic):
    scene = analytic.scene()
    points = scene_keypoints(scene)
    item = scene.objects[2]
    moved = np.c_[points.local[2], np.ones(8)] @ item.world_T_object.T
    np.testing.assert_allclose(points.world[2], moved[:, :3], atol=1e-12)


def test_a_keypoint_is_visible_behind_glass_occluded_or_outside():
    pixels = np.array([[3.0, 3.0]] * 4 + [[9.6, 3.0], [np.nan, np.nan]])
    distance = np.ones(6)
    first = np.array([1.0, np.inf, 0.6, 0.6, 1.0, 1.0])
    opaque = np.array([1.0, np.inf, 1.0 - 5e-5, 0.8, 1.0, 1.0])
    states = keypoint_states(pixels, distance, first, opaque, (10, 10))
    assert states == ["visible", "visible", "through_glass", "occluded", "outside", "outside"]
