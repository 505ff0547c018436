"""Cameras in ranges of directions and distances, and at poses of a file."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.pose import look_at
from glassware.procedural.surroundings.camera_poses import draw_cameras, poses_of, reach
from glassware.procedural.surroundings.camera_ranges import Blocked, Workspace
from glassware.procedural.surroundings.camera_settings import CameraSettings

CENTRE = np.array([0.05, -0.03, 0.08])
SPACE = Workspace(CENTRE, 0.1)
# Rounding of a few float64 operations on numbers of order 1.
EXACT = 1e-12
RANGES: dict[str, Any] = {"elevation": ("30deg", "60deg"), "azimuth": ("-90deg", "90deg"), "distance": (0.4, "80cm")}


def settings(**given: Any) -> CameraSettings:
    return CameraSettings.model_validate(given)


def drawn(seed: int = 0, space: Workspace = SPACE, **given: Any):
    return draw_cameras(np.random.default_rng(seed), settings(**given), space, 1.5)


def placed(cameras) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return distances, elevations and azimuths of cameras, seen from the middle of the workspace."""
    offsets = np.array([camera.world_T_camera[:3, 3] for camera in cameras]) - CENTRE
    distance = np.linalg.norm(offsets, axis=1)
    return distance, np.arcsin(offsets[:, 2] / distance), np.arctan2(offsets[:, 1], offsets[:, 0])


def test_cameras_fill_their_ranges_and_keep_them():
    cameras = drawn(views=400, **RANGES)
    limits = ((0.4, 0.8), (math.pi / 6, math.pi / 3), (-math.pi / 2, math.pi / 2))
    for values, (low, high) in zip(placed(cameras), limits, strict=True):
        assert low - EXACT <= values.min() <= low + 0.05 * (high - low)
        assert high - 0.05 * (high - low) <= values.max() <= high + EXACT
        # The mean of 400 uniform numbers is within five standard errors, range / sqrt(12 * 400).
        assert values.mean() == pytest.approx(0.5 * (low + high), abs=5.0 * (high - low) / math.sqrt(4800.0))
    assert {camera.grid_index for camera in cameras} == {None}


def test_a_camera_looks_down_by_its_elevation():
    cameras = drawn(views=20, elevation=("45deg", "45deg"))
    assert [-camera.world_T_camera[2, 2] for camera in cameras] == pytest.approx([math.sqrt(0.5)] * 20)


def test_one_more_view_changes_no_other():
    few, many = drawn(7, views=3, **RANGES), drawn(7, views=30, **RANGES)
    for a, b in zip(few, many, strict=False):
        np.testing.assert_array_equal(a.world_T_camera, b.world_T_camera)


def test_without_a_distance_the_objects_fit_the_picture():
    for camera in drawn(views=30, elevation=("20deg", "80deg"), slack=(1.0, 1.0)):
        assert np.linalg.norm(camera.world_T_camera[:3, 3] - CENTRE) >= 0.3


def test_the_looking_direction_turns_by_its_jitter():
    cameras = drawn(views=300, look_jitter="5deg", **RANGES)
    offsets = np.array([CENTRE - camera.world_T_camera[:3, 3] for camera in cameras])
    ahead = np.array([camera.world_T_camera[:3, 2] for camera in cameras])
    cosine = (offsets * ahead).sum(1) / np.linalg.norm(offsets, axis=1)
    angles = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    assert 4.5 <= angles.max() <= 5.0 + 1e-6
    assert np.median(angles) == pytest.approx(5.0 / math.sqrt(2.0), abs=0.5)  # uniform over the disc
    for camera in cameras:
        rotation = camera.world_T_camera[:3, :3]
        np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=EXACT)


def test_cameras_keep_their_height_within_the_range():
    cameras = drawn(views=100, elevation=(0.0, "40deg"), distance=(0.5, 0.6), min_height=0.3)
    assert min(camera.world_T_camera[2, 3] for camera in cameras) >= 0.3 - EXACT
    assert placed(cameras)[1].max() <= math.radians(40.0) + EXACT


def test_no_eye_is_beyond_the_reach():
    asked = settings(views=100, target_jitter=0.02, **RANGES)
    cameras = draw_cameras(np.random.default_rng(3), asked, SPACE, 1.5)
    eyes = [pose[:3, 3] for camera in cameras for pose in (camera.world_T_camera, camera.world_T_right)]
    assert max(np.linalg.norm(eye) for eye in eyes) <= reach(asked, SPACE)


def test_draws_in_a_body_or_without_a_vessel_are_replaced():
    def behind(camera) -> Blocked | None:
        return Blocked("there", 1.0) if camera.world_T_camera[0, 3] < CENTRE[0] else None

    cameras = drawn(views=50, space=replace(SPACE, blocked=behind), elevation=("30deg", "60deg"))
    assert min(camera.world_T_camera[0, 3] for camera in cameras) >= CENTRE[0]


def test_ranges_without_a_usable_camera_name_the_nearest_value():
    def far(camera) -> bool:
        return bool(np.linalg.norm(camera.world_T_camera[:3, 3] - CENTRE) > 0.35)

    space = replace(SPACE, shown=far)
    near: dict[str, Any] = {"elevation": ("30deg", "60deg"), "distance": (0.1, 0.2)}
    with pytest.raises(InputError, match=r"distance: expected a range from 0\.3[5-9] m, found 0\.1 to 0\.2 m"):
        drawn(space=space, **near)
    near["distance"] = (0.38, 0.4)
    assert drawn(space=space, **near)
    with pytest.raises(InputError, match=r"cameras\.elevation: expected up to .*deg or more, .*, found up to 1deg"):
        drawn(elevation=(0.0, "1deg"), distance=(0.5, 0.6), min_height=0.2)
    with pytest.raises(InputError, match=r"cameras\.min_height: expected at most 0\.680 m at this distance, found 2 m"):
        drawn(distance=(0.5, 0.6), min_height=2)


@pytest.fixture
def poses(tmp_path, rng):
    """A file of six poses that look at the workspace."""
    eyes = rng.uniform((-0.4, -0.4, 0.3), (0.4, 0.4, 0.8), (6, 3))
    matrices = np.array([look_at(eye, CENTRE) for eye in eyes])
    np.save(tmp_path / "poses.npy", matrices)
    return tmp_path / "poses.npy", matrices


def at_poses(path, space: Workspace = SPACE, seed: int = 0, **given: Any):
    asked = settings(poses=path, **given)
    return draw_cameras(np.random.default_rng(seed), asked, space, 1.5, poses_of(asked))


def test_cameras_stand_at_the_poses_in_their_order(poses):
    path, matrices = poses
    cameras = at_poses(path, views=6)
    np.testing.assert_allclose([camera.world_T_camera for camera in cameras], matrices, atol=EXACT)


def test_fewer_views_are_a_random_choice_of_the_scene(poses):
    path, matrices = poses
    chosen = set()
    for seed in range(10):
        for camera in at_poses(path, seed=seed, views=2):
            chosen.add(int(np.abs(matrices - camera.world_T_camera).sum((1, 2)).argmin()))
    assert chosen == set(range(6))


def test_more_views_than_poses_are_refused_with_their_number(poses):
    with pytest.raises(InputError, match=r"cameras\.views: expected at most 6, the poses in .*, found 7"):
        at_poses(poses[0], views=7)


def test_a_pose_inside_a_body_is_named_with_its_row(poses):
    space = replace(SPACE, blocked=lambda _camera: Blocked("(0.1, 0.0, 0.1), in vessel-00", 0.2))
    with pytest.raises(InputError, match=r"poses\.npy, pose 0: expected a place in the air, such as z above 0\.200 m"):
        at_poses(poses[0], space, views=6)


def test_poses_that_show_no_object_at_all_say_what_is_expected_of_them(poses):
    with pytest.raises(InputError, match=r"expected poses with an object .*OpenCV axes.*, found none of 6"):
        at_poses(poses[0], replace(SPACE, shown=lambda _camera: False), views=6)
