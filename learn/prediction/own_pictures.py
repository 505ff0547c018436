"""Pictures of a user's own, and their cameras: in a JSON file beside each, or in the `camera.json` of their folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ...core.errors import InputError, cause_of
from ...core.json_file import check_schema, parsed, read_json
from ...core.setting_errors import shortened
from ...core.silence import quiet
from ...dataset.cameras.lens import check_distortion
from ...dataset.cameras.model import Distortion
from ...dataset.format import layout
from ...dataset.format.camera_file import CAMERA_SCHEMA, CameraFile, known_K
from ..data.views import MAX_VALUE, CameraView, check_camera

#: Numbers of coefficients that are read, in OpenCV's order: k1, k2, p1, p2, and k3.
_COEFFICIENTS = (0, 4, 5)


@dataclass(frozen=True, eq=False)
class OwnPicture:
    """A picture as a camera took it."""

    picture: np.ndarray  #: (H, W, 3) uint8, sRGB
    world_T_camera: np.ndarray  #: (4, 4) float64
    K: np.ndarray  #: (3, 3) float64 [px]
    distortion: Distortion  #: of its lens

    @property
    def size(self) -> tuple[int, int]:
        """Height and width [px]."""
        return self.picture.shape[0], self.picture.shape[1]

    @property
    def view(self) -> CameraView:
        """The picture with its pinhole camera, as if the lens did not distort."""
        return CameraView(self.picture, self.world_T_camera, self.K)


def read_picture(path: Path) -> np.ndarray:
    """Read a picture, PNG or JPEG, as (H, W, 3) uint8; InputError where it cannot be read."""
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise InputError(path, "a readable picture", cause_of(error)) from error
    # Cameras refer to pixels as stored, so the orientation tag of a JPEG is ignored.
    how = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        with quiet():
            picture = cv2.imdecode(data, how) if data.size else None
    except cv2.error as error:
        raise InputError(path, "a PNG or JPEG picture", "one of too many pixels") from error
    if picture is None:
        raise InputError(path, "a PNG or JPEG picture", "something else")
    return np.ascontiguousarray(picture[..., ::-1])


def read_own_picture(path: Path) -> OwnPicture:
    """Read a picture and its camera.

    The camera is in a JSON file with the name of the picture (``a.png``: ``a.json``) with ``K``, ``world_T_camera`` and
    perhaps ``distortion`` as in ``camera.json``, or in the ``camera.json`` of the same folder, whose right camera
    belongs to ``right.png``.
    """
    picture, camera = read_picture(path), path.with_suffix(".json")
    own = camera.is_file() and camera.name != layout.CAMERA
    found = _with_own_camera(picture, camera) if own else _with_stored_camera(picture, path)
    return checked_lens(found, camera)


def checked_lens(found: OwnPicture, where: Path | str) -> OwnPicture:
    """Return a picture; InputError where its lens folds over inside it, so that no pixel grid can be undistorted."""
    height, width = found.size
    optics = (found.K[0, 0], found.K[1, 1], found.K[0, 2], found.K[1, 2])
    check_distortion(found.distortion, optics, width, height, str(where))
    return found


def lens_of(value: Any, where: str) -> Distortion:
    """Return the distortion that a JSON file states: ``none``, 4 or 5 coefficients, or these by name."""
    if value in (None, "none"):
        return Distortion()
    if isinstance(value, dict):
        return parsed(Distortion, value, Path(where))
    are_numbers = isinstance(value, list | tuple) and all(
        type(one) in (int, float) and abs(one) < MAX_VALUE for one in value
    )
    if not are_numbers or len(value) not in _COEFFICIENTS:
        raise InputError(where, "4 or 5 coefficients in OpenCV's order: k1, k2, p1, p2, k3", shortened(value))
    k1, k2, p1, p2, k3 = [float(one) for one in [*value, *[0.0] * 5][:5]]
    return Distortion.of((k1, k2, p1, p2, k3))


def _with_own_camera(picture: np.ndarray, path: Path) -> OwnPicture:
    record = read_json(path)
    matrices = []
    for name, shape in (("K", (3, 3)), ("world_T_camera", (4, 4))):
        value = record.get(name) if isinstance(record, dict) else None
        if not _is_matrix(value, shape):
            raise InputError(f"{path}: {name}", f"{shape[0]} rows of {shape[1]} finite numbers", shortened(value))
        matrices.append(np.array(value, np.float64))
    K, pose = matrices
    check_camera(K, pose, path)
    return OwnPicture(picture, pose, K, lens_of(record.get("distortion"), f"{path}: distortion"))


def _is_matrix(value: Any, shape: tuple[int, int]) -> bool:
    rows, columns = shape
    return (
        isinstance(value, list)
        and [len(row) if isinstance(row, list) else -1 for row in value] == [columns] * rows
        and all(type(number) in (int, float) and abs(number) < MAX_VALUE for row in value for number in row)
    )


def _with_stored_camera(picture: np.ndarray, path: Path) -> OwnPicture:
    camera = path.with_name(layout.CAMERA)
    if not camera.is_file():
        beside = f"its camera in {path.with_suffix('.json').name} or {layout.CAMERA}, or --camera"
        raise InputError(path, beside, "neither")
    data = read_json(camera)
    check_schema(camera, data, CAMERA_SCHEMA)
    record = parsed(CameraFile, data, camera)
    if picture.shape[:2] != (record.height, record.width):
        expected = f"a picture of {record.width} x {record.height} px, as {camera.name} says"
        raise InputError(path, expected, f"{picture.shape[1]} x {picture.shape[0]} px")
    pose = record.world_T_right if path.stem == "right" else record.world_T_camera
    if pose is None:
        raise InputError(f"{camera}: world_T_right", "the pose of the right camera", "null")
    K = np.array(known_K(record, camera))
    check_camera(K, pose, camera)
    lens = Distortion() if record.distortion == "none" else record.distortion
    return OwnPicture(picture, pose, K, lens)
