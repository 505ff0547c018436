"""Camera poses from files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from glassware.core.errors import InputError
from glassware.core.pose import look_at
from glassware.procedural.surroundings.pose_files import read_poses

#: Rounding of a few float64 operations on numbers of order 1, with the orthonormalisation.
EXACT = 1e-12
#: What is left of numbers written with six digits.
SIX_DIGITS = 2e-6


@pytest.fixture
def poses(rng) -> np.ndarray:
    """Poses of cameras that look at the table, (5, 4, 4)."""
    eyes = rng.uniform((-0.4, -0.4, 0.3), (0.4, 0.4, 0.8), (5, 3))
    return np.array([look_at(eye, np.array([0.01, 0.02, 0.05])) for eye in eyes])


def check(path: Path, poses: np.ndarray, tolerance: float = EXACT) -> None:
    found = np.array([pose.world_T_camera for pose in read_poses(path)])
    np.testing.assert_allclose(found, poses, atol=tolerance)
    rotation = found[:, :3, :3]
    squares = rotation @ rotation.transpose(0, 2, 1)
    np.testing.assert_allclose(squares, np.broadcast_to(np.eye(3), squares.shape), atol=EXACT)


def as_text(rows: np.ndarray, form: str = "%.17g", separator: str = " ") -> str:
    return "\n".join(separator.join(form % x for x in row) for row in rows) + "\n"


def as_tum(poses: np.ndarray) -> np.ndarray:
    quaternions = Rotation.from_matrix(poses[:, :3, :3]).as_quat()
    return np.column_stack([np.arange(len(poses)) + 0.5, poses[:, :3, 3], quaternions])


def test_every_form_of_text_gives_the_same_poses(poses, tmp_path):
    path = tmp_path / "poses.txt"
    for text in (
        as_text(poses.reshape(-1, 16)),
        as_text(poses.reshape(-1, 16), separator=", "),
        as_text(poses.reshape(-1, 16)[:, :12]),
        as_text(poses.reshape(-1, 4)),
        "# robot 1\n\n" + "\n\n".join(as_text(pose) for pose in poses),
        "\n".join(str(np.array2string(pose, separator=", ", floatmode="unique", max_line_width=200)) for pose in poses),
        "# timestamp tx ty tz qx qy qz qw\n" + as_text(as_tum(poses)),
    ):
        path.write_text(text)
        check(path, poses)


def test_arrays_and_lists_give_them_as_well(poses, tmp_path):
    np.save(tmp_path / "poses.npy", poses)
    check(tmp_path / "poses.npy", poses)
    (tmp_path / "poses.json").write_text(json.dumps({"poses": poses.tolist()}))
    check(tmp_path / "poses.json", poses)
    (tmp_path / "poses.yaml").write_text(yaml.safe_dump(poses.reshape(-1, 16).tolist()))
    check(tmp_path / "poses.yaml", poses)


def test_six_digits_are_enough(poses, tmp_path):
    path = tmp_path / "poses.txt"
    path.write_text(as_text(poses.reshape(-1, 16), "%.6f"))
    check(path, poses, SIX_DIGITS)
    path.write_text(as_text(as_tum(poses), "%.6f"))
    check(path, poses, 3 * SIX_DIGITS)


def test_hand_eye_lists_are_chained_from_the_base_to_the_camera(poses, tmp_path):
    base, eye = look_at(np.array([0.5, 0.1, 0.2]), np.zeros(3), 0.3), look_at(np.array([0.0, 0.05, 0.1]), np.ones(3))
    hands = np.linalg.inv(base) @ poses @ np.linalg.inv(eye)
    path = tmp_path / "calibration.json"
    ours = {"base_T_gripper": hands.tolist(), "gripper_T_camera": eye.tolist(), "world_T_base": base.tolist()}
    path.write_text(json.dumps(ours))
    check(path, poses)
    opencv = {
        "R_gripper2base": hands[:, :3, :3].tolist(),
        "t_gripper2base": hands[:, :3, 3].tolist(),
        "R_cam2gripper": Rotation.from_matrix(eye[:3, :3]).as_rotvec().tolist(),
        "t_cam2gripper": eye[:3, 3:].tolist(),
        "world_T_base": base.tolist(),
    }
    path.write_text(json.dumps(opencv))
    check(path, poses)


def test_the_frame_of_the_file_can_stand_anywhere(poses, tmp_path):
    frame = look_at(np.array([0.5, 0.1, 0.2]), np.zeros(3))
    np.save(tmp_path / "poses.npy", np.linalg.inv(frame) @ poses)
    found = read_poses(tmp_path / "poses.npy", frame.tolist())
    np.testing.assert_allclose([pose.world_T_camera for pose in found], poses, atol=EXACT)


def _row(**changes: float) -> str:
    values = dict.fromkeys("abcdefghijklmnop", 0.0) | dict.fromkeys("afkp", 1.0) | changes
    return " ".join(f"{value:g}" for value in values.values())


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "expected camera poses, found none"),
        ("1 2 3\n", "line 1: expected 4, 12 or 16 numbers of a matrix, or 8 of a TUM line, found 3 numbers"),
        (f"{_row()}\n\n1 2\n", "line 3: expected 16 numbers, as in the lines before, found 2"),
        ("1 0 0 0\n" * 5, "line 5: expected four rows for each matrix, found 5 rows"),
        (
            f"{_row()}\n{_row(b=0.3)}\n",
            "line 2: expected a rotation, axes at right angles and .*, found .* 0.3",
        ),
        (f"{_row(a=-1)}\n", "line 1: expected a rotation, right-handed, found a mirrored one"),
        (f"{_row(p=2)}\n", "line 1: expected a last row of 0 0 0 1, found 0 0 0 2"),
        (f"{_row(d=400)}\n", "line 1: expected a position in metres, within 100 m, found one 400 away"),
        (f"{_row(d=float('nan'))}\n", "line 1: expected finite numbers"),
        (f"{_row()} x\n", "line 1: expected numbers, found"),
        ("0 0 0 0 0 0 0 2\n", "line 1: expected a quaternion qx qy qz qw of length 1, found one of length 2"),
    ],
    ids=range(11),
)
def test_a_bad_row_is_one_line_with_its_place_and_the_reason(tmp_path, text, says):
    path = tmp_path / "poses.txt"
    path.write_text(text)
    with pytest.raises(InputError, match=says) as error:
        read_poses(path)
    assert str(error.value).startswith(str(path))


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("p.json", b"{", "expected valid JSON"),
        ("p.json", b"{}", r"hand-eye\), found 'nothing'"),
        ("p.json", b'{"poses": 3}', "pose: expected a list, found 3"),
        ("p.json", b"[[1, 2], [3]]", "pose 0: expected a 4x4 matrix, found shape"),
        ("p.json", b'[{"a": 1}]', "pose 0: expected numbers"),
        ("p.json", b'{"R_gripper2base": [], "t_gripper2base": [[0, 0, 0]]}', "expected as many t_gripper2base"),
        ("p.yaml", b"!!python/object/apply:os.getcwd []", "expected valid YAML"),
        ("p.npy", b"no array", "expected a NumPy array of plain numbers"),
        ("p.txt", b"\xff\xfe\x00", "expected poses as text in UTF-8"),
    ],
)
def test_a_file_that_is_none_is_one_line(tmp_path, name, content, says):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=says):
        read_poses(tmp_path / name)


def test_an_array_of_objects_is_never_unpickled(tmp_path):
    np.save(tmp_path / "p.npy", np.array([{"a": 1}], dtype=object))
    with pytest.raises(InputError, match="expected a NumPy array of plain numbers"):
        read_poses(tmp_path / "p.npy")
    np.save(tmp_path / "p.npy", np.zeros((3, 4)))
    with pytest.raises(InputError, match=r"shape \(n, 4, 4\), found float64 of shape \(3, 4\)"):
        read_poses(tmp_path / "p.npy")


def test_a_file_that_is_missing_or_a_folder_is_named(tmp_path):
    with pytest.raises(InputError, match="readable file of camera poses, found none"):
        read_poses(tmp_path / "none.txt")
    with pytest.raises(InputError, match="regular file of camera poses, found a folder"):
        read_poses(tmp_path)
