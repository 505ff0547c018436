"""Cameras of a user's pair: devices by name, calibrations from files, baseline and focal length."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.learn.prediction.rigs import RigOptions, with_rig


def pair(width: int = 848, height: int = 480) -> list[np.ndarray]:
    return [np.zeros((height, width, 3), np.uint8)] * 2


def calibration(width: int = 64, height: int = 48, **changes) -> dict:
    K = [[60.0, 0.0, 31.5], [0.0, 60.0, 23.5], [0.0, 0.0, 1.0]]
    eye = {"K": K, "width": width, "height": height, "distortion": [0.1, 0.0, 0.0, 0.0]}
    right = np.eye(4)
    right[0, 3] = 0.06
    return {"left": eye, "right": eye, "left_T_right": right.tolist()} | changes


def test_a_device_has_its_own_k_and_baseline_at_any_size_of_its_shape():
    left, right = with_rig(pair(), RigOptions("d435"))
    assert left.K[0, 0] == 430.14
    assert right.world_T_camera[0, 3] == 0.05
    half, _ = with_rig(pair(424, 240), RigOptions("d435"))
    assert half.K[0, 0] == pytest.approx(215.07)
    assert half.K[0, 2] == pytest.approx((left.K[0, 2] + 0.5) / 2 - 0.5)


def test_baseline_and_field_of_view_make_a_camera_whose_edges_are_where_they_say():
    left, right = with_rig(pair(640, 480), RigOptions(baseline=0.065, fov=math.radians(60)))
    edge = np.linalg.inv(left.K) @ np.array([-0.5, 239.5, 1.0])
    assert edge[0] == pytest.approx(-math.tan(math.radians(30)))
    assert edge[1] == pytest.approx(0.0)
    assert right.world_T_camera[0, 3] == 0.065
    tele, _ = with_rig(pair(), RigOptions("d435", baseline=0.1, focal=900.0))
    assert (tele.K[0, 0], tele.K[0, 2]) == (900.0, 425.16)


def test_a_calibration_file_gives_each_eye_its_lens_and_the_right_one_its_pose(tmp_path):
    (tmp_path / "rig.json").write_text(json.dumps(calibration()))
    left, right = with_rig(pair(64, 48), RigOptions(str(tmp_path / "rig.json")))
    assert left.distortion.k1 == 0.1
    assert right.world_T_camera[0, 3] == 0.06


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (RigOptions("d453"), r"--camera: expected one of d415, .* \(is it d4\d5\?\), or a JSON file, found d453"),
        (RigOptions("phone"), r"--camera: expected one of .*, or a JSON file, found phone"),
        (RigOptions("zed2"), r"--camera zed2: expected pictures of 1280 x 720 px, or of that shape, found 64 x 48 px"),
        (RigOptions(baseline=0.05), r"expected --baseline with --focal or --fov, or --camera, found --baseline alone"),
        (RigOptions(fov=1.0), r"expected --baseline with --focal or --fov, or --camera, found --focal or --fov alone"),
        (RigOptions(baseline=0.05, focal=60.0, fov=1.0), r"--focal: expected either it or --fov, found both"),
    ],
)
def test_a_camera_that_is_not_known_is_one_clear_line(options, said):
    with pytest.raises(InputError, match=said):
        with_rig(pair(64, 48), options)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"width": 128, "height": 96}, r"rig\.json: left: expected pictures of 128 x 96 px, as .*, found 64 x 48 px"),
        ({"left_T_right": [[1.0]]}, r"rig\.json: left_T_right: expected a 4x4 matrix"),
        ({"right": None}, r"rig\.json: right: expected "),
        ({"extra": 1}, r"rig\.json: expected known fields, found extra"),
    ],
)
def test_a_wrong_calibration_is_one_clear_line(tmp_path, changes, said):
    size = {name: changes.pop(name) for name in ("width", "height") if name in changes}
    (tmp_path / "rig.json").write_text(json.dumps(calibration(**size) | changes))
    with pytest.raises(InputError, match=said):
        with_rig(pair(64, 48), RigOptions(str(tmp_path / "rig.json")))


def test_a_lens_that_folds_the_picture_over_is_refused(tmp_path):
    data = calibration()
    data["left"] = data["left"] | {"distortion": [-3.0, 0.0, 0.0, 0.0, 0.0]}
    (tmp_path / "rig.json").write_text(json.dumps(data))
    with pytest.raises(InputError, match=r"rig\.json: left: distortion: expected a distortion that does not fold over"):
        with_rig(pair(64, 48), RigOptions(str(tmp_path / "rig.json")))


def test_one_eye_and_eyes_of_two_sizes_are_refused():
    with pytest.raises(InputError, match="--camera: expected the two pictures of a stereo pair, found 1"):
        with_rig(pair()[:1], RigOptions("d435"))
    with pytest.raises(InputError, match="pictures: expected two of one size, found 64 x 48 px and 32 x 24 px"):
        with_rig([pair(64, 48)[0], pair(32, 24)[0]], RigOptions("d435"))


def test_the_calibration_that_the_page_shows_is_taken(tmp_path):
    text = (Path(__file__).resolve().parents[3] / "docs" / "pretrained.md").read_text("utf-8")
    (tmp_path / "rig.json").write_text(text.split("```json\n")[1].split("```")[0])
    left, right = with_rig(pair(640, 480), RigOptions(str(tmp_path / "rig.json")))
    assert (left.distortion.k1, right.distortion.k1) == (-0.12, -0.11)
    assert right.world_T_camera[0, 3] == 0.0601
