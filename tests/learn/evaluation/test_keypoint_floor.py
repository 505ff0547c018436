"""Keypoints without a network: the same answer in every window."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from glassware.learn.evaluation.keypoint_floor import Windows, constant_keypoints

#: Focal length [px], baseline [m], and the middle of both windows [px].
F, B, C = 400.0, 0.1, (30.0, 20.0)
K = np.array([[F, 0.0, C[0]], [0.0, F, C[1]], [0.0, 0.0, 1.0]])


def windows(points: np.ndarray, orders: list[list[int]]) -> Windows:
    """Return the windows of objects with these keypoints, (B, K, 3) [m], by the pinhole model."""
    x, y, Z = np.moveaxis(points, -1, 0)
    shift = F * B / Z
    keypoints = np.stack([F * x / Z + C[0], F * y / Z + C[1], shift], axis=-1)
    targets = {
        "keypoints": torch.from_numpy(keypoints[:, orders]).float(),
        "points": torch.from_numpy(points[:, orders]).float(),
        "baseline": torch.full((len(points),), B),
    }
    return Windows(targets, torch.from_numpy(np.broadcast_to(K, (len(points), 2, 3, 3)).copy()).float())


def test_equal_windows_are_answered_without_error():
    point = [[0.01, -0.03, 0.5], [0.01, 0.03, 0.52]]
    found = constant_keypoints([windows(np.array([point, point]), [[0, 1]])])
    assert found["objects"] == 2
    assert found["mae"] == pytest.approx(0.0, abs=1e-7)
    assert found["near"] == 1.0


def test_distances_are_those_of_the_medians_in_the_windows():
    depths = (0.4, 0.5, 0.8)
    points = np.array([[[0.0, 0.0, depth], [0.02, 0.0, depth]] for depth in depths])
    found = constant_keypoints([windows(points[:1], [[0, 1]]), windows(points[1:], [[0, 1]])])
    # The median shift is that of 0.5 m, the median column of the second keypoint that of 0.02 m there.
    ray = np.array([0.02, 0.0, 0.5])  # to the second keypoint's column, for other depths of the true one
    distances = [abs(depth - 0.5) for depth in depths]
    distances += [float(np.linalg.norm(ray - [0.02, 0.0, depth])) for depth in depths]
    assert found["mae"] == pytest.approx(np.mean(distances), abs=1e-6)
    assert found["near"] == pytest.approx(2 / 6)


def test_orders_that_look_the_same_count_by_the_better_one():
    one = np.array([[0.0, -0.05, 0.5], [0.0, 0.05, 0.5]])
    upright, turned = windows(one[None], [[0, 1], [1, 0]]), windows(one[None, ::-1].copy(), [[0, 1], [1, 0]])
    found = constant_keypoints([upright, upright, turned])
    assert found["mae"] == pytest.approx(0.0, abs=1e-7)
