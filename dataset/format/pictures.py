"""Pictures for people (8-bit sRGB) and id pictures (16 bit), as PNG."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from ...core.errors import InputError
from ...core.silence import quiet


def srgb8(linear: np.ndarray, exposure: float) -> np.ndarray:
    """Return the 8-bit picture of a pinhole camera.

    Radiance times exposure, clipped to [0, 1], through the sRGB curve (IEC 61966-2-1:1999), rounded to 255 steps.

    Parameters
    ----------
    linear : (H, W, 3) float32
        Linear Rec.709 radiance.
    exposure : float
        Factor from radiance to the linear value that sRGB encodes.

    Returns
    -------
    (H, W, 3) uint8
        Red, green, blue.
    """
    value = np.clip(linear.astype(np.float64) * exposure, 0.0, 1.0)
    encoded = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1.0 / 2.4) - 0.055)
    return np.rint(encoded * 255.0).astype(np.uint8)


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
    """Return what `write_png` wrote; InputError where the file is missing or something else."""
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise InputError(path, "a readable PNG file", error.strerror) from error
    # Checked first: OpenCV reads other formats as well, and gives the rest of a picture that is cut short.
    if data[:8].tobytes() != b"\x89PNG\r\n\x1a\n" or data[-8:].tobytes() != b"IEND\xaeB`\x82":
        raise InputError(path, "a whole PNG file", "something else or a part of one")
    try:
        with quiet():
            picture = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    except cv2.error as error:  # its header asks for more pixels than OpenCV reads
        raise InputError(path, "a PNG file of a usual size", "one of too many pixels") from error
    if picture is None or (picture.dtype, picture.ndim) not in ((np.uint8, 3), (np.uint16, 2)):
        raise InputError(path, "a PNG file with 8-bit colour or 16-bit ids", "something else")
    return np.ascontiguousarray(picture[..., ::-1]) if picture.ndim == 3 else picture
