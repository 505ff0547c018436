from __future__ import annotations

import re

import cv2
import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.dataset.cameras.lens import check_distortion, distorted, falloff, folds, undistorted, warps
from glassware.dataset.cameras.model import Distortion
from glassware.dataset.cameras.presets import CAMERAS

WIDTH, HEIGHT = 160, 120
OPTICS = (150.0, 152.0, 80.3, 58.9)
BARREL = Distortion(k1=-0.2, k2=0.03, p1=0.002, p2=-0.001)
PINCUSHION = Distortion(k1=0.12, p1=-0.001, p2=0.002)
#: OpenCV's subpixel corners of a bilinear chequer [px].
CORNER_ERROR = 0.1


def chequer(side: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a chequer on a fourfold grid, area-averaged, and its inner corners [px]."""
    fine = 4
    y, x = np.mgrid[: HEIGHT * fine, : WIDTH * fine] // (side * fine)
    picture = ((x + y) % 2).astype(np.float32).reshape(HEIGHT, fine, WIDTH, fine).mean(axis=(1, 3))
    corners = np.stack(np.meshgrid(np.arange(side, WIDTH, side), np.arange(side, HEIGHT, side)), -1) - 0.5
    return picture, corners.reshape(-1, 2)


@pytest.mark.parametrize("lens", [BARREL, PINCUSHION])
def test_corners_of_a_warped_chequer_are_the_projected_and_distorted_ones(lens: Distortion) -> None:
    picture, corners = chequer(20)
    warped = warps(lens, OPTICS, WIDTH, HEIGHT).distort.applied(picture)
    fx, fy, cx, cy = OPTICS
    K = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    rays = np.column_stack([(corners - [cx, cy]) / [fx, fy], np.ones(len(corners))])
    expected = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), K, np.array(lens.coefficients))[0].reshape(-1, 2)
    expected = expected[(expected > 8).all(axis=1) & (expected < [WIDTH - 9, HEIGHT - 9]).all(axis=1)]
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-4)
    guess = np.ascontiguousarray(np.rint(expected), np.float32)
    found = cv2.cornerSubPix((255 * warped).astype(np.uint8), guess[:, None].copy(), (4, 4), (-1, -1), stop)
    assert len(expected) > 20
    assert np.abs(found[:, 0] - expected).max() < CORNER_ERROR
    assert np.abs(expected[:, None] - corners[None]).max(axis=-1).min(axis=1).max() > 5 * CORNER_ERROR  # it distorts


def test_the_inverse_takes_distorted_points_back() -> None:
    points = np.random.default_rng(1).uniform(-0.6, 0.6, (500, 2))
    assert np.abs(undistorted(distorted(points, BARREL), BARREL) - points).max() < 1e-9


def test_a_rectified_picture_is_the_pinholes_and_marks_what_is_lost() -> None:
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    picture = (0.5 + 0.4 * np.sin(x / 15) * np.cos(y / 12)).astype(np.float32)
    for lens, some in ((BARREL, False), (PINCUSHION, True)):
        maps = warps(lens, OPTICS, WIDTH, HEIGHT)
        again = maps.rectify.applied(maps.distort.applied(picture))
        # Half a pixel beyond the centres of what was rendered, the values of its border count.
        edge = (
            (maps.rectify.x < 0) | (maps.rectify.x > WIDTH - 1) | (maps.rectify.y < 0) | (maps.rectify.y > HEIGHT - 1)
        )
        kept = ~(maps.lost | edge | (maps.rectify.applied(maps.outside.astype(np.float32)) > 0))[1:-1, 1:-1]
        assert np.abs(again - picture)[1:-1, 1:-1][kept].max() < 0.005  # two bilinear samplings of a smooth picture
        assert maps.lost[1:-1, 1:-1].any() == some
        assert maps.outside[1:-1, 1:-1].any() != some


def test_a_distortion_that_folds_over_inside_the_picture_is_refused_with_one_that_does_not() -> None:
    # r + k1 r^3 turns back at r = sqrt(-1 / (3 k1)), where it is 2/3 of that.
    corner = np.hypot(81.3 / 150, 60.1 / 152)
    edge = -4 / 27 / corner**2
    assert not folds(Distortion(k1=0.97 * edge), OPTICS, WIDTH, HEIGHT)
    assert folds(Distortion(k1=1.03 * edge), OPTICS, WIDTH, HEIGHT)
    with pytest.raises(InputError, match=r"mine: distortion: expected .* such as 0\.33\d? times all its coefficients"):
        check_distortion(Distortion(k1=3 * edge), OPTICS, WIDTH, HEIGHT, "mine")


@pytest.mark.parametrize("width", [1, 40, 100])
def test_what_is_said_to_work_in_place_of_a_distortion_that_folds_over_works(width: int) -> None:
    lens, optics = CAMERAS["webcam"].distortion, (0.96 * width, 0.96 * width, (width - 1) / 2, 119.5)
    with pytest.raises(InputError) as error:
        check_distortion(lens, optics, width, 240, "webcam")
    found = re.search(r"such as (\S+) times all its coefficients, or (\S+) times fx, found", str(error.value))
    assert found is not None
    weaker, longer = map(float, found.groups())
    assert 0.0 < weaker < 1.0 < longer
    for slack, fold in ((1.0, False), (1.02, True)):  # rounded to three digits, and found to a thousandth
        focal = longer / slack * optics[0]
        assert folds(lens.scaled(weaker * slack), optics, width, 240) == fold
        assert folds(lens, (focal, focal, *optics[2:]), width, 240) == fold


def test_light_falls_off_with_the_cosine_of_each_pixels_ray() -> None:
    fx, fy, cx, cy = OPTICS
    x, y = 151, 7
    slope = np.hypot((x - cx) / fx, (y - cy) / fy)
    assert falloff(Distortion(), OPTICS, WIDTH, HEIGHT)[y, x, 0] == pytest.approx(np.cos(np.arctan(slope)), rel=1e-6)
    with_lens = falloff(PINCUSHION, OPTICS, WIDTH, HEIGHT)[y, x, 0]
    ray = undistorted(np.array([(x - cx) / fx, (y - cy) / fy]), PINCUSHION)
    assert with_lens == pytest.approx(1 / np.sqrt(1 + ray @ ray), rel=1e-6)
