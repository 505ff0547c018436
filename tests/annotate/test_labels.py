from __future__ import annotations

import numpy as np
import pytest

from glassware.annotate.keypoints import scene_keypoints
from glassware.annotate.labels import Labels, annotate
from glassware.annotate.masks import decode_mask


@pytest.fixture(scope="module")
def views(analytic):
    scene = analytic.scene()
    points = scene_keypoints(scene)
    found = []
    for camera in scene.cameras:
        geometry = analytic.geometry(scene, camera)
        sight = analytic.sight(scene, camera, points.world.reshape(-1, 3))
        found.append((scene, camera, geometry, annotate(scene, camera, geometry, points, sight)))
    return found


def test_masks_are_the_silhouettes(views):
    for _, _, geometry, labels in views:
        for index, label in enumerate(labels.objects):
            np.testing.assert_array_equal(
                decode_mask(label.mask_amodal.counts, label.mask_amodal.size), geometry.crossed[index]
            )
            np.testing.assert_array_equal(
                decode_mask(label.mask_seen.counts, label.mask_seen.size), geometry.reached[index]
            )


def test_the_centre_of_the_ball_is_where_the_camera_sees_it(views):
    for _, camera, _, labels in views:
        ball = labels.objects[1]
        # The mean of a 3D box's corners is its centre, along another path than the pose.
        np.testing.assert_allclose(np.mean(ball.box3d, axis=0), ball.centroid.point, atol=1e-12)
        x, y, z = ball.centroid.point
        u, v = camera.centre[0] + camera.focal * x / z, camera.centre[1] + camera.focal * y / z
        np.testing.assert_allclose(ball.centroid.pixel, (u, v), atol=1e-9)


def test_the_depth_of_a_visible_keypoint_is_that_of_the_surface_there(views):
    compared = 0
    for _, _, geometry, labels in views:
        for label in labels.objects:
            for point in label.keypoints:
                column, row = np.round(point.pixel).astype(int)
                patch = slice(row - 1, row + 2), slice(column - 1, column + 2)
                if point.state == "visible" and (geometry.id[patch] == label.id).all():
                    near, far = geometry.Z[patch].min(), geometry.Z[patch].max()
                    # A corner between pixel centres stands out of them by no more than they differ.
                    assert 2 * near - far - 1e-4 <= point.Z <= 2 * far - near + 1e-4
                    compared += 1
    assert compared > 10


def test_every_state_of_keypoints_occurs_in_these_views(views):
    states = {point.state for *_, labels in views for label in labels.objects for point in label.keypoints}
    assert states >= {"visible", "through_glass", "occluded"}


def test_labels_come_back_from_json_exactly(views):
    for *_, labels in views:
        text = labels.model_dump_json()
        assert Labels.model_validate_json(text).model_dump_json() == text


def test_an_object_behind_the_camera_has_no_pixels_and_no_fractions(analytic):
    scene = analytic.scene()
    camera = scene.cameras[0]
    turned = camera.world_T_camera @ np.diag([-1.0, 1.0, -1.0, 1.0])
    camera = camera.model_copy(update={"world_T_camera": turned})
    points = scene_keypoints(scene)
    sight = analytic.sight(scene, camera, points.world.reshape(-1, 3))
    labels = annotate(scene, camera, analytic.geometry(scene, camera), points, sight)
    for label in labels.objects:
        assert label.pixels.silhouette == 0
        assert label.fractions is None
        assert label.box2d.modal is label.box2d.amodal is label.box2d.amodal_clipped is label.centroid.pixel is None
        assert {point.state for point in label.keypoints} == {"outside"}


def test_a_line_of_sight_of_another_length_is_refused(analytic):
    scene = analytic.scene()
    points = scene_keypoints(scene)
    sight = analytic.Sight(np.zeros(3), np.zeros(3))
    with pytest.raises(ValueError, match="line of sight"):
        annotate(scene, scene.cameras[0], analytic.geometry(scene, scene.cameras[0]), points, sight)
