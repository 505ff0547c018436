"""Radiance pictures (``.hdr``, ``.pic``) in all their dialects.

"Radiance File Formats" (G. Ward, radsite.lbl.gov) has the format: any order of rows and columns, pixels one by one or
in runs of the old or the new kind, RGB or XYZ, and exposures that the pixels are multiplied with. OpenCV decodes the
new runs of pictures that begin at the upper left; everything else is brought to that form, or decoded here.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from ...core.assets import check_content
from ...core.errors import InputError, cause_of
from ...core.silence import quiet

#: First bytes of a Radiance picture; the program's name differs.
HDR_MAGIC = b"#?"
# The empty line that ends the header, and the line of the picture's size.
_SIZE = re.compile(rb"\r?\n\r?\n([+-][XY]) ([0-9]{1,9}) ([+-][XY]) ([0-9]{1,9})\r?\n")
#: Longest header [bytes]; the search for its end stops here.
_LONGEST_HEADER = 1 << 16
_PLAIN = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n"
#: CIE XYZ (equal-energy white, as Radiance has it) to linear Rec.709 (IEC 61966-2-1:1999), rows R, G, B.
_RGB_OF_XYZ = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]], np.float32)
#: Widths that the new runs may have [px]; other rows are stored in the old form.
_NEW_RUNS = (8, 0x7FFF)


def read_radiance_picture(path: Path, check_size: Callable[[int, int], None]) -> np.ndarray:
    """Return the picture in a Radiance file.

    Parameters
    ----------
    path : Path
        The file.
    check_size : callable
        Is called with width and height before any pixel is read, and raises for those that are too large.

    Returns
    -------
    (h, w, 3) float32
        Linear Rec.709, first row at the top, first column on the left; exposures in the header are undone.

    Raises
    ------
    InputError
        If the file is something else, or damaged.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(path, "a readable Radiance HDR file", cause_of(error)) from error
    check_content(path, content)
    if not content.startswith(HDR_MAGIC):
        found = f"first bytes {content[:8]!r}" if content else "an empty file"
        raise InputError(path, "a Radiance HDR file", found)
    size = _SIZE.search(content, 0, _LONGEST_HEADER)
    if size is None or size[1][1:] == size[3][1:]:
        raise InputError(path, "a Radiance HDR file", "a damaged header")
    header, body = content[: size.start()], content[size.end() :]
    rows, columns = int(size[2]), int(size[4])
    check_size(*((columns, rows) if size[1][1:] == b"Y" else (rows, columns)))
    pixels = _oriented(_decoded(path, body, rows, columns), size[1], size[3])
    if _value(header, b"FORMAT") == b"32-bit_rle_xyze":
        pixels = pixels @ _RGB_OF_XYZ.T
    return np.ascontiguousarray(pixels / _exposure(path, header), np.float32)


def _value(header: bytes, name: bytes) -> bytes:
    """Return the last value of a name in the header, or b''."""
    lines = [line.strip() for line in header.splitlines()]
    values = [line.partition(b"=")[2].strip() for line in lines if line.partition(b"=")[0].strip() == name]
    return values[-1] if values else b""


def _exposure(path: Path, header: bytes) -> np.ndarray:
    """Return what the radiance was multiplied with, (3,) float32: the product of all exposures and corrections."""
    factor = np.ones(3, np.float64)
    for line in header.splitlines():
        name, _, text = line.partition(b"=")
        if name.strip() not in (b"EXPOSURE", b"COLORCORR"):
            continue
        try:
            factor *= [float(part) for part in text.split()]
        except ValueError as error:
            raise InputError(path, f"numbers as {name.decode()}", ascii(text[:40])) from error
    if not (np.isfinite(factor).all() and (factor > 0.0).all()):
        raise InputError(path, "exposures above 0", factor.tolist())
    return factor.astype(np.float32)


def _decoded(path: Path, body: bytes, rows: int, columns: int) -> np.ndarray:
    """Return the pixels in the order of the file, (rows, columns, 3) float32."""
    if _NEW_RUNS[0] <= columns <= _NEW_RUNS[1] and body[:4] == bytes([2, 2, columns >> 8, columns & 255]):
        content = np.frombuffer(_PLAIN % (rows, columns) + body, np.uint8)
        try:
            with quiet():
                pixels = cv2.imdecode(content, cv2.IMREAD_UNCHANGED)
        except cv2.error:
            pixels = None
        if pixels is None or pixels.dtype != np.float32 or pixels.shape != (rows, columns, 3):
            raise InputError(path, "a whole Radiance HDR file", "a damaged one")
        return pixels[..., ::-1]
    return _radiance(_old_runs(path, body, rows * columns)).reshape(rows, columns, 3)


def _old_runs(path: Path, body: bytes, count: int) -> np.ndarray:
    """Return pixels that are stored one by one or in old runs, (count, 4) uint8.

    A quadruple (1, 1, 1, n) repeats the pixel before it n times; in several such in a row each n counts 256 times as
    much as the one before.
    """
    stored = np.frombuffer(body[: len(body) // 4 * 4], np.uint8).reshape(-1, 4)
    is_run = (stored[:, :3] == 1).all(axis=1)
    if not len(stored) or is_run[0]:
        raise InputError(path, "a whole Radiance HDR file", "a damaged one")
    places = np.arange(len(stored))
    # The place within a row of such quadruples: how many come directly before.
    last_pixel = np.maximum.accumulate(np.where(is_run, -1, places))
    shift = np.where(is_run, places - last_pixel - 1, 0)
    times = np.where(is_run, stored[:, 3].astype(np.int64) << (8 * np.minimum(shift, 4)), 1)
    ends = np.cumsum(np.minimum(times, count))
    needed = int(np.searchsorted(ends, count)) + 1
    if needed > len(stored):
        raise InputError(path, "a whole Radiance HDR file", "a damaged one")
    return np.repeat(stored[last_pixel[:needed]], np.minimum(times[:needed], count), axis=0)[:count]


def _radiance(stored: np.ndarray) -> np.ndarray:
    """Return shared-exponent pixels, (n, 4) uint8, as (n, 3) float32; mantissas of 8 bits, as OpenCV takes them."""
    scale = np.ldexp(np.float32(1.0), stored[:, 3].astype(np.int32) - (128 + 8)).astype(np.float32)
    return np.where(stored[:, 3:] > 0, stored[:, :3] * scale[:, None], np.float32(0.0))


def _oriented(pixels: np.ndarray, first: bytes, second: bytes) -> np.ndarray:
    """Return pixels with rows from the top and columns from the left; the axes are those of the size line."""
    if first[:1] == (b"+" if first[1:] == b"Y" else b"-"):
        pixels = pixels[::-1]
    if second[:1] == (b"+" if second[1:] == b"Y" else b"-"):
        pixels = pixels[:, ::-1]
    return pixels if first[1:] == b"Y" else pixels.swapaxes(0, 1)
