"""Cameras of a user's own images: suspicious ones are refused with what they probably are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.pose import look_at
from glassware.learn.data.views import CameraView
from glassware.learn.prediction.camera_checks import check_cameras
from glassware.learn.prediction.own_pictures import read_own_picture

PICTURE = np.zeros((48, 64, 3), np.uint8)
K = np.array([[60.0, 0.0, 31.5], [0.0, 60.0, 23.5], [0.0, 0.0, 1.0]])
NAMES = [Path("a.png"), Path("b.png"), Path("c.png")]
#: OpenGL's axes: y up, z back.
GL = np.diag([1.0, -1.0, -1.0, 1.0])
#: Two cameras above a table that look at its middle, and one beside the first with the same axes.
ONE, TWO = look_at(np.array([0.5, 0.0, 0.5]), np.zeros(3)), look_at(np.array([0.0, 0.5, 0.5]), np.zeros(3))
BESIDE = ONE @ np.array([[1.0, 0.0, 0.0, 0.065], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def checked(*poses: np.ndarray, K: np.ndarray = K) -> None:
    check_cameras([CameraView(PICTURE, pose, K) for pose in poses], NAMES[: len(poses)])


def in_unit(pose: np.ndarray, factor: float) -> np.ndarray:
    changed = pose.copy()
    changed[:3, 3] *= factor
    return changed


@pytest.mark.parametrize(
    "poses", [(ONE, TWO), (ONE, BESIDE), (ONE, BESIDE, TWO), (np.eye(4), np.linalg.inv(ONE) @ TWO)]
)
def test_cameras_that_see_one_table_are_taken_in_any_frame(poses) -> None:
    checked(*poses)


@pytest.mark.parametrize(("factor", "unit"), [(1000.0, "millimetres"), (100.0, "centimetres")])
def test_poses_in_another_unit_are_refused(factor, unit) -> None:
    with pytest.raises(InputError, match=rf"a\.png: world_T_camera: expected poses in metres, .*in {unit} it would be"):
        checked(in_unit(ONE, factor), in_unit(BESIDE, factor))


@pytest.mark.parametrize("other", [TWO, BESIDE])
def test_opengls_axes_are_refused_for_converging_and_parallel_cameras(other) -> None:
    with pytest.raises(InputError, match=r"expected OpenCV's axes .*, found .*negate the second and the third column"):
        checked(ONE @ GL, other @ GL)


def test_opengls_axes_are_refused_in_a_frame_of_their_own() -> None:
    first = np.linalg.inv(ONE @ GL)
    with pytest.raises(InputError, match="whose axes meet behind them"):
        checked(np.eye(4), first @ TWO @ GL)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_the_k_of_a_picture_of_another_size_is_refused(factor) -> None:
    other = K.copy()
    other[:2] *= factor
    with pytest.raises(InputError, match=r"a\.png: K: expected a principal point near the middle of .* 64 x 48 px"):
        checked(ONE, TWO, K=other)


def test_views_without_a_baseline_are_refused() -> None:
    with pytest.raises(InputError, match="found a baseline of 0 mm, so no parallax"):
        checked(ONE, ONE)


INPUTS = Path(__file__).resolve().parents[4] / "shared" / "inputs" / "predict"


@pytest.mark.skipif(not INPUTS.is_dir(), reason="the folder shared/inputs is not beside this checkout")
@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("mm", "mmr"), "in millimetres it would be"),
        (("gl", "glr"), "negate the second and the third column"),
        (("a", "a"), "found a baseline of 0 mm"),
        (("small", "small"), "a principal point near the middle"),
    ],
)
def test_cameras_of_reported_files_are_refused_with_what_is_suspicious(names, said) -> None:
    paths = [INPUTS / f"{name}.png" for name in names]
    with pytest.raises(InputError, match=said):
        check_cameras([read_own_picture(path).view for path in paths], paths)
