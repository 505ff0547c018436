"""Object coordinates are where points are in the box of their object."""

from __future__ import annotations

import numpy as np

from glassware.annotate.coordinates import back_wall, box_diagonal, object_coordinates
from glassware.annotate.keypoints import scene_keypoints
from glassware.annotate.labels import annotate
from glassware.render.frame import Layers


def _labelled(analytic):
    scene = analytic.scene(views=1)
    camera, points = scene.cameras[0], scene_keypoints(scene)
    geometry = analytic.geometry(scene, camera)
    sight = analytic.sight(scene, camera, points.world.reshape(-1, 3))
    return camera, geometry, annotate(scene, camera, geometry, points, sight)


def test_points_of_a_box_are_on_its_sides_and_of_a_ball_on_the_ball(analytic):
    camera, geometry, labels = _labelled(analytic)
    found = object_coordinates(geometry.Z, geometry.id, labels.objects, camera.K)
    ball, block = labels.objects[1], labels.objects[2]
    on_ball = (found[geometry.id == 3] - 0.5) * box_diagonal(ball)
    np.testing.assert_allclose(np.linalg.norm(on_ball, axis=1), analytic.BALL, atol=1e-6)
    sides = np.abs(found[geometry.id == 4] - 0.5) * box_diagonal(block) - np.array(analytic.BLOCK) / 2
    np.testing.assert_allclose(sides.max(axis=1), 0.0, atol=1e-6)
    assert np.isnan(found[geometry.id < 2]).all()
    assert ((found >= 0) & (found <= 1))[geometry.id > 1].all()


def test_the_back_wall_is_the_last_surface_of_the_first_surfaces_object():
    Z = np.array([[[1.0, 1.0, 1.0, np.inf]], [[2.0, 2.0, np.inf, np.inf]], [[3.0, 3.0, np.inf, np.inf]]], np.float32)
    ids = np.array([[[2, 2, 1, 0]], [[3, 2, 0, 0]], [[2, 3, 0, 0]]], np.uint16)
    zeros = np.zeros(ids.shape, np.uint8)
    layers = Layers(Z, np.zeros((*ids.shape, 3), np.float16), ids, zeros, ids, zeros > 0, np.ones(ids[0].shape))
    np.testing.assert_array_equal(back_wall(layers, ids[0]), [[3.0, 2.0, np.inf, np.inf]])
