"""Camera poses from a file: 4x4 matrices, TUM trajectories, and the lists of a hand-eye calibration.

A pose is world_T_camera: it takes points of the left camera (OpenCV axes: x right, y down, z forward) to the world,
whose origin is the middle of the table's top, with z up; metres. The formats, by what is in the file:

======================  ================================================================================
text, 16 a row          a 4x4 matrix, row-major; 12 are its first three rows
text, 4 a row           4x4 matrices, four rows each
text, 8 a row           TUM: timestamp tx ty tz qx qy qz qw
``.npy``                an array (n, 4, 4) or (4, 4); pickled objects are refused
``.json``, ``.yaml``    a list of 4x4 matrices, also under the name ``poses``; or hand-eye lists
======================  ================================================================================

Hand-eye lists are ``base_T_gripper``, a list of 4x4 matrices, and ``gripper_T_camera``, one; ``world_T_base`` says
where the robot stands (by default in the world's origin). OpenCV's names for the same, from `calibrateHandEye`, are
``R_gripper2base`` and ``t_gripper2base``, lists, and ``R_cam2gripper`` and ``t_cam2gripper``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from ...core.errors import InputError
from ...core.folders import regular_content
from ...core.setting_errors import shortened
from ...core.yaml_file import yaml_place, yaml_problem

#: Largest file that is read [bytes]: a hundred thousand poses as text.
MAX_SIZE = 1 << 25
#: Largest error of a rotation's products of columns, and of a quaternion's length, that counts as rounding [1]: TUM
#: files have four digits. The nearest rotation is taken; a millimetre a metre away is the most that this moves.
ROUNDING = 1e-3
#: Farthest position [m]: what is farther is in millimetres.
FARTHEST = 100.0
_SEPARATOR = re.compile(r"[\s,;]+")


@dataclass(frozen=True, eq=False)
class FilePose:
    """A pose of a file."""

    where: str  #: the file and the place in it, for error lines
    world_T_camera: np.ndarray  #: (4, 4) float64


def read_poses(path: Path, world_T_file: Sequence[Sequence[float]] | None = None) -> tuple[FilePose, ...]:
    """Return the camera poses of a file, in its order.

    Parameters
    ----------
    path : Path
        The file; its kind follows from its suffix and its content, as the module says.
    world_T_file : (4, 4) float, optional
        Pose of the file's frame in the world; by default they are the same.

    Raises
    ------
    InputError
        Naming the file, the row and the reason: a file that cannot be read or is too large, no poses, a row of another
        length, values that are no finite numbers, a rotation that is none, a position beyond `FARTHEST`.
    """
    size = f"a file of camera poses of at most {MAX_SIZE >> 20} MiB"
    content = regular_content(path, "of camera poses", MAX_SIZE, size)
    kind = path.suffix.lower()
    if kind == ".npy":
        found = _from_array(path, content)
    elif kind in (".json", ".yaml", ".yml"):
        found = _from_data(path, _data(path, content, kind))
    else:
        found = list(_from_text(path, content))
    if not found:
        raise InputError(path, "camera poses", "none")
    frame = np.eye(4)
    if world_T_file is not None:
        frame = _rigid("cameras.world_T_poses", np.array(world_T_file, np.float64))
    return tuple(FilePose(where, frame @ _rigid(where, matrix)) for where, matrix in found)


def _from_array(path: Path, content: bytes) -> list[tuple[str, np.ndarray]]:
    try:
        array = np.load(BytesIO(content))  # objects, which are pickled, are refused by default
    except (ValueError, EOFError, OSError, MemoryError) as error:
        raise InputError(path, "a NumPy array of plain numbers", shortened(str(error))) from error
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "fiu" or array.shape[-2:] != (4, 4):
        shape = f"{array.dtype} of shape {array.shape}" if isinstance(array, np.ndarray) else "an archive"
        raise InputError(path, "an array of numbers of shape (n, 4, 4)", shape)
    matrices = array.astype(np.float64).reshape(-1, 4, 4)
    return [(f"{path}, pose {number}", matrix) for number, matrix in enumerate(matrices)]


def _data(path: Path, content: bytes, kind: str) -> Any:
    try:
        text = content.decode("utf-8")
        return json.loads(text) if kind == ".json" else yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise InputError(yaml_place(path, error), "valid YAML in UTF-8", shortened(yaml_problem(error))) from error
    except (ValueError, RecursionError) as error:
        name = "JSON" if kind == ".json" else "YAML"
        raise InputError(path, f"valid {name} in UTF-8", shortened(" ".join(str(error).split()))) from error


def _from_data(path: Path, data: Any) -> list[tuple[str, np.ndarray]]:
    if isinstance(data, dict) and "poses" not in data:
        return _from_hand_eye(path, data)
    listed = data["poses"] if isinstance(data, dict) else data
    return _matrices(path, "pose", listed)


def _from_hand_eye(path: Path, data: dict) -> list[tuple[str, np.ndarray]]:
    if "R_gripper2base" in data:
        hands = _from_parts(path, data, "gripper2base", "pose")
        hand_T_eye = _from_parts(path, {k: [v] for k, v in data.items()}, "cam2gripper", "R_cam2gripper")[0][1]
    else:
        for name in ("base_T_gripper", "gripper_T_camera"):
            if name not in data:
                expected = "a list of poses, or base_T_gripper and gripper_T_camera (hand-eye)"
                raise InputError(path, expected, shortened(", ".join(map(str, data)) or "nothing"))
        hands = _matrices(path, "base_T_gripper", data["base_T_gripper"])
        hand_T_eye = _matrix(f"{path}, gripper_T_camera", data["gripper_T_camera"])
    base = _matrix(f"{path}, world_T_base", data["world_T_base"]) if "world_T_base" in data else np.eye(4)
    base, hand_T_eye = _rigid(f"{path}, world_T_base", base), _rigid(f"{path}, gripper_T_camera", hand_T_eye)
    return [(where, base @ _rigid(where, hand) @ hand_T_eye) for where, hand in hands]


def _from_parts(path: Path, data: dict, name: str, row: str) -> list[tuple[str, np.ndarray]]:
    """Return poses from OpenCV's two lists: rotations (matrices, or vectors of axis times angle) and translations."""
    rotations, translations = (_listed(path, f"{part}_{name}", data.get(f"{part}_{name}")) for part in "Rt")
    if len(rotations) != len(translations):
        raise InputError(path, f"as many t_{name} as R_{name} ({len(rotations)})", len(translations))
    found = []
    for number, (R, t) in enumerate(zip(rotations, translations, strict=True)):
        where = f"{path}, {row} {number}" if row == "pose" else f"{path}, {row}"
        rotation, matrix = _numbers(where, R), np.eye(4)
        if rotation.size == 3:
            rotation = Rotation.from_rotvec(rotation.reshape(3)).as_matrix()
        if rotation.shape != (3, 3):
            raise InputError(where, "a rotation of 3x3 numbers", f"shape {rotation.shape}")
        shift = _numbers(where, t)
        if shift.size != 3:
            raise InputError(where, "a translation of 3 numbers", f"{shift.size}")
        matrix[:3, :3], matrix[:3, 3] = rotation, shift.reshape(3)
        found.append((where, matrix))
    return found


def _matrices(path: Path, name: str, listed: Any) -> list[tuple[str, np.ndarray]]:
    rows = _listed(path, name, listed)
    return [(f"{path}, {name} {number}", _matrix(f"{path}, {name} {number}", row)) for number, row in enumerate(rows)]


def _listed(path: Path, name: str, value: Any) -> list:
    if not isinstance(value, list):
        raise InputError(f"{path}, {name}", "a list", "none" if value is None else shortened(value))
    return value


def _matrix(where: str, value: Any) -> np.ndarray:
    matrix = _numbers(where, value)
    if matrix.shape not in ((4, 4), (16,)):
        raise InputError(where, "a 4x4 matrix", f"shape {matrix.shape}")
    return matrix.reshape(4, 4)


def _numbers(where: str, value: Any) -> np.ndarray:
    try:
        array = np.array(value, np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(where, "numbers", shortened(value)) from error
    return array


def _from_text(path: Path, content: bytes) -> Iterator[tuple[str, np.ndarray]]:
    rows = list(_rows(path, content))
    count = len(rows[0][1]) if rows else 0
    if rows and count not in (4, 8, 12, 16):
        where = f"{path}, line {rows[0][0]}"
        raise InputError(where, "4, 12 or 16 numbers of a matrix, or 8 of a TUM line", f"{count} numbers")
    for line, values in rows:
        if len(values) != count:
            raise InputError(f"{path}, line {line}", f"{count} numbers, as in the lines before", f"{len(values)}")
    if count == 4 and len(rows) % 4:
        raise InputError(f"{path}, line {rows[-1][0]}", "four rows for each matrix", f"{len(rows)} rows in all")
    step = 4 if count == 4 else 1
    for start in range(0, len(rows), step):
        values = np.array([row for _, row in rows[start : start + step]])
        where = f"{path}, line {rows[start][0]}"
        yield where, _from_tum(where, values[0]) if count == 8 else _filled(values.ravel())


def _rows(path: Path, content: bytes) -> Iterator[tuple[int, list[float]]]:
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(path, "poses as text in UTF-8 (or a suffix .npy, .json or .yaml)", "other bytes") from error
    for number, line in enumerate(text.splitlines(), start=1):
        words = [word for word in _SEPARATOR.split(line.partition("#")[0].strip("[](), \t;")) if word]
        if words:
            try:
                yield number, [float(word.strip("[]()")) for word in words]
            except ValueError as error:
                raise InputError(f"{path}, line {number}", "numbers", shortened(line.strip())) from error


def _filled(values: np.ndarray) -> np.ndarray:
    """Return a 4x4 matrix from its 16 entries, or the first 12 of them."""
    last = [0.0, 0.0, 0.0, 1.0] if len(values) == 12 else []
    return np.concatenate([values, last]).reshape(4, 4)


def _from_tum(where: str, values: np.ndarray) -> np.ndarray:
    quaternion = values[4:]
    norm = float(np.linalg.norm(quaternion))
    if not abs(norm - 1.0) <= ROUNDING:
        raise InputError(where, "a quaternion qx qy qz qw of length 1", f"one of length {norm:.6g}")
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = Rotation.from_quat(quaternion).as_matrix(), values[1:4]
    return matrix


def _rigid(where: str, matrix: np.ndarray) -> np.ndarray:
    """Return the rigid pose nearest to a matrix that is one but for rounding; InputError for any other."""
    if not np.isfinite(matrix).all():
        raise InputError(where, "finite numbers", "nan or inf")
    if np.abs(matrix[3] - [0.0, 0.0, 0.0, 1.0]).max() > 0.0:
        raise InputError(where, "a last row of 0 0 0 1", " ".join(f"{x:g}" for x in matrix[3]))
    error = float(np.abs(matrix[:3, :3].T @ matrix[:3, :3] - np.eye(3)).max())
    if error > ROUNDING:
        expected = "a rotation, axes at right angles and of length 1"
        raise InputError(where, expected, f"them off by {error:.3g}")
    if np.linalg.det(matrix[:3, :3]) < 0.0:
        raise InputError(where, "a rotation, right-handed", "a mirrored one")
    if np.abs(matrix[:3, 3]).max() > FARTHEST:
        farthest = float(np.abs(matrix[:3, 3]).max())
        raise InputError(where, f"a position in metres, within {FARTHEST:g} m", f"one {farthest:g} away")
    u, _, vt = np.linalg.svd(matrix[:3, :3])
    pose = matrix.copy()
    pose[:3, :3] = u @ vt
    return pose
