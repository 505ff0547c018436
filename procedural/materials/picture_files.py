"""Pictures from files: as colours, and as numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import cv2
import numpy as np

from ...core.assets import check_content
from ...core.errors import InputError, cause_of
from ...core.exr_picture import read_exr_picture
from ...core.picture_size import picture_size
from ...core.silence import quiet
from ...core.tga_picture import read_tga, tga_size

#: Formats that OpenCV's wheel reads on every platform and that have 8 or 16 bits per channel.
PICTURE_SUFFIXES = (".bmp", ".jpeg", ".jpg", ".png", ".tga", ".tif", ".tiff", ".webp")
#: Widest and highest picture that is read [px]: the largest that Poly Haven and ambientCG have; 16384 x 16384 pixels
#: take 0.8 to 1.6 GB while they are decoded.
MOST_PIXELS = 16384
#: Longest side of a texture [px]. A prop or a table fills a view of at most a few thousand pixels; 4096 is 200 MB.
LONGEST_SIDE = 4096


def read_picture(path: Path) -> np.ndarray:
    """Return a picture as linear reflectances, first row at the top: sRGB, or linear where it holds floats.

    Grey becomes three equal channels, transparency is ignored, and pictures larger than `LONGEST_SIDE` are reduced.

    Returns
    -------
    (h, w, 3) float32
        In [0, 1], linear Rec.709.

    Raises
    ------
    InputError
        If the file is missing, broken or too large, or does not have 8, 16 or 32 bits (floats) per channel.
    """
    stored = _three_channels(path)
    # Pictures of floats (EXR, some TIFF) hold linear values.
    linear = srgb_to_linear(_numbers(stored)) if stored.dtype.kind == "u" else _numbers(stored)
    height, width = linear.shape[:2]
    if max(height, width) > LONGEST_SIDE:
        scale = LONGEST_SIDE / max(height, width)
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        linear = cv2.resize(linear, size, interpolation=cv2.INTER_AREA)
    return np.clip(linear, 0.0, 1.0)


def read_numbers(path: Path) -> np.ndarray:
    """Return a picture of numbers, such as roughness, normals or heights: as stored, without sRGB's curve.

    Returns
    -------
    (h, w, 3) float32
        Red, green, blue in [0, 1], first row at the top; grey becomes three equal channels.

    Raises
    ------
    InputError
        As for `read_picture`.
    """
    return np.clip(_numbers(_three_channels(path)), 0.0, 1.0)


def check_picture(path: Path) -> None:
    """Decode a picture once; InputError where `read_picture` would raise it."""
    _three_channels(path)


def _numbers(stored: np.ndarray) -> np.ndarray:
    """Return 8 or 16 bits per channel as float32 in [0, 1], and floats as they are; no NaN."""
    if stored.dtype.kind == "u":
        return stored.astype(np.float32) / np.iinfo(stored.dtype).max
    return np.nan_to_num(stored.astype(np.float32), nan=0.0, posinf=1.0, neginf=0.0)


def _three_channels(path: Path) -> np.ndarray:
    """Return a picture's red, green and blue as stored, (h, w, 3)."""
    if path.suffix.lower() == ".exr":
        return read_exr_picture(path, lambda width, height: _check_size(path, width, height))
    stored = _decoded(path)
    if stored.dtype not in (np.uint8, np.uint16, np.float32):
        raise InputError(path, "a picture of 8, 16 or (floats) 32 bits per channel", f"{stored.dtype}")
    if stored.ndim == 2 or stored.shape[2] < 3:
        # Grey, or grey with transparency.
        grey = stored if stored.ndim == 2 else stored[..., 0]
        return np.repeat(grey[..., None], 3, axis=2)
    return stored[..., 2::-1]


def _check_size(path: Path, width: int, height: int) -> None:
    """Raise InputError for a picture of too many pixels, before they are decoded."""
    if not (0 < width <= MOST_PIXELS and 0 < height <= MOST_PIXELS):
        raise InputError(path, f"a picture of 1 to {MOST_PIXELS} pixels a side", f"{width} x {height}")


def srgb_to_linear(encoded: np.ndarray) -> np.ndarray:
    """Return linear values of sRGB-encoded ones in [0, 1] (IEC 61966-2-1:1999)."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4).astype(encoded.dtype)


def _decoded(path: Path) -> np.ndarray:
    try:
        content = path.read_bytes()
        check_content(path, content)
        is_tga = path.suffix.lower() == ".tga"
        size = tga_size(content) if is_tga else picture_size(content)
        if size is not None:
            _check_size(path, *size)
        if is_tga:
            return _tga(path, content)
        with quiet():
            picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    except OSError as error:
        raise InputError(path, "a readable picture", cause_of(error)) from error
    except cv2.error as error:
        raise InputError(path, "a readable picture", "an empty or oversized file") from error
    if picture is None:
        raise InputError(path, "a readable picture", "a broken file")
    return picture


def read_opacity(path: Path, channel: Literal["alpha", "grey"]) -> np.ndarray | None:
    """Return the opacity that a picture states, (h, w) float32 in [0, 1]; None where it has no such channel.

    Parameters
    ----------
    path : Path
        The picture; InputError where it cannot be read.
    channel : str
        ``"alpha"`` is the picture's own transparency; ``"grey"`` its first channel, as pictures of opacity have it.
    """
    stored = _decoded(path)
    stored = stored[..., None] if stored.ndim == 2 else stored
    if channel == "alpha" and stored.shape[2] not in (2, 4):
        return None
    most = np.iinfo(stored.dtype).max if stored.dtype.kind == "u" else 1.0
    # Blue, green, red: the first channel is the third one.
    place = -1 if channel == "alpha" else min(2, stored.shape[2] - 1)
    return stored[..., place].astype(np.float32) / most


def _tga(path: Path, content: bytes) -> np.ndarray:
    try:
        return read_tga(content)
    except ValueError as error:
        raise InputError(path, "a readable picture", "a broken file") from error
