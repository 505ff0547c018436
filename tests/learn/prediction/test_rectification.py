"""Lenses and turned cameras, against OpenCV's own projection."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from glassware.annotate.projection import project_camera
from glassware.dataset.cameras.model import Distortion
from glassware.learn.prediction.own_pictures import OwnPicture
from glassware.learn.prediction.rectification import at_source, pinholes, seen_at

HEIGHT, WIDTH = 96, 128
K = np.array([[120.0, 0.0, 65.0], [0.0, 118.0, 46.0], [0.0, 0.0, 1.0]])
LENS = Distortion(k1=0.12, k2=-0.2, p1=0.002, p2=-0.003, k3=0.05)
#: Rounding to the nearest pixel on the way there: half a pixel, and a little for the lens' scale.
NEAREST = 0.75


def pose(turn: tuple[float, float, float], place: tuple[float, float, float]) -> np.ndarray:
    found = np.eye(4)
    found[:3, :3] = cv2.Rodrigues(np.array(turn, np.float64))[0]
    found[:3, 3] = place
    return found


def ramp(seed: int) -> np.ndarray:
    """A picture whose values change slowly, so that bilinear interpolation is nearly exact."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    return np.stack([x, y, (x + seed) % 200], axis=-1).astype(np.uint8)


@pytest.fixture
def pair() -> list[OwnPicture]:
    """Two cameras that look a little together, each with a lens."""
    left = OwnPicture(ramp(0), pose((0.1, 0.2, 0.3), (1.0, 2.0, 3.0)), K, LENS)
    right = OwnPicture(ramp(1), left.world_T_camera @ pose((0.01, -0.04, 0.02), (0.07, 0.004, -0.003)), K, LENS)
    return [left, right]


@pytest.fixture
def points() -> np.ndarray:
    """Points before the left camera [m]."""
    rng = np.random.default_rng(4)
    return np.stack([rng.uniform(-0.12, 0.12, 40), rng.uniform(-0.1, 0.1, 40), rng.uniform(0.5, 0.9, 40)], axis=1)


def opencv_pixels(points: np.ndarray, world_T_points: np.ndarray, own: OwnPicture) -> np.ndarray:
    camera_T = np.linalg.inv(own.world_T_camera) @ world_T_points
    lens = np.array(own.distortion.coefficients)
    return cv2.projectPoints(points, cv2.Rodrigues(camera_T[:3, :3])[0], camera_T[:3, 3], own.K, lens)[0][:, 0]


def test_a_rectified_pair_sees_every_point_in_one_row_and_farther_left_in_the_right_eye(pair, points):
    seen = pinholes(pair)
    pixels, Z = [], np.zeros(0)
    for one in seen:
        camera_T = np.linalg.inv(one.view.world_T_camera) @ pair[0].world_T_camera
        found, Z = project_camera(points @ camera_T[:3, :3].T + camera_T[:3, 3], one.view.K)
        pixels.append(found)
    np.testing.assert_allclose(pixels[0][:, 1], pixels[1][:, 1], atol=1e-9)
    baseline = np.linalg.norm((np.linalg.inv(pair[0].world_T_camera) @ pair[1].world_T_camera)[:3, 3])
    np.testing.assert_allclose(pixels[0][:, 0] - pixels[1][:, 0], seen[0].view.K[0, 0] * baseline / Z, rtol=1e-9)


def test_pixels_of_the_users_picture_lie_where_opencv_projects_them(pair, points):
    for own, one in zip(pair, pinholes(pair), strict=True):
        rows, columns, scale = seen_at(one)
        camera_T = np.linalg.inv(one.view.world_T_camera) @ pair[0].world_T_camera
        in_view = points @ camera_T[:3, :3].T + camera_T[:3, 3]
        expected, Z = project_camera(in_view, one.view.K)
        at = opencv_pixels(points, pair[0].world_T_camera, own)
        inside = (at > 0).all(1) & (at[:, 0] < WIDTH - 1) & (at[:, 1] < HEIGHT - 1)
        x, y = np.rint(at[inside]).astype(int).T
        known = np.isfinite(scale[y, x])
        assert known.sum() > 20
        found = np.stack([columns[y, x], rows[y, x]], axis=1)[known]
        assert np.abs(found - expected[inside][known]).max() < 2 * NEAREST
        own_Z = (points @ (np.linalg.inv(own.world_T_camera) @ pair[0].world_T_camera)[:3, :3].T)[:, 2]
        own_Z += (np.linalg.inv(own.world_T_camera) @ pair[0].world_T_camera)[2, 3]
        np.testing.assert_allclose((Z[inside] * scale[y, x])[known], own_Z[inside][known], rtol=2e-3)


def test_the_picture_of_the_pinhole_shows_what_the_lens_saw(pair, points):
    """Red is the column of the user's picture, green its row: both are read at where a point projects."""
    one = pinholes(pair)[0]
    camera_T = np.linalg.inv(one.view.world_T_camera) @ pair[0].world_T_camera
    at, _ = project_camera(points @ camera_T[:3, :3].T + camera_T[:3, 3], one.view.K)
    source = opencv_pixels(points, pair[0].world_T_camera, pair[0])
    inside = (at > 1).all(1) & (at[:, 0] < WIDTH - 2) & (at[:, 1] < HEIGHT - 2)
    inside &= (source > 1).all(1) & (source[:, 0] < WIDTH - 2) & (source[:, 1] < HEIGHT - 2)
    x, y = np.rint(at[inside]).astype(int).T
    assert inside.sum() > 20
    assert np.abs(one.view.picture[y, x, :2] - source[inside]).max() < 2 * NEAREST


def test_poses_go_back_to_the_users_camera(pair):
    one = pinholes(pair)[0]
    in_world = pose((0.3, 0.1, -0.2), (1.1, 2.0, 3.6))
    in_view = np.linalg.inv(one.view.world_T_camera) @ in_world
    np.testing.assert_allclose(
        at_source(in_view[None], one)[0], np.linalg.inv(pair[0].world_T_camera) @ in_world, atol=1e-12
    )


def test_a_rectified_pair_of_pinholes_and_two_far_views_are_left_as_they_are():
    left = OwnPicture(ramp(0), np.eye(4), K, Distortion())
    for other in (pose((0, 0, 0), (0.06, 0, 0)), pose((0, -1.0, 0), (0.5, 0.0, 0.2)), pose((0, 0, 0), (0, 0.3, 0))):
        seen = pinholes([left, OwnPicture(ramp(1), other, K, Distortion())])
        assert all(one.same for one in seen)
