"""Pictures from a user's folder: listing and reading them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Literal

import cv2
import numpy as np

from ...core.errors import InputError, cause_of
from ...core.folders import files_in
from ...core.silence import quiet
from ...core.tga_picture import read_tga

#: Formats that OpenCV's wheel reads on every platform and that have 8 or 16 bits per channel.
PICTURE_SUFFIXES = (".bmp", ".jpeg", ".jpg", ".png", ".tga", ".tif", ".tiff", ".webp")
#: Longest side of a texture [px]. A prop or a table fills a view of at most a few thousand pixels; 4096 is 200 MB.
LONGEST_SIDE = 4096


def picture_files(folder: Path) -> tuple[Path, ...]:
    """Return the pictures under a folder, ordered by their relative paths.

    Raises
    ------
    InputError
        If the folder is missing, has no picture, or has a file with the suffix of a picture that is not one.
    """
    files = files_in(folder, "pictures", PICTURE_SUFFIXES, below=True)
    for path in files:
        if not cv2.haveImageReader(str(path)):
            raise InputError(path, "a picture", "something else")
    return files


def read_picture(path: Path) -> np.ndarray:
    """Return an sRGB picture as linear reflectances, first row at the top.

    Grey becomes three equal channels, transparency is ignored, and pictures larger than `LONGEST_SIDE` are reduced.

    Returns
    -------
    (h, w, 3) float32
        In [0, 1], linear Rec.709.

    Raises
    ------
    InputError
        If the file is missing or broken, or does not have 8 or 16 bits per channel.
    """
    stored = _decoded(path)
    if stored.dtype not in (np.uint8, np.uint16):
        raise InputError(path, "a picture of 8 or 16 bits per channel", f"{stored.dtype}")
    if stored.ndim == 2 or stored.shape[2] < 3:
        # Grey, or grey with transparency.
        grey = stored if stored.ndim == 2 else stored[..., 0]
        stored = np.repeat(grey[..., None], 3, axis=2)
    encoded = stored[..., 2::-1].astype(np.float32) / np.iinfo(stored.dtype).max
    linear = srgb_to_linear(encoded)
    height, width = linear.shape[:2]
    if max(height, width) > LONGEST_SIDE:
        scale = LONGEST_SIDE / max(height, width)
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        linear = cv2.resize(linear, size, interpolation=cv2.INTER_AREA)
    return np.clip(linear, 0.0, 1.0)


def check_pictures(files: Iterable[Path]) -> None:
    """Read every picture once, to refuse a bad one before any scene is drawn; InputError names the file."""
    for path in files:
        read_picture(path)


def srgb_to_linear(encoded: np.ndarray) -> np.ndarray:
    """Return linear values of sRGB-encoded ones in [0, 1] (IEC 61966-2-1:1999)."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4).astype(encoded.dtype)


def _decoded(path: Path) -> np.ndarray:
    try:
        content = np.frombuffer(path.read_bytes(), np.uint8)
        if path.suffix.lower() == ".tga":
            return _tga(path, content.tobytes())
        with quiet():
            picture = cv2.imdecode(content, cv2.IMREAD_UNCHANGED)
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
