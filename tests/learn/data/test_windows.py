"""Windows of pictures: their cameras and labels, and those that show the same in both eyes."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.annotate.projection import project_camera
from glassware.core.errors import InputError
from glassware.dataset.reader import Dataset
from glassware.learn.data.samples import SampleDataset
from glassware.learn.data.settings import AugmentSettings, ViewSettings
from glassware.learn.data.views import CameraView
from glassware.learn.data.windows import Window, cut, shared_windows, window_of_source
from glassware.learn.targets.encoding import CORRECTED

SIZE = (72, 128)
K = np.array([[70.0, 0.0, 63.5], [0.0, 70.0, 35.5], [0.0, 0.0, 1.0]])


def test_a_window_sees_points_where_the_picture_has_them():
    window = Window(slice(10, 60), slice(30, 110))
    point = np.array([[0.1, -0.05, 0.8]])
    whole, _ = project_camera(point, K)
    part, _ = project_camera(point, cut(CameraView(np.zeros((*SIZE, 3), np.uint8), np.eye(4), K), window).K)
    np.testing.assert_allclose(part + np.array([30, 10]), whole)


def eye(x: float, K: np.ndarray = K, turn: float = 0.0) -> CameraView:
    pose = np.eye(4)
    pose[:3, :3] = [[np.cos(turn), 0.0, np.sin(turn)], [0.0, 1.0, 0.0], [-np.sin(turn), 0.0, np.cos(turn)]]
    pose[0, 3] = x
    return CameraView(np.zeros((*SIZE, 3), np.uint8), pose, K)


@pytest.mark.parametrize("right", [eye(0.12), eye(0.12, K + np.outer([0, 1, 0], [0, 0, 4.0])), eye(0.1, turn=0.1)])
def test_windows_of_both_eyes_have_the_same_middle_at_the_middle_depth(right):
    """For parallel eyes, for another principal point, and for eyes that turn towards each other."""
    window, left = Window(slice(20, 50), slice(50, 90)), eye(0.0)
    part = window_of_source(left, window, right, 0.6)
    assert (part.rows.stop - part.rows.start, part.columns.stop - part.columns.start) == (30, 40)
    ray = np.linalg.solve(K, [69.5, 34.5, 1.0])
    in_right = np.linalg.solve(right.world_T_camera, [*(0.6 * ray), 1.0])[None, :3]
    (seen,), _ = project_camera(in_right, cut(right, part).K)
    np.testing.assert_allclose(seen, [19.5, 14.5], atol=0.51)  # whole pixels


def test_windows_stay_within_the_picture():
    window = Window(slice(0, 72), slice(0, 60))
    assert window_of_source(eye(0.0), window, eye(0.12), 0.6) == window  # a disparity of 14 px would lead beyond
    whole = Window(slice(0, 72), slice(0, 128))
    assert window_of_source(eye(0.0), whole, eye(0.12), 0.6) == whole
    behind = eye(0.0, turn=np.pi)
    assert window_of_source(eye(0.0), window, behind, 0.6) == window


@pytest.mark.parametrize("depth", [0.35, 0.6, 2.0])
def test_what_both_eyes_see_has_one_size_and_no_disparity_at_its_depth(depth):
    first, second = shared_windows(SIZE, 70.0 * 0.12 / depth)
    assert first.size == second.size
    assert (first.columns.stop, second.columns.start) == (SIZE[1], 0)
    (left, right), point = (eye(0.0), eye(0.12)), np.array([[0.02, -0.05, depth]])
    (in_left,), _ = project_camera(point, cut(left, first).K)
    (in_right,), _ = project_camera(point - right.world_T_camera[:3, 3], cut(right, second).K)
    np.testing.assert_allclose(in_left, in_right, atol=0.51)  # whole pixels


def converged(root, depth, **options) -> SampleDataset:
    return SampleDataset(root, "all", ViewSettings(rule="stereo", convergence=depth), CORRECTED, **options)


def test_samples_are_what_both_eyes_see(rendered):
    stored = Dataset.open(rendered).scene(0).views[0]
    camera = stored.camera()
    # Of 128 columns 32 are left away, and sides are multiples of 32 px.
    data = converged(rendered, camera.K[0][0] * camera.baseline / 32.0, ground_truth=True)
    sample, labels = data[(0, 0)], data.labels(0)
    assert sample.images.shape == (2, 3, 96, 96)
    left, right = (sample.images[eye].movedim(0, -1).numpy() * 255 for eye in (0, 1))
    np.testing.assert_array_equal(left, stored.picture("left")[:, 32:])
    np.testing.assert_array_equal(right, stored.picture("right")[:, :96])
    moved = np.subtract(camera.K, [[0.0, 0.0, 32.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(sample.K, [moved, camera.K], rtol=1e-6)
    np.testing.assert_allclose(data.fitted_camera(0)[0], moved)
    truth = sample.ground_truth
    assert truth is not None
    for found in (truth, labels):
        np.testing.assert_array_equal(found.Z, stored.geometry().Z[:, 32:])
        assert {one.id: one.visible for one in found.objects} == {
            one.id: int((stored.geometry().id[:, 32:] == one.id).sum()) for one in found.objects
        }


def test_augmented_samples_keep_both_eyes_converged(rendered):
    camera = Dataset.open(rendered).scene(0).views[0].camera()
    depth = camera.K[0][0] * camera.baseline / 32.0
    data = converged(rendered, depth, augment=AugmentSettings())
    for draw in range(8):
        sample = data[(0, draw)]
        K, (left, right) = sample.K.numpy(), sample.world_T_camera.double().numpy()
        # The disparity at that depth is zero, whatever was enlarged or mirrored: the baseline changes sign there.
        baseline = (np.linalg.inv(left) @ right)[0, 3]
        disparity = K[0, 0, 0] * baseline / depth - (K[1, 0, 2] - K[0, 0, 2])
        assert abs(disparity) < 1e-3  # px, of float32 poses and K


def test_a_depth_that_leaves_nothing_is_told(rendered):
    with pytest.raises(InputError, match=r"views.convergence: expected a depth at which both eyes see the same"):
        converged(rendered, 0.01)[(0, 0)]
    with pytest.raises(InputError, match=r"views.convergence: expected the rule stereo"):
        SampleDataset(rendered, "all", ViewSettings(convergence=0.5), CORRECTED)
