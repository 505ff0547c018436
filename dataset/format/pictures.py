"""PNG files: 8-bit sRGB pictures and 16-bit instance ids."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from ...core.errors import InputError, cause_of
from ...core.silence import quiet


def write_png(path: Path, picture: np.ndarray) -> None:
    """Write (H, W, 3) uint8 red, green, blue, or (H, W) uint16 ids."""
    if (picture.dtype, picture.ndim) not in ((np.uint8, 3), (np.uint16, 2)):
        raise ValueError(f"{path}: expected (H, W, 3) uint8 or (H, W) uint16, got {picture.shape} {picture.dtype}")
    stored = picture[..., ::-1] if picture.ndim == 3 else picture
    done, data = cv2.imencode(".png", np.ascontiguousarray(stored))
    if not done:
        raise ValueError(f"{path}: the picture could not be encoded")
    path.write_bytes(data.tobytes())


def read_png(path: Path) -> np.ndarray:
    """Read a file of `write_png`; InputError where it is missing or anything else."""
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise InputError(path, "a readable PNG file", cause_of(error)) from error
    # Checked first: OpenCV also reads other formats, and returns the readable part of a truncated picture.
    if data[:8].tobytes() != b"\x89PNG\r\n\x1a\n" or data[-8:].tobytes() != b"IEND\xaeB`\x82":
        raise InputError(path, "a whole PNG file", "something else or a part of one")
    try:
        with quiet():
            picture = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    except cv2.error as error:  # the header states more pixels than OpenCV accepts
        raise InputError(path, "a PNG file of a usual size", "one of too many pixels") from error
    if picture is None or (picture.dtype, picture.ndim) not in ((np.uint8, 3), (np.uint16, 2)):
        raise InputError(path, "a PNG file with 8-bit colour or 16-bit ids", "something else")
    return np.ascontiguousarray(picture[..., ::-1]) if picture.ndim == 3 else picture
