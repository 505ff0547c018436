"""Mirror images and windows: cameras, objects and labels show the same world, by exact pictures of boxes."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.annotate.projection import inverse_pose, pixel_rays, project_camera
from glassware.learn.data.geometric_augment import (
    mirrored_labels,
    mirrored_view,
    moved_pixels,
)
from glassware.learn.data.ground_truth import GroundTruth
from glassware.learn.data.settings import AugmentSettings
from glassware.learn.data.views import CameraView
from glassware.learn.data.windows import Window, cut, cut_labels
from glassware.learn.targets.objects import canonical_pose

HEIGHT, WIDTH = 96, 128
STILL = {"flip": 0.0, "zoom": (1.0, 1.0)}


@pytest.fixture
def stereo(box_scene, rng):
    """Two views of boxes, the pictures of which are their ids; the labels are those of the first one."""
    pose, K = box_scene.camera(rng, HEIGHT, WIDTH)
    right = pose.copy()
    right[:3, 3] += 0.05 * pose[:3, 0]
    scene = box_scene.boxes(rng, 5)
    seen = [box_scene.view(world_T_camera, K, scene, HEIGHT, WIDTH) for world_T_camera in (pose, right)]
    views = [
        CameraView(np.repeat(ids[..., None], 3, axis=2).astype(np.uint8), world_T_camera, K)
        for (ids, _, _), world_T_camera in zip(seen, (pose, right), strict=True)
    ]
    ids, Z, objects = seen[0]
    return views, GroundTruth(ids, Z, tuple(objects), {item.id: item.size * [[0.5, 0.5, 0.5]] for item in objects})


def assert_consistent(views: list[CameraView], labels: GroundTruth) -> None:
    """The first view's points of objects lie in their boxes, and the second camera shows them where they are."""
    first, second = views
    height, width = labels.Z.shape
    rays = pixel_rays(height, width, first.K)
    relative = inverse_pose(second.world_T_camera) @ first.world_T_camera
    assert np.linalg.det(relative[:3, :3]) == pytest.approx(1.0)
    checked = 0
    for item in labels.objects:
        seen = labels.instances == item.id
        points = rays[seen] * labels.Z[seen].astype(np.float64)[:, None]
        local = (points - item.camera_T_object[:3, 3]) @ item.camera_T_object[:3, :3]
        # Boxes that count as bodies of revolution are turned about their axis.
        reach = item.size / 2 * ([np.sqrt(2), np.sqrt(2), 1] if item.symmetry.turns else [1, 1, 1])
        assert (np.abs(local) <= reach + 1e-5).all()
        assert np.linalg.det(item.camera_T_object[:3, :3]) == pytest.approx(1.0)
        np.testing.assert_allclose(canonical_pose(item.camera_T_object, item.symmetry), item.camera_T_object, atol=1e-9)
        assert item.visible == seen.sum()
        pixels, _ = project_camera(points @ relative[:3, :3].T + relative[:3, 3], second.K)
        cells = np.rint(pixels).astype(int)
        inside = ((cells >= 0) & (cells < [second.picture.shape[1], second.picture.shape[0]])).all(1)
        shown = second.picture[cells[inside, 1], cells[inside, 0], 0]
        if len(shown) > 50:
            assert (shown == item.id).mean() > 0.8  # others are hidden there, or lie on an outline
            checked += 1
    assert checked


def test_the_scene_as_it_is_is_consistent(stereo):
    assert_consistent(*stereo)


def test_a_mirror_image_is_a_view_of_the_mirrored_world(stereo):
    views, labels = stereo
    mirrored = [mirrored_view(view) for view in views], mirrored_labels(labels)
    assert_consistent(*mirrored)
    np.testing.assert_array_equal(mirrored[0][0].picture, views[0].picture[:, ::-1])
    again = mirrored_view(mirrored[0][1])
    np.testing.assert_array_equal(again.K, views[1].K)
    np.testing.assert_array_equal(again.world_T_camera, views[1].world_T_camera)


def test_a_window_moves_the_principal_point_and_nothing_else(stereo):
    views, labels = stereo
    window = Window(slice(12, 84), slice(20, 116))
    moved = [cut(view, window) for view in views], cut_labels(labels, window)
    assert_consistent(*moved)
    assert moved[0][0].K[0, 2] == views[0].K[0, 2] - 20
    assert moved[0][0].picture.shape == (72, 96, 3)


def test_all_views_of_a_sample_are_moved_alike_and_half_of_the_samples_are_mirrored(stereo, rng):
    views, labels = stereo
    settings = AugmentSettings(flip=0.5, zoom=(1.0, 1.5))
    flips, widths = 0, []
    for _ in range(100):
        found, truth = moved_pixels(views, labels, settings, rng)
        np.testing.assert_array_equal(found[0].K, found[1].K)
        assert found[0].picture.shape == found[1].picture.shape == (*truth.Z.shape, 3)
        flips += found[0].world_T_camera[0, 3] == -views[0].world_T_camera[0, 3]
        widths.append(truth.Z.shape[1])
        assert truth.Z.shape[0] / truth.Z.shape[1] == pytest.approx(HEIGHT / WIDTH, abs=0.01)
    assert 30 < flips < 70
    assert WIDTH / 1.5 - 1 <= min(widths) < 0.75 * WIDTH
    assert max(widths) > 0.95 * WIDTH


def test_without_flip_and_zoom_nothing_moves(stereo, rng):
    views, labels = stereo
    found, truth = moved_pixels(views, labels, AugmentSettings(**STILL), rng)
    for before, after in zip(views, found, strict=True):
        np.testing.assert_array_equal(after.picture, before.picture)
        np.testing.assert_array_equal(after.K, before.K)
    np.testing.assert_array_equal(truth.Z, labels.Z)
