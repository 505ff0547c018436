"""What is said of pictures that cannot be what they are said to be."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.learn.data.views import CameraView
from glassware.learn.prediction.picture_checks import check_light, check_pair

NAMES = ["left.png", "right.png"]
K = np.array([[300.0, 0.0, 159.5], [0.0, 300.0, 119.5], [0.0, 0.0, 1.0]])


def texture() -> np.ndarray:
    """Blobs of many sizes, as on cloth or wood."""
    rng = np.random.default_rng(7)
    layers = [
        cv2.resize(rng.uniform(0, 1, (n, 2 * n, 3)), (520, 260), interpolation=cv2.INTER_CUBIC) for n in (8, 24, 64)
    ]
    return np.clip(255 * sum(layers) / 3, 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def eyes() -> list[CameraView]:
    """Two walls at 0.75 m and 1.5 m, seen by cameras 0.1 m apart: disparities of 40 and 20 px."""
    wall, right = texture(), np.eye(4)
    right[0, 3] = 0.1
    pictures = []
    for near, far in ((100, 80), (140, 100)):
        picture = np.empty((240, 320, 3), np.uint8)
        picture[:120] = wall[:120, far : far + 320]
        picture[120:] = wall[120:240, near : near + 320]
        pictures.append(picture)
    return [CameraView(picture, pose, K) for picture, pose in zip(pictures, (np.eye(4), right), strict=True)]


def test_a_pair_in_order_is_taken(eyes):
    check_pair(eyes, NAMES)


def test_swapped_eyes_are_found_by_matching_and_said(eyes):
    left, right = eyes
    swapped = [CameraView(right.picture, left.world_T_camera, K), CameraView(left.picture, right.world_T_camera, K)]
    with pytest.raises(
        InputError, match=r"right\.png: expected the eyes in order, left\.png first .* found them swapped"
    ):
        check_pair(swapped, NAMES)


def test_one_eye_twice_is_said(eyes):
    left, right = eyes
    with pytest.raises(
        InputError, match=r"right\.png: expected the picture of another camera than left\.png, found the same"
    ):
        check_pair([left, CameraView(left.picture, right.world_T_camera, K)], NAMES)


@pytest.mark.parametrize("rows", [6, -8])
def test_a_pair_that_is_not_rectified_is_said_with_how_far_its_rows_are_off(eyes, rows):
    left, right = eyes
    moved = CameraView(np.roll(right.picture, rows, axis=0), right.world_T_camera, K)
    side = f"{abs(rows)}\\.\\d px {'below' if rows > 0 else 'above'}"
    with pytest.raises(
        InputError, match=rf"right\.png: expected the points of left\.png on the rows .* found them {side}"
    ):
        check_pair([left, moved], NAMES)


def test_a_turned_camera_is_said(eyes):
    left, right = eyes
    turn = cv2.getRotationMatrix2D((159.5, 119.5), 4.0, 1.0)
    turned = cv2.warpAffine(right.picture, turn, (320, 240), borderMode=cv2.BORDER_REPLICATE)
    with pytest.raises(InputError, match=r"on the rows \(epipolar lines\)"):
        check_pair([left, CameraView(turned, right.world_T_camera, K)], NAMES)


def test_pictures_without_features_say_nothing(eyes):
    left, right = eyes
    smooth = [
        np.full_like(left.picture, 90) + np.arange(320, dtype=np.uint8)[None, :, None] // 4 + one for one in (0, 1)
    ]
    check_pair([CameraView(smooth[0], left.world_T_camera, K), CameraView(smooth[1], right.world_T_camera, K)], NAMES)


@pytest.mark.parametrize(
    ("value", "spread", "said"),
    [
        (2, 3, r"a dark one: 99 of 100 pixels are below \d+ of 255"),
        (252, 3, r"a white one: 99 of 100 pixels are above 2\d\d of 255"),
        (120, 2, r"a blank one of about 12\d of 255"),
    ],
)
def test_dark_white_and_blank_pictures_are_one_clear_line(value, spread, said):
    picture = (value + np.random.default_rng(1).integers(0, spread, (48, 64, 1))).astype(np.uint8).repeat(3, axis=2)
    with pytest.raises(InputError, match=rf"left\.png: expected a picture in which something shows, found {said}"):
        check_light(picture, "left.png")


def test_a_night_scene_with_a_lamp_is_no_dark_picture():
    picture = np.zeros((48, 64, 3), np.uint8)
    picture[:6, :12] = 200
    check_light(picture, "left.png")
