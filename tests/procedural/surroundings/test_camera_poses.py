"""The grid of stereo cameras."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from glassware.core.errors import InputError
from glassware.core.pose import look_at
from glassware.procedural.surroundings.camera_poses import draw_cameras, grid_directions, reach, spread_order
from glassware.procedural.surroundings.camera_ranges import Workspace
from glassware.procedural.surroundings.camera_settings import CameraSettings
from glassware.procedural.surroundings.intrinsics import Intrinsics, fit_distance

# Rounding of a few float64 operations on numbers of order 1.
EXACT = 1e-12
# Rounding of float64 in pixels of order 1000.
PIXEL = 1e-9
JITTERED: dict[str, Any] = {"angle_jitter": 0.1, "target_jitter": 0.03, "roll": math.pi}


def drawn(seed: int, centre=(0.05, -0.03, 0.08), radius: float = 0.2, **settings):
    space = Workspace(np.array(centre), radius)
    return draw_cameras(np.random.default_rng(seed), CameraSettings(**settings), space, 1.5)


def sphere_points(centre, radius: float, count: int = 400) -> np.ndarray:
    points = np.random.default_rng(0).normal(size=(count, 3))
    return np.array(centre) + radius * points / np.linalg.norm(points, axis=1, keepdims=True)


def projected(camera, world_T_camera: np.ndarray, points: np.ndarray) -> np.ndarray:
    local = (points - world_T_camera[:3, 3]) @ world_T_camera[:3, :3]
    assert (local[:, 2] > 0.0).all()
    image = local @ camera.K.T
    return image[:, :2] / image[:, 2:]


@pytest.mark.parametrize("jitter", [{}, JITTERED])
def test_axes_are_orthonormal_and_right_handed(jitter):
    for camera in drawn(3, views=57, **jitter):
        rotation = camera.world_T_camera[:3, :3]
        np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=EXACT)
        assert np.linalg.det(rotation) == pytest.approx(1.0, abs=EXACT)


def test_the_optical_axis_passes_through_the_target():
    centre = np.array([0.05, -0.03, 0.08])
    for camera in drawn(4, views=57):
        offset = centre - camera.world_T_camera[:3, 3]
        np.testing.assert_allclose(np.cross(offset, camera.world_T_camera[:3, 2]), 0.0, atol=EXACT)
        assert offset @ camera.world_T_camera[:3, 2] > 0.0


def test_up_in_the_world_is_up_in_the_picture():
    for camera in drawn(5, views=57)[1:]:
        above = np.array([[0.05, -0.03, 0.08], [0.05, -0.03, 0.12]])
        low, high = projected(camera, camera.world_T_camera, above)
        assert high[1] < low[1]
        assert high[0] == pytest.approx(low[0], abs=PIXEL)


def test_the_zenith_is_the_limit_of_a_climb_at_azimuth_zero():
    near = look_at(np.array([1e-6, 0.0, 1.0]), np.zeros(3))
    at = look_at(np.array([0.0, 0.0, 1.0]), np.zeros(3))
    np.testing.assert_allclose(at[:3, :3], near[:3, :3], atol=2e-6)


def test_a_camera_at_its_target_is_refused():
    with pytest.raises(InputError, match="a point away from the eye"):
        look_at(np.ones(3), np.ones(3))


@pytest.mark.parametrize("jitter", [{}, JITTERED])
def test_the_workspace_lies_inside_both_pictures_of_all_views(jitter):
    for seed in range(30):
        size = {"width": 320, "height": 240} if seed % 2 else {"width": 400, "height": 640}
        radius, centre = 0.05 + 0.02 * seed, (0.1, 0.05, 0.1)
        points = sphere_points(centre, radius)
        for camera in drawn(seed, centre, radius, views=57, slack=(1.0, 1.1), **size, **jitter):
            for pose in (camera.world_T_camera, camera.world_T_right):
                image = projected(camera, pose, points)
                assert (image >= -0.5 - PIXEL).all()
                assert (image <= np.array([camera.width, camera.height]) - 0.5 + PIXEL).all()


@pytest.mark.parametrize(("width", "height"), [(640, 480), (320, 640)])
def test_the_fitting_distance_is_the_shortest(width, height):
    radius, focal, baseline = 0.2, 600.0, 0.065
    lens = Intrinsics(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)
    distance = fit_distance(lens, baseline, radius)
    across, up = math.atan(0.5 * width / focal), math.atan(0.5 * height / focal)
    # The right camera sees the sphere's left side under this angle from its axis; the left camera its top.
    left = math.atan2(baseline, distance) + math.asin(radius / math.hypot(distance, baseline))
    top = math.asin(radius / distance)
    assert left <= across + EXACT
    assert top <= up + EXACT
    assert max(left - across, top - up) == pytest.approx(0.0, abs=EXACT)


def test_the_grid_is_the_zenith_and_four_rings_of_fourteen():
    directions = grid_directions(math.radians(10.0))
    elevation = np.degrees(np.arcsin(directions[:, 2]))
    np.testing.assert_allclose(elevation, [90] + [70] * 14 + [50] * 14 + [30] * 14 + [10] * 14, atol=1e-6)
    for ring in range(4):
        turn = np.arctan2(*directions[1 + 14 * ring : 15 + 14 * ring, 1::-1].T)
        np.testing.assert_allclose(np.mod(np.diff(turn), 2 * math.pi), 2 * math.pi / 14, atol=EXACT)
        assert turn[0] == pytest.approx(0.0, abs=EXACT)


def test_all_views_come_in_the_grid_order_at_one_distance():
    cameras = drawn(6, views=57)
    assert [camera.grid_index for camera in cameras] == list(range(57))
    distances = [np.linalg.norm(c.world_T_camera[:3, 3] - (0.05, -0.03, 0.08)) for c in cameras]
    np.testing.assert_allclose(distances, distances[0], rtol=EXACT)


@pytest.mark.parametrize("jitter", [{}, JITTERED])
def test_fewer_views_are_the_first_of_more(jitter):
    few, many = drawn(7, views=5, **jitter), drawn(7, views=10, **jitter)
    for a, b in zip(few, many, strict=False):
        assert a.grid_index == b.grid_index
        np.testing.assert_array_equal(a.world_T_camera, b.world_T_camera)


def test_a_subset_is_spread_out():
    settings = CameraSettings()
    directions = grid_directions(settings.lowest_elevation)
    for start in range(57):
        order = spread_order(settings, start)
        assert sorted(order) == list(range(57))
        chosen = directions[order[:5]]
        angles = np.degrees(np.arccos(np.clip(chosen @ chosen.T, -1, 1)))[~np.eye(5, dtype=bool)]
        # Five caps that do not overlap on a half sphere have radii of at most 43 degrees; a random five average 15.
        assert angles.min() > 50.0


def test_views_at_one_seed_differ_from_those_at_another():
    assert not np.array_equal(drawn(1, views=3)[0].world_T_camera, drawn(2, views=3)[0].world_T_camera)


def test_every_eye_stays_above_the_table():
    for seed in range(20):
        cameras = drawn(seed, (0, 0, 0.02), 0.03, views=57, min_height=0.25, angle_jitter=0.4, target_jitter=0.01)
        assert min(camera.world_T_camera[2, 3] for camera in cameras) >= 0.25 - EXACT


def test_a_height_out_of_reach_is_one_clear_line():
    with pytest.raises(InputError, match=r"cameras.min_height: expected at most .* m .*, found 9\.0"):
        drawn(0, min_height=9.0)


def test_no_eye_is_beyond_the_reach():
    for seed in range(20):
        settings = CameraSettings(views=57, **JITTERED)
        bound = reach(settings, Workspace(np.array([0.05, -0.03, 0.08]), 0.2))
        cameras = drawn(seed, views=57, **JITTERED)
        eyes = [pose[:3, 3] for camera in cameras for pose in (camera.world_T_camera, camera.world_T_right)]
        assert max(np.linalg.norm(eye) for eye in eyes) <= bound
        assert max(np.linalg.norm(eye) for eye in eyes) >= 0.5 * bound


def test_intrinsics_are_those_of_syn_todd_and_scale_with_the_width():
    full, half = drawn(0, views=1)[0], drawn(0, views=1, width=320, height=240)[0]
    np.testing.assert_allclose(
        full.K, [[613.9624633789062, 0, 319.5], [0, 613.9624633789062, 239.5], [0, 0, 1]], rtol=EXACT
    )
    assert full.baseline == 0.06499999761581421
    assert half.focal == pytest.approx(full.focal / 2)
    assert half.centre == (159.5, 119.5)


@pytest.mark.parametrize("bad", [{"views": 0}, {"views": 58}, {"width": 0}, {"slack": (0.9, 1.0)}, {"turns": 3}])
def test_settings_out_of_range_name_the_field(bad):
    with pytest.raises(ValidationError, match=next(iter(bad))):
        CameraSettings(**bad)


def test_a_range_has_its_smaller_end_first():
    with pytest.raises(ValidationError, match="slack"):
        CameraSettings(slack=(2.0, 1.5))
