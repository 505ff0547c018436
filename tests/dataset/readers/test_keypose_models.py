"""Poses of KeyPose's models from their keypoints, where these and the symmetry leave no turn open."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from glassware.annotate.symmetries import ASYMMETRIC, BALL, REVOLUTION
from glassware.core.errors import InputError
from glassware.dataset.readers.keypose_models import KeyposeModel, aligned, read_model, symmetry_of_category

SIZE = np.array([0.07, 0.09, 0.08])
MUG = np.array([[0.0, -0.011, 0.042], [0.0, -0.011, -0.040], [-0.002, 0.047, 0.030]])
AXIS = np.array([[0.0, 0.0, 0.04], [0.0, 0.0, -0.04]])


def posed(points: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a pose, and where it brings points."""
    rng = np.random.Generator(np.random.PCG64(seed))
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=seed).as_matrix()
    pose[:3, 3] = rng.uniform(-1.0, 1.0, 3)
    return pose, points @ pose[:3, :3].T + pose[:3, 3]


@pytest.mark.parametrize("seed", range(5))
def test_three_keypoints_give_the_whole_pose(seed):
    pose, seen = posed(MUG, seed)
    assert aligned(KeyposeModel(SIZE, MUG), seen, ASYMMETRIC, "here") == pytest.approx(pose, abs=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_two_keypoints_on_an_axis_of_revolution_give_its_direction(seed):
    pose, seen = posed(AXIS, seed)
    found = aligned(KeyposeModel(SIZE, AXIS), seen, REVOLUTION, "here")
    assert found is not None
    assert found[:3, 2:] == pytest.approx(pose[:3, 2:], abs=1e-9)
    assert found[:3, :3] @ found[:3, :3].T == pytest.approx(np.eye(3), abs=1e-9)


def test_an_axis_that_is_upside_down_is_half_a_turn():
    found = aligned(KeyposeModel(SIZE, AXIS), -AXIS, REVOLUTION, "here")
    assert found is not None
    assert found[:3, 2] == pytest.approx([0.0, 0.0, -1.0])
    assert np.linalg.det(found[:3, :3]) == pytest.approx(1.0)


def test_a_turn_that_nothing_says_leaves_the_pose_unknown():
    assert aligned(KeyposeModel(SIZE, AXIS), AXIS, symmetry_of_category("tree"), "here") is None
    assert aligned(KeyposeModel(SIZE, AXIS[:1]), AXIS[:1], REVOLUTION, "here") is None
    assert aligned(KeyposeModel(SIZE, np.zeros((1, 3))), AXIS[:1], BALL, "here") is not None


def test_keypoints_of_another_object_are_refused():
    with pytest.raises(InputError, match=r"expected keypoints within 10 mm of the model's, found 20\.0 mm"):
        aligned(KeyposeModel(SIZE, AXIS), 1.5 * AXIS, REVOLUTION, "here")


@pytest.mark.parametrize("line", ["v 0.01 0.02", "v", "v 0.01 0.02 x"])
def test_half_a_model_is_named_with_its_line(tmp_path, line):
    path = tmp_path / "bottle_0.obj"
    path.write_text("o mesh\nv 0 0 0\nv 0.1 0.1 0.1\n" + line)
    with pytest.raises(InputError, match=r"bottle_0\.obj, line 4: expected three numbers"):
        read_model(path)
