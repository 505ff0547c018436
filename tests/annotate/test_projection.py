from __future__ import annotations

import numpy as np

from glassware.annotate.projection import (
    disparity,
    inside_picture,
    inverse_pose,
    pixel_rays,
    project,
    transformed,
    unproject,
)

#: Sums of a few products of numbers near 1 in float64.
ROUNDING = 1e-12


def test_a_point_on_the_optical_axis_falls_on_the_principal_point(analytic):
    camera = analytic.camera(0)
    on_axis = transformed(camera.world_T_camera, np.array([[0.0, 0.0, 0.7]]))
    pixels, Z = project(on_axis, camera.K, camera.world_T_camera)
    np.testing.assert_allclose(pixels[0], camera.centre, atol=1e-9)
    np.testing.assert_allclose(Z, 0.7, atol=ROUNDING)


def test_a_step_to_the_right_and_down_moves_the_pixel_by_similar_triangles(analytic):
    camera = analytic.camera(1)
    points = transformed(camera.world_T_camera, np.array([[0.1, 0.05, 0.5]]))
    pixels, _ = project(points, camera.K, camera.world_T_camera)
    expected = np.array(camera.centre) + camera.focal * np.array([0.1, 0.05]) / 0.5
    np.testing.assert_allclose(pixels[0], expected, atol=1e-9)


def test_focal_lengths_differ_along_x_and_y(analytic):
    camera = analytic.camera(1).model_copy(update={"focal_y": 210.0})
    points = transformed(camera.world_T_camera, np.array([[0.1, 0.05, 0.5]]))
    pixels, Z = project(points, camera.K, camera.world_T_camera)
    expected = np.array(camera.centre) + np.array([camera.focal, 210.0]) * np.array([0.1, 0.05]) / 0.5
    np.testing.assert_allclose(pixels[0], expected, atol=1e-9)
    right, _ = project(points, camera.K, camera.world_T_right)
    np.testing.assert_allclose(pixels[0] - right[0], [disparity(Z, camera.fx, camera.baseline)[0], 0.0], atol=1e-9)


def test_a_point_behind_the_camera_has_no_pixel(analytic):
    camera = analytic.camera(0)
    behind = transformed(camera.world_T_camera, np.array([[0.0, 0.0, -0.1], [0.0, 0.0, 0.0]]))
    pixels, Z = project(behind, camera.K, camera.world_T_camera)
    assert np.isnan(pixels[0]).all()
    assert Z[0] < 0


def test_unprojecting_depth_and_projecting_again_gives_every_pixel_its_own_centre(analytic, rng):
    camera = analytic.camera(2, width=8, height=6)
    Z = rng.uniform(0.2, 2.0, (6, 8))
    Z[3, 4] = np.inf
    points = unproject(Z, camera.K)
    assert np.isnan(points[3, 4]).all()
    world = transformed(camera.world_T_camera, points.reshape(-1, 3))
    pixels, depth = project(world, camera.K, camera.world_T_camera)
    rows, columns = np.mgrid[:6, :8]
    known = np.isfinite(Z).ravel()
    np.testing.assert_allclose(pixels[known], np.stack([columns, rows], -1).reshape(-1, 2)[known], atol=1e-9)
    np.testing.assert_allclose(depth[known], Z.ravel()[known], atol=ROUNDING)


def test_a_pixel_ray_has_unit_depth(analytic):
    camera = analytic.camera(0, width=5, height=3)
    rays = pixel_rays(3, 5, camera.K)
    np.testing.assert_array_equal(rays[..., 2], 1.0)
    np.testing.assert_allclose(rays[1, 2, :2], 0.0, atol=ROUNDING)


def test_an_inverse_pose_undoes_the_pose(analytic):
    pose = analytic.camera(1).world_T_camera
    np.testing.assert_allclose(inverse_pose(pose) @ pose, np.eye(4), atol=ROUNDING)


def test_disparity_is_the_difference_of_the_two_cameras_own_projections(analytic, rng):
    camera = analytic.camera(0)
    points = rng.uniform(-0.1, 0.1, (50, 3))
    left, Z = project(points, camera.K, camera.world_T_camera)
    right, _ = project(points, camera.K, camera.world_T_right)
    np.testing.assert_allclose(left[:, 0] - right[:, 0], disparity(Z, camera.focal, camera.baseline), atol=1e-9)
    np.testing.assert_allclose(left[:, 1], right[:, 1], atol=1e-9)


def test_nothing_has_no_disparity():
    assert disparity(np.array([np.inf]), 600.0, 0.065)[0] == 0.0


def test_a_picture_reaches_half_a_pixel_beyond_its_outermost_centres():
    pixels = np.array([[-0.5, -0.5], [-0.51, 0], [3.49, 2.49], [3.5, 0], [0, 2.5], [np.nan, np.nan]])
    assert inside_picture(pixels, 4, 3).tolist() == [True, False, True, False, False, False]
