from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from glassware.annotate.projection import project_camera
from glassware.learn.decoding.boxes import boxes_from_fields, nearest_rotation, rotation_from_covariance
from glassware.learn.metrics.box_iou import box_iou
from glassware.learn.targets.fields import box_covariance

#: Eigenvectors of float64 matrices whose eigenvalues differ by some per cent.
RADIANS = 1e-6


def covariances(rotations: np.ndarray, sizes: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(rotations * (sizes[:, None] ** 2 / 12)) @ torch.from_numpy(rotations).mT


def angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return Rotation.from_matrix(np.swapaxes(a, 1, 2) @ b).magnitude()


@pytest.mark.parametrize("error", [0.0, 0.2, 0.5])
def test_axes_of_a_box_with_three_sizes_are_found_whatever_the_guess(rng, error):
    """Signs and order come from a guess that is half a radian off; the rotation itself does not."""
    true = Rotation.random(200, random_state=rng).as_matrix()
    sizes = np.stack([rng.permutation([0.06, 0.09, 0.14]) for _ in true])
    axis = rng.standard_normal((200, 3))
    off = Rotation.from_rotvec(error * axis / np.linalg.norm(axis, axis=1, keepdims=True)).as_matrix()
    found = rotation_from_covariance(covariances(true, sizes), torch.from_numpy(true @ off)).numpy()
    assert angle(found, true).max() < RADIANS


def test_the_guess_turns_what_is_as_wide_as_deep(rng):
    true = Rotation.random(200, random_state=rng).as_matrix()
    sizes = np.tile([0.08, 0.08, 0.15], (200, 1))
    turn = Rotation.from_rotvec(np.outer(rng.uniform(-0.4, 0.4, 200), [0, 0, 1])).as_matrix()
    tilt = Rotation.from_rotvec(np.outer(rng.uniform(-0.4, 0.4, 200), [1, 0, 0])).as_matrix()
    # The turn in the plane of equal sizes is kept, the tilt out of it is mended.
    found = rotation_from_covariance(covariances(true, sizes), torch.from_numpy(true @ turn)).numpy()
    assert angle(found, true @ turn).max() < RADIANS
    found = rotation_from_covariance(covariances(true, sizes), torch.from_numpy(true @ tilt)).numpy()
    assert angle(found, true).max() < RADIANS


def test_a_cube_has_the_rotation_of_the_guess(rng):
    true, guess = (Rotation.random(50, random_state=rng).as_matrix() for _ in range(2))
    found = rotation_from_covariance(covariances(true, np.full((50, 3), 0.1)), torch.from_numpy(guess)).numpy()
    assert angle(found, guess).max() < RADIANS


def test_what_is_found_is_a_rotation(rng):
    guess = torch.from_numpy(Rotation.random(100, random_state=rng).as_matrix())
    noise = torch.from_numpy(rng.standard_normal((100, 3, 3)))
    found = rotation_from_covariance(noise @ noise.mT, guess)
    torch.testing.assert_close(found.mT @ found, torch.eye(3, dtype=torch.float64).expand(100, 3, 3))
    torch.testing.assert_close(torch.linalg.det(found), torch.ones(100, dtype=torch.float64))


def test_the_nearest_rotation_is_scipys(rng):
    matrices = rng.standard_normal((50, 3, 3))
    found = nearest_rotation(torch.from_numpy(matrices)).numpy()
    for ours, matrix in zip(found, matrices, strict=True):
        expected, _ = Rotation.align_vectors(matrix.T, np.eye(3))
        np.testing.assert_allclose(ours, expected.as_matrix(), atol=1e-9)


def test_noise_in_the_fields_leaves_boxes_that_overlap_the_true_ones(box_scene, rng):
    """2 px on corners, 1 cm on depth, 20 % on the covariance: what a network trained for minutes has (160 x 128 px).

    With sizes from the corners, as in the released code, nearly half of these boxes have an IoU below 0.25.
    """
    views = [(box_scene.camera(rng, 128, 160), box_scene.boxes(rng, 5)) for _ in range(60)]
    items = [(item, K) for (pose, K), scene in views for item in box_scene.view(pose, K, scene, 128, 160)[2]]
    corners = np.stack([project_camera(item.corners, K)[0] for item, K in items])
    depth = np.array([item.camera_T_object[2, 3] for item, _ in items])
    covariance = np.stack([box_covariance(item.camera_T_object, item.size) for item, _ in items])
    factors = 1.0 + 0.2 * rng.standard_normal(covariance.shape)
    noisy = (
        corners + 2.0 * rng.standard_normal(corners.shape),
        depth + 0.01 * rng.standard_normal(len(depth)),
        covariance * 0.5 * (factors + factors.swapaxes(1, 2)),
        np.stack([K for _, K in items]),
    )
    vertices, z, spread, K = (torch.from_numpy(values) for values in noisy)

    def found(rotation: Literal["covariance", "vertices"]) -> float:
        boxes = zip(
            *(values.numpy() for values in boxes_from_fields(vertices, z, spread, K, rotation)), items, strict=True
        )
        return float(
            np.mean([box_iou(pose, size, item.camera_T_object, item.size) > 0.25 for pose, size, (item, _) in boxes])
        )

    assert found("covariance") > 0.9
    assert found("vertices") < 0.7
