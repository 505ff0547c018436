from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from glassware.annotate.symmetries import ASYMMETRIC, BALL, REVOLUTION, Symmetry, motions_of
from glassware.learn.metrics.pose import area_under_curve, fraction_near, pose_errors, rotation_angle
from glassware.procedural.props.blocks import extrusion


def drawn(rng) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-0.1, 0.1, 3)
    return pose


def test_errors_agree_with_scipys_rotations_and_neighbours(rng):
    points = rng.uniform(-0.1, 0.1, (30, 3))
    for _ in range(20):
        found, true = drawn(rng), drawn(rng)
        errors = pose_errors(found, true, points, ASYMMETRIC)
        between = Rotation.from_matrix(found[:3, :3]).inv() * Rotation.from_matrix(true[:3, :3])
        assert errors.rotation == pytest.approx(between.magnitude())
        moved = [points @ pose[:3, :3].T + pose[:3, 3] for pose in (found, true)]
        assert errors.add == pytest.approx(np.linalg.norm(moved[0] - moved[1], axis=1).mean())
        assert errors.add_s == pytest.approx(cKDTree(moved[0]).query(moved[1])[0].mean())
        assert errors.translation == pytest.approx(np.linalg.norm(found[:3, 3] - true[:3, 3]))


def test_dense_points_give_the_distance_to_the_surface_and_keypoints_alone_about_twice_that(rng):
    """A ball of radius r that is shifted by d: a point of it is | |p - shift| - r | away from the other ball."""
    r, d = 0.05, 0.02
    mean = 0.5 * quad(lambda cosine: abs(np.sqrt(r * r + d * d - 2 * r * d * cosine) - r), -1.0, 1.0)[0]
    directions = rng.standard_normal((4008, 3))
    points = r * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    found, true = drawn(rng), np.eye(4)
    true[:3, :3], true[:3, 3] = found[:3, :3], found[:3, 3] + [d, 0.0, 0.0]
    dense = pose_errors(found, true, points[:8], ASYMMETRIC, points[8:])
    assert dense.add == pytest.approx(d)
    assert dense.add_s == pytest.approx(mean, rel=0.03)  # 2.8 mm between neighbours, of which little is left
    assert len(dense.points) == 8
    assert pose_errors(found, true, points[:8], ASYMMETRIC).add_s > 1.5 * mean


def test_small_angles_are_exact():
    for angle in (1e-9, 1e-5, 1.0, np.pi):
        assert rotation_angle(Rotation.from_euler("y", angle).as_matrix(), np.eye(3)) == pytest.approx(angle, rel=1e-6)


def test_the_turn_of_an_object_of_revolution_does_not_count(rng):
    points = rng.uniform(-0.1, 0.1, (10, 3))
    for _ in range(20):
        true, tilt = drawn(rng), rng.uniform(0, 0.5)
        turned = true.copy()
        turned[:3, :3] = true[:3, :3] @ Rotation.from_euler("xz", [tilt, rng.uniform(0, 6)]).as_matrix()
        errors = pose_errors(turned, true, points, REVOLUTION)
        # What is left is the angle between the axes.
        assert errors.rotation == pytest.approx(tilt, abs=1e-7)
        assert pose_errors(true @ turn(rng), true, points, REVOLUTION).add == pytest.approx(0.0, abs=1e-9)


def test_poses_that_look_the_same_have_no_error(rng):
    """A hexagonal prism under its twelve motions, a can upside down, a ball anyhow."""
    turns = 2 * np.pi * np.arange(6) / 6
    prism = extrusion("prism", np.stack([np.cos(turns), np.sin(turns)], axis=1), 0.6)[0]
    points = prism.vertices[:4].astype(np.float64)
    kind = Symmetry(False, False, motions_of(prism))
    for motion in kind.motions:
        true = drawn(rng)
        errors = pose_errors(true @ motion, true, points, kind)
        assert (errors.add, errors.rotation) == pytest.approx((0.0, 0.0), abs=1e-6)
        if not np.array_equal(motion, np.eye(4)):
            assert pose_errors(true @ motion, true, points, ASYMMETRIC).add > 0.1
    flip = np.diag([1.0, -1.0, -1.0, 1.0])
    can = Symmetry(True, False, np.stack([np.eye(4), flip]))
    true = drawn(rng)
    assert pose_errors(true @ flip @ turn(rng), true, points, can).add == pytest.approx(0.0, abs=1e-6)
    assert pose_errors(true @ flip @ turn(rng), true, points, REVOLUTION).add > 0.1
    other = drawn(rng)
    other[:3, 3] = true[:3, 3] + [0.0, 0.03, 0.04]
    errors = pose_errors(other, true, points, BALL)
    assert (errors.add, errors.translation, errors.rotation) == pytest.approx((0.05, 0.05, 0.0), abs=1e-9)


def turn(rng) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("z", rng.uniform(0, 6)).as_matrix()
    return pose


def test_the_area_is_that_under_the_curve_of_accuracy(rng):
    distances, missed = rng.exponential(0.05, 40).tolist(), 3
    steps = sorted(d for d in distances if d < 0.1)
    area, _ = quad(lambda t: sum(d < t for d in distances) / (40 + missed), 0.0, 0.1, points=steps, limit=200)
    assert area_under_curve(distances, missed) == pytest.approx(area / 0.1, abs=1e-6)
    assert area_under_curve([0.0, 0.0], 0) == 1.0
    assert fraction_near([0.01, 0.03], 2) == 0.25
    assert np.isnan(area_under_curve([], 0))
    assert area_under_curve([], 2) == fraction_near([], 2) == 0.0
