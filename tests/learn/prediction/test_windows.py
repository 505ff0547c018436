"""Windows at the focal length of training, and what was found in several of them."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.learn.data.scaling import fitted, fitted_K
from glassware.learn.data.views import CameraView
from glassware.learn.data.windows import Window, cut
from glassware.learn.prediction.windows import Found, merged, windows

SIZE = (72, 128)
K = np.array([[70.0, 0.0, 63.5], [0.0, 70.0, 35.5], [0.0, 0.0, 1.0]])


def found(
    size: tuple[int, int], depth: float, *objects: tuple[float, tuple[float, float, float], tuple[int, int]]
) -> Found:
    """Objects as score, centre [m] and peak (x, y) [px], each with a mask of 5 x 5 px."""
    pose, mask = np.tile(np.eye(4), (len(objects), 1, 1)), np.zeros((len(objects), *size), bool)
    for row, (_, centre, (x, y)) in enumerate(objects):
        pose[row, :3, 3] = centre
        mask[row, max(y - 2, 0) : y + 3, max(x - 2, 0) : x + 3] = True
    return Found(
        depth=np.full(size, depth, np.float32),
        score=np.array([score for score, _, _ in objects]),
        transparent=np.ones(len(objects), bool),
        camera_T_object=pose,
        size=np.full((len(objects), 3), 0.1),
        mask=mask,
        peak=np.array([peak for _, _, peak in objects], float).reshape(-1, 2),
    )


def test_a_picture_at_about_the_focal_length_of_training_is_taken_whole():
    for network, focal in (((36, 64), 35.0), ((36, 64), 43.0), (None, 300.0), ((36, 64), None)):
        (window,) = windows(SIZE, K, network, focal, "letterbox")
        assert (window.rows, window.columns) == (slice(0, 72), slice(0, 128))


def test_windows_of_a_wide_lens_have_the_focal_length_of_training_and_cover_the_picture():
    network, focal = (64, 96), 140.0
    parts = windows(SIZE, K, network, focal, "letterbox")
    covered = np.zeros(SIZE, int)
    view = CameraView(np.zeros((*SIZE, 3), np.uint8), np.eye(4), K)
    for window in parts:
        covered[window.rows, window.columns] += 1
        part = cut(view, window)
        size = part.picture.shape[:2]
        assert fitted_K(part.K, fitted(size, network))[0, 0] == pytest.approx(focal, rel=0.03)  # whole pixels
    assert covered.min() >= 1
    # What one window's border cuts is whole in another: neighbours overlap by half.
    lefts = sorted({window.columns.start for window in parts})
    width = parts[0].columns.stop - parts[0].columns.start
    assert max(np.diff(lefts)) <= width / 2 + 1


@pytest.mark.parametrize("focal", [300.0, 700.0, 5000.0])
def test_windows_of_a_far_wider_lens_are_larger_but_cover_the_picture(focal):
    parts = windows(SIZE, K, (64, 96), focal, "letterbox")
    covered = np.zeros(SIZE, int)
    for window in parts:
        covered[window.rows, window.columns] += 1
    assert covered.min() >= 1
    assert len({window.columns.start for window in parts}) == 6
    lefts = sorted({window.columns.start for window in parts})
    assert max(np.diff(lefts)) <= (parts[0].columns.stop - parts[0].columns.start) / 2 + 1


def test_an_object_found_in_two_windows_is_one_and_the_one_that_is_cut_gives_way():
    left, right = Window(slice(0, 72), slice(0, 80)), Window(slice(0, 72), slice(48, 128))
    at_border = found((72, 80), 0.8, (0.7, (0.1, 0.0, 0.8), (78, 36)), (0.6, (-0.3, 0.0, 0.8), (20, 36)))
    in_middle = found((72, 80), 0.8, (0.65, (0.11, 0.0, 0.81), (32, 36)))
    both = merged(SIZE, [(left, at_border), (right, in_middle)])
    assert both.score.tolist() == [0.65, 0.6]
    assert both.peak.tolist() == [[80.0, 36.0], [20.0, 36.0]]
    assert both.mask[0, 36, 80]
    assert both.mask[1, 36, 20]
    assert both.mask.sum() == 50


def test_depth_of_windows_is_a_mean_that_has_no_step_at_their_borders():
    left, right = Window(slice(0, 72), slice(0, 80)), Window(slice(0, 72), slice(48, 128))
    depth = merged(SIZE, [(left, found((72, 80), 1.0)), (right, found((72, 80), 2.0))]).depth
    assert (depth[36, 0], depth[36, 127]) == (1.0, 2.0)
    steps = np.diff(depth[36])
    assert (steps >= -1e-6).all()
    assert steps.max() < 0.1
