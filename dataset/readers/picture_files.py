"""Pictures and maps of other projects' data sets: colour, grey levels, palette indices, depth in PNG and EXR."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from ...core.errors import InputError, cause_of
from ...core.picture_size import PNG_SIGNATURE
from ...core.silence import quiet
from ..format.exr import read_exr

_PNG_END = b"IEND\xaeB`\x82"
_JPEG, _JPEG_END = b"\xff\xd8", b"\xff\xd9"
#: Bytes after a JPEG's end marker that some cameras write [bytes].
_JPEG_TAIL = 64
#: Channels in which projects store depth, the one that is read first: KeyPose writes D in most files and R in some,
#: ClearGrasp three equal channels, TODD R, Syn-TODD G.
DEPTH_CHANNELS = ("D", "Z", "depth.Z", "R", "G", "Y", "V")


def read_colour(path: Path) -> np.ndarray:
    """Return a picture in colour, (H, W, 3) uint8 red, green, blue; InputError where it is missing or damaged."""
    return colour_of(read_bytes(path), path)


def colour_of(content: bytes, where: object) -> np.ndarray:
    """Return the picture in the bytes of a PNG, JPEG or TIFF file, (H, W, 3) uint8; grey ones in three channels."""
    picture = _decoded(content, where, cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    return np.ascontiguousarray(picture[..., ::-1])


def read_levels(path: Path) -> np.ndarray:
    """Return the numbers of a picture with one channel, (H, W) uint8 or uint16; the first of several equal ones."""
    return levels_of(read_bytes(path), path)


def levels_of(content: bytes, where: object) -> np.ndarray:
    """Return the numbers in the bytes of a picture with one channel, (H, W) uint8 or uint16."""
    values = _decoded(content, where, cv2.IMREAD_UNCHANGED)
    if values.ndim == 3:
        if (values[..., :3] != values[..., :1]).any():
            raise InputError(where, "one channel, or equal ones", "a picture in colour")
        values = values[..., 0]
    if values.dtype not in (np.uint8, np.uint16):
        raise InputError(where, "8 or 16 bits", values.dtype)
    return np.ascontiguousarray(values)


def read_indices(path: Path, count: int) -> np.ndarray:
    """Return the palette indices of a PNG file, (H, W) uint16, or its grey levels where it has no palette.

    Parameters
    ----------
    path : Path
        The file.
    count : int
        Number of indices that can occur; their colours have to differ.
    """
    content = read_bytes(path)
    palette = _palette(content)
    if palette is None:
        return read_levels(path).astype(np.uint16)
    wanted = palette[:count].astype(np.int64)
    codes = (wanted[:, 0] << 16) | (wanted[:, 1] << 8) | wanted[:, 2]
    if len(set(codes.tolist())) < len(codes):
        raise InputError(path, f"a palette with {count} different colours", "two equal ones")
    # OpenCV expands palettes, and gives no index. Each colour of the palette stands for one.
    colours = colour_of(content, path).astype(np.int64)
    pixels = (colours[..., 0] << 16) | (colours[..., 1] << 8) | colours[..., 2]
    order = np.argsort(codes)
    place = np.minimum(np.searchsorted(codes[order], pixels), len(codes) - 1)
    found = order[place]
    if (codes[found] != pixels).any():
        raise InputError(path, f"palette indices 0 to {count - 1}", "others")
    return found.astype(np.uint16)


def read_depth_png(path: Path, per_metre: float) -> np.ndarray:
    """Return the depth of a 16-bit picture, (H, W) float32 [m]; NaN where it stores 0, which is no measurement."""
    return metres(read_levels(path), per_metre)


def metres(levels: np.ndarray, per_metre: float) -> np.ndarray:
    """Return depth of whole numbers, (H, W) float32 [m]; NaN where they are 0."""
    return np.where(levels > 0, levels / per_metre, np.nan).astype(np.float32)


def read_depth_exr(path: Path) -> np.ndarray:
    """Return the depth of an EXR file, (H, W) float32 [m]; NaN where it stores 0, NaN, infinity or a negative one."""
    channels = read_exr(path)
    name = next((name for name in DEPTH_CHANNELS if name in channels), None)
    if name is None:
        raise InputError(path, f"depth in one of the channels {', '.join(DEPTH_CHANNELS)}", ", ".join(sorted(channels)))
    return known_depth(channels[name])


def known_depth(Z: np.ndarray) -> np.ndarray:
    """Return depth as float32 with NaN for every code of "unknown": 0, negative numbers, NaN and infinity."""
    Z = Z.astype(np.float32)
    with np.errstate(invalid="ignore"):
        return np.where(np.isfinite(Z) & (Z > 0.0), Z, np.float32(np.nan))


def read_normals_exr(path: Path) -> np.ndarray:
    """Return the normals of an EXR file with OpenGL's axes in OpenCV's, (H, W, 3) float32.

    Stored are x right, y up, z towards the camera; NaN where the vector has not about unit length, as (-1, -1, -1).
    """
    channels = read_exr(path)
    missing = [name for name in "RGB" if name not in channels]
    if missing:
        raise InputError(path, "normals in the channels R, G, B", ", ".join(sorted(channels)))
    normals = np.stack([channels[name].astype(np.float32) for name in "RGB"], axis=-1) * np.array(
        [1, -1, -1], np.float32
    )
    length = np.linalg.norm(normals, axis=-1)
    return np.where((np.abs(length - 1.0) < 0.05)[..., None], normals, np.float32(np.nan))


def read_bytes(path: Path) -> bytes:
    """Return the bytes of a file; InputError where it cannot be read."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, "a readable file", cause_of(error)) from error


def first_of(folder: Path, names: Sequence[str]) -> Path | None:
    """Return the first of some files that a folder has; None where it has none."""
    return next((folder / name for name in names if (folder / name).is_file()), None)


def _decoded(content: bytes, where: object, mode: int) -> np.ndarray:
    # Checked first: OpenCV returns the readable part of a file that is cut short.
    if content.startswith(PNG_SIGNATURE) and not content.endswith(_PNG_END):
        raise InputError(where, "a whole PNG file", "a part of one")
    if content.startswith(_JPEG) and _JPEG_END not in content[-_JPEG_TAIL:]:
        raise InputError(where, "a whole JPEG file", "a part of one")
    if not content:
        raise InputError(where, "a picture", "an empty file")
    try:
        with quiet():
            picture = cv2.imdecode(np.frombuffer(content, np.uint8), mode)
    except cv2.error as error:
        raise InputError(where, "a picture of a usual size", "one of too many pixels") from error
    if picture is None:
        raise InputError(where, "a picture", "something else or a damaged one")
    return picture


def _palette(content: bytes) -> np.ndarray | None:
    """Return the palette of a PNG file, (n, 3) uint8; None where it has none (PNG specification, 11.2.2)."""
    at = len(PNG_SIGNATURE)
    while content.startswith(PNG_SIGNATURE) and at + 8 <= len(content):
        length, kind = int.from_bytes(content[at : at + 4], "big"), content[at + 4 : at + 8]
        if kind == b"IHDR" and content[at + 17] != 3:  # the colour type; 3 has a palette
            return None
        if kind == b"PLTE":
            data = content[at + 8 : at + 8 + length]
            return np.frombuffer(data[: len(data) // 3 * 3], np.uint8).reshape(-1, 3)
        at += 12 + length
    return None
