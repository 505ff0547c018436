"""PNG files: 8-bit sRGB pictures, also of radiance, and 16-bit instance ids."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from ...core.arguments import as_path, check_type, described, number
from ...core.errors import InputError, cause_of
from ...core.images import LINEAR, srgb8
from ...core.picture_size import PNG_SIGNATURE
from ...core.silence import quiet
from ...render.frame import Frame

#: Linear value of the first step of an 8-bit sRGB picture: 1/255 on the line of slope 12.92 (IEC 61966-2-1:1999).
_FIRST_STEP = 1.0 / (255.0 * 12.92)


def write_png(path: Path, picture: np.ndarray) -> None:
    """Write (H, W, 3) uint8 red, green, blue, or (H, W) uint16 ids."""
    if (picture.dtype, picture.ndim) not in ((np.uint8, 3), (np.uint16, 2)):
        raise ValueError(f"{path}: expected (H, W, 3) uint8 or (H, W) uint16, got {picture.shape} {picture.dtype}")
    stored = np.ascontiguousarray(picture)
    turned = cv2.cvtColor(stored, cv2.COLOR_RGB2BGR) if picture.ndim == 3 else stored
    done, data = cv2.imencode(".png", turned, _COLOURS if picture.ndim == 3 else _RUNS if _mostly_runs(picture) else ())
    if not done:
        raise ValueError(f"{path}: the picture could not be encoded")
    path.write_bytes(data.tobytes())


#: How pixels are packed: colours as differences of neighbours without a search for repetitions, which noise does not
#: have (2 % larger, 6 % faster to read); maps of ids without differences (read in a quarter of the time).
_COLOURS = (cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY)
_RUNS = (cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_NONE, cv2.IMWRITE_PNG_COMPRESSION, 1)


def _mostly_runs(picture: np.ndarray) -> bool:
    """Return whether nine pixels of ten are those to their left, as in maps of ids, classes and bits."""
    return bool(np.count_nonzero(picture[:, 1:] == picture[:, :-1]) > 0.9 * picture.size)


def save_png(path: Path | str, picture: Frame | np.ndarray, exposure: float = 1.0) -> None:
    """Write a picture as an 8-bit sRGB file, with the exposure of its camera.

    Parameters
    ----------
    path : Path or str
        The file to write; one that is there is replaced.
    picture : Frame or ndarray
        A rendered view (its left picture), radiance (H, W, 3) float, linear Rec.709, or a finished picture (H, W, 3)
        uint8.
    exposure : float
        Factor on radiance, such as `Camera.exposure`; a frame has its own.

    Raises
    ------
    InputError
        For anything else than a picture, an exposure that is not positive, or a file that cannot be written.
    """
    path, tone = as_path("save_png: path", path), LINEAR
    if isinstance(picture, Frame):
        number("save_png: exposure", exposure, np.finfo(float).tiny, np.finfo(float).max)
        picture, exposure, tone = picture.left, picture.exposure * exposure, picture.tone
    check_type("save_png: picture", picture, np.ndarray, "a Frame, or an array of shape (H, W, 3)")
    if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype.kind not in "fu" or picture.size == 0:
        raise InputError("save_png: picture", "radiance or 8-bit colours of shape (H, W, 3)", described(picture))
    if picture.dtype != np.uint8:
        number("save_png: exposure", exposure, np.finfo(float).tiny, np.finfo(float).max)
        picture = srgb8(picture.astype(np.float32), exposure, tone)
    try:
        write_png(path, picture)
    except OSError as error:
        raise InputError(path, "a file that can be written", cause_of(error)) from error


def stored_radiance(radiance: np.ndarray, exposure: float) -> np.ndarray:
    """Return radiance as it is written: half floats, or float32 where these would lose more than rounding to 11 bits.

    Parameters
    ----------
    radiance : (H, W, 3) float32
        Linear Rec.709 radiance.
    exposure : float
        Factor from radiance to the linear value that sRGB encodes: it says what is black.

    Returns
    -------
    (H, W, 3) float16 or float32
        Float32 where a value is beyond the largest half, or the first step of an 8-bit picture below the smallest one
        of 11 bits.
    """
    half = np.finfo(np.float16)
    fits = float(np.abs(radiance).max(initial=0.0)) <= float(half.max) and _FIRST_STEP / exposure >= float(half.tiny)
    return radiance.astype(np.float16) if fits else radiance


def read_png(path: Path) -> np.ndarray:
    """Read a file of `write_png`; InputError where it is missing or anything else."""
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise InputError(path, "a readable PNG file", cause_of(error)) from error
    # Checked first: OpenCV also reads other formats, and returns the readable part of a truncated picture.
    if data[:8].tobytes() != PNG_SIGNATURE or data[-8:].tobytes() != b"IEND\xaeB`\x82":
        raise InputError(path, "a whole PNG file", "something else or a part of one")
    colour = data[24:26].tolist() == [8, 2]  # of the header (PNG, 11.2.2): bits of a channel, red, green and blue
    kind = cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION if colour else cv2.IMREAD_UNCHANGED
    try:
        with quiet():
            picture = cv2.imdecode(data, kind)
    except cv2.error as error:  # the header states more pixels than OpenCV accepts
        raise InputError(path, "a PNG file of a usual size", "one of too many pixels") from error
    if picture is None or not (colour or (picture.dtype, picture.ndim) == (np.uint16, 2)):
        raise InputError(path, "a PNG file with 8-bit colour or 16-bit ids", "something else")
    return picture
