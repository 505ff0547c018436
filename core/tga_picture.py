"""Truevision TGA pictures, which OpenCV's wheel does not read.

After "Truevision TGA File Format Specification", version 2.0 (1991): true colour and grey, plain or run-length coded,
and colour-mapped ones.
"""

from __future__ import annotations

import struct

import numpy as np

_HEADER = struct.Struct("<BBBHHBHHHHBB")
#: Image types (table 1 of the specification): colour-mapped, true colour, grey; 8 more when run-length coded.
_MAPPED, _TRUE, _GREY, _PACKED = 1, 2, 3, 8


def tga_size(content: bytes) -> tuple[int, int] | None:
    """Return width and height [px] where the bytes can be a TGA picture, else None: the format has no mark."""
    if len(content) < _HEADER.size:
        return None
    _, has_map, kind, _, _, _, _, _, width, height, depth, _ = _HEADER.unpack_from(content)
    known = kind & ~_PACKED in (_MAPPED, _TRUE, _GREY) and kind < 12 and has_map in (0, 1)
    return (width, height) if known and width and height and depth in (8, 15, 16, 24, 32) else None


def read_tga(content: bytes) -> np.ndarray:
    """Return a picture as OpenCV would, first row at the top.

    Returns
    -------
    (h, w) or (h, w, 3) or (h, w, 4) uint8
        Grey, or blue, green, red and opacity.

    Raises
    ------
    ValueError
        Where the file is cut short or is of another kind.
    """
    if tga_size(content) is None:
        raise ValueError("expected a TGA picture, found something else")
    skip, _, kind, first, count, map_depth, _, _, width, height, depth, flags = _HEADER.unpack_from(content)
    start = _HEADER.size + skip
    table, start = _colour_map(content, start, first, count, map_depth) if count else (None, start)
    size = (depth + 7) // 8
    read = _unpacked if kind & _PACKED else _plain
    values = read(content[start:], width * height, size)
    if kind & ~_PACKED == _MAPPED:
        if table is None or size > 2:
            raise ValueError("expected a colour map, found none")
        index = values[:, 0].astype(int) if size == 1 else values.view("<u2")[:, 0].astype(int)
        if index.max(initial=0) >= len(table):
            raise ValueError(f"expected colours of a map of {len(table)}, found number {index.max()}")
        values = table[index]
    else:
        values = _colours(values, depth)
    picture = values.reshape(height, width, -1)
    # Bit 5: rows begin at the top; bit 4: columns begin at the right.
    picture = picture if flags & 0x20 else picture[::-1]
    picture = picture[:, ::-1] if flags & 0x10 else picture
    return np.ascontiguousarray(picture[..., 0] if picture.shape[2] == 1 else picture)


def _colour_map(content: bytes, start: int, first: int, count: int, depth: int) -> tuple[np.ndarray, int]:
    size = (depth + 7) // 8
    values = _colours(_plain(content[start:], count, size), depth)
    return np.concatenate([np.zeros((first, values.shape[1]), np.uint8), values]), start + count * size


def _colours(values: np.ndarray, depth: int) -> np.ndarray:
    """Return stored values (n, bytes) as grey, blue green red, or with opacity, (n, 1 | 3 | 4) uint8."""
    if depth not in (15, 16):
        return values
    word = np.ascontiguousarray(values).view("<u2")[:, 0]
    channels = [(word >> shift & 0x1F) * 255 // 31 for shift in (0, 5, 10)]
    return np.stack(channels, axis=1).astype(np.uint8)


def _plain(content: bytes, count: int, size: int) -> np.ndarray:
    if len(content) < count * size:
        raise ValueError(f"expected {count * size} bytes of pixels, found {len(content)}")
    return np.frombuffer(content, np.uint8, count * size).reshape(count, size)


def _unpacked(content: bytes, count: int, size: int) -> np.ndarray:
    """Return run-length coded pixels: a packet is a byte with a count, and one pixel or as many."""
    found, place, pieces = 0, 0, []
    while found < count:
        if place >= len(content):
            raise ValueError(f"expected {count} pixels, found {found}")
        run = (content[place] & 0x7F) + 1
        same = bool(content[place] & 0x80)
        pixels = _plain(content[place + 1 :], 1 if same else run, size)
        pieces.append(np.repeat(pixels, run, axis=0) if same else pixels)
        place += 1 + len(pixels) * size
        found += run
    return np.concatenate(pieces)[:count]
