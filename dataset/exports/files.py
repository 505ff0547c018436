"""Files that exporters have in common: pictures by link or copy, 8-bit masks, JSON on one line."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import cv2
import numpy as np

from ...core.atomic_io import atomic_file, link_or_copy
from ...core.errors import InputError, cause_of
from ..format.pictures import read_png
from .job import Job

#: Quality of JPEG files [1 to 100]: Syn-TODD's released archive has 90.
_QUALITY = 95


def add_picture(job: Job, source: Path, target: Path) -> None:
    """Give a whole PNG file of the data set a second name in the export, or copy it; InputError where it is damaged."""
    if target.exists():
        return
    read_png(source)
    with atomic_file(target) as partial:
        (shutil.copyfile if job.options.copy_pictures else link_or_copy)(source, partial)


def write_grey_png(path: Path, picture: np.ndarray) -> None:
    """Write one channel, (H, W) uint8 or uint16, or a mask, (H, W) bool, as 0 and 255."""
    path.write_bytes(grey_png(picture))


def grey_png(picture: np.ndarray) -> bytes:
    """Return the bytes of such a file."""
    stored = picture.astype(np.uint8) * np.uint8(255) if picture.dtype == bool else picture
    if stored.dtype not in (np.uint8, np.uint16) or stored.ndim != 2:
        raise ValueError(f"expected (H, W) uint8, uint16 or bool, got {picture.shape} {picture.dtype}")
    done, data = cv2.imencode(".png", np.ascontiguousarray(stored))
    if not done:
        raise ValueError("the picture could not be encoded")
    return data.tobytes()


def compact_json(data: object) -> str:
    """Return JSON on one line; floats read back exactly, NaN and infinity are refused."""
    return json.dumps(data, ensure_ascii=False, allow_nan=False)


def whole_png(path: Path) -> bytes:
    """Return the bytes of a PNG file; InputError where it is damaged."""
    read_png(path)
    return read_bytes(path)


def read_bytes(path: Path) -> bytes:
    """Return the bytes of a file; InputError where it cannot be read."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, "a readable file", cause_of(error)) from error


def plain_name(text: str) -> str:
    """Return a name for a file of letters, digits, `-` and `_`, whatever a category is called."""
    return re.sub(r"[^A-Za-z0-9_-]", "_", text) or "_"


def write_jpeg(path: Path, picture: np.ndarray) -> None:
    """Write a picture, (H, W, 3) uint8 sRGB, as JPEG; little is lost, and nothing that a network could see."""
    done, data = cv2.imencode(".jpg", np.ascontiguousarray(picture[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    if not done:
        raise ValueError(f"{path}: the picture could not be encoded")
    path.write_bytes(data.tobytes())
