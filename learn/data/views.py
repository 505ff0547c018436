"""One view of a sample: its image and its camera, and the checks of both."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ...core.json_file import check_schema, parsed, read_json
from ...dataset.format import layout
from ...dataset.format.camera_file import CAMERA_SCHEMA, CameraFile, known_K
from ...dataset.reader import Eye, StoredView
from ..networks.settings import SIZE_MULTIPLE

#: Tolerance of R R^T = I: our poses are stored with 16 digits, but those of others often with 6.
RIGID_TOLERANCE = 1e-4
#: Least determinant of K over the cube of its largest element: a camera of 162 degrees has about 1e-2.
MIN_DETERMINANT = 1e-9
#: Greatest absolute value in the matrices of a camera [px, m].
MAX_VALUE = 1e6


@dataclass(frozen=True, eq=False)
class CameraView:
    """An image and its camera."""

    picture: np.ndarray  #: (H, W, 3) uint8, sRGB
    world_T_camera: np.ndarray  #: (4, 4) float64
    K: np.ndarray  #: (3, 3) float64 [px]


def read_camera(view: StoredView) -> CameraFile:
    """Return the camera record of a view; InputError with file and field where it is missing or wrong."""
    path = view.folder / layout.CAMERA
    data = read_json(path)
    check_schema(path, data, CAMERA_SCHEMA)
    record = parsed(CameraFile, data, path)
    check_camera(np.array(known_K(record, path)), record.world_T_camera, path)
    if record.distortion != "none":
        raise InputError(f"{path}: distortion", "none, to which labels belong (a camera that is `rectified`)", "a lens")
    return record


def read_view(view: StoredView, eye: Eye = "left") -> CameraView:
    """Return the image and the camera of a view; InputError with file and field where they cannot be used."""
    record = read_camera(view)
    path = view.folder / f"{eye}.png"
    picture = view.picture(eye)
    if picture.shape != (record.height, record.width, 3):
        raise InputError(path, f"a picture of {record.height} x {record.width} px in colour", picture.shape)
    pose = record.world_T_camera if eye == "left" else record.world_T_right
    if pose is None:
        raise InputError(view.folder / layout.CAMERA, "a stereo pair", "one camera, of a converted data set")
    if eye == "right":
        check_rigid(pose, f"{view.folder / layout.CAMERA}: world_T_right")
    return CameraView(picture, pose, np.array(known_K(record, path)))


def check_camera(K: np.ndarray, world_T_camera: np.ndarray, where: Path | str) -> None:
    """Raise InputError where a pose is not rigid, or an intrinsic matrix is singular or has a wrong last row."""
    for name, matrix in (("world_T_camera", world_T_camera), ("K", K)):
        if not (np.abs(matrix) < MAX_VALUE).all():
            raise InputError(f"{where}: {name}", f"numbers below {MAX_VALUE:g}", np.abs(matrix).max())
    check_rigid(world_T_camera, f"{where}: world_T_camera")
    if K[0, 0] <= 0.0 or K[1, 1] <= 0.0:
        raise InputError(f"{where}: K", "focal lengths above 0", f"{K[0, 0]:g} and {K[1, 1]:g}")
    if (K[2] != (0.0, 0.0, 1.0)).any():
        raise InputError(f"{where}: K", "a last row of 0, 0, 1", K[2].tolist())
    determinant = float(np.linalg.det(K))
    if not abs(determinant) > MIN_DETERMINANT * float(np.abs(K).max()) ** 3:
        raise InputError(f"{where}: K", "a matrix with an inverse", f"the determinant {determinant:.3g}")


def check_rigid(pose: np.ndarray, where: str) -> None:
    """Raise InputError where a pose, (4, 4), is not a rotation and a translation."""
    # By plain numbers: a sample has tens of poses, and calls of NumPy for so few take eight times as long.
    *axes, last = pose.tolist()
    if last != [0.0, 0.0, 0.0, 1.0]:
        raise InputError(where, "a last row of 0, 0, 0, 1", last)
    (a, b, c, _), (d, e, f, _), (g, h, i, _) = axes
    lengths = [a * a + b * b + c * c - 1.0, d * d + e * e + f * f - 1.0, g * g + h * h + i * i - 1.0]
    angles = [a * d + b * e + c * f, a * g + b * h + c * i, d * g + e * h + f * i]
    error = max(abs(one) for one in (*lengths, *angles))
    if not error < RIGID_TOLERANCE or not all(map(isfinite, (*lengths, *angles))):
        raise InputError(where, "a rigid pose", f"rows that are off by {error:.2g}")
    if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0.0:
        raise InputError(where, "a rigid pose", "a reflection")


def check_picture(picture: np.ndarray, where: Path | str) -> None:
    """Raise InputError where an image has one colour only, or a size that networks cannot take."""
    check_sides(picture, where)
    check_colours(picture, where)


def check_sides(picture: np.ndarray, where: Path | str) -> None:
    """Raise InputError where an image has a size that networks cannot take."""
    height, width = picture.shape[:2]
    if height % SIZE_MULTIPLE or width % SIZE_MULTIPLE:
        raise InputError(where, f"a height and a width that are multiples of {SIZE_MULTIPLE} px", f"{height} x {width}")


def check_colours(picture: np.ndarray, where: Path | str) -> None:
    """Raise InputError where an image has one colour only."""
    if (picture == picture[:1, :1]).all():
        raise InputError(where, "a picture", f"nothing but the colour {picture[0, 0].tolist()}")


def check_sizes(views: list[CameraView], where: Path | str) -> None:
    """Raise InputError where views are of different sizes."""
    sizes = {view.picture.shape[:2] for view in views}
    if len(sizes) != 1:
        raise InputError(where, "views of one size", " and ".join(f"{h} x {w} px" for h, w in sorted(sizes)))
