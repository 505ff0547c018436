"""Width and height of a picture from its first bytes, before anything is decoded.

A PNG of a few kilobytes may claim 100,000 x 100,000 pixels. The formats: PNG (ISO/IEC 15948), JPEG (ITU-T T.81), WebP
(RFC 9649), BMP and TIFF 6.0.
"""

from __future__ import annotations

import struct

#: First bytes of a PNG file.
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
#: Start-of-frame markers of JPEG, which hold the size.
_JPEG_FRAMES = frozenset({0xC0, 0xC1, 0xC2, 0xC3, 0xC5, 0xC6, 0xC7, 0xC9, 0xCA, 0xCB, 0xCD, 0xCE, 0xCF})
#: Tags of a TIFF's width and height, and how values of its types 3 (short) and 4 (long) are read.
_TIFF_TAGS, _TIFF_TYPES = (256, 257), {3: "H", 4: "I"}


def picture_size(content: bytes) -> tuple[int, int] | None:
    """Return width and height [px] that a picture's header claims; None for another format or a damaged header."""
    try:
        if content.startswith(PNG_SIGNATURE):
            return struct.unpack_from(">II", content, 16)
        if content.startswith(b"\xff\xd8"):
            return _jpeg(content)
        if content.startswith(b"BM"):
            width, height = struct.unpack_from("<ii", content, 18)
            return abs(width), abs(height)
        if content[:4] == b"RIFF" and content[8:12] == b"WEBP":
            return _webp(content)
        if content[:4] in (b"II*\0", b"MM\0*"):
            return _tiff(content)
    except struct.error:  # cut short
        return None
    return None


def _jpeg(content: bytes) -> tuple[int, int] | None:
    at = 2
    while at + 9 <= len(content):
        marker = content[at + 1]
        if content[at] != 0xFF:
            return None
        if marker in _JPEG_FRAMES:
            height, width = struct.unpack_from(">HH", content, at + 5)
            return width, height
        # Fill bytes and markers without a length.
        at += 1 if marker == 0xFF else 2 if marker == 0x01 or 0xD0 <= marker <= 0xD8 else 2 + _length(content, at + 2)
    return None


def _length(content: bytes, at: int) -> int:
    return max(2, struct.unpack_from(">H", content, at)[0])


def _webp(content: bytes) -> tuple[int, int] | None:
    kind = content[12:16]
    if kind == b"VP8X":
        return 1 + int.from_bytes(content[24:27], "little"), 1 + int.from_bytes(content[27:30], "little")
    if kind == b"VP8L":
        bits = struct.unpack_from("<I", content, 21)[0]
        return 1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)
    if kind == b"VP8 ":
        width, height = struct.unpack_from("<HH", content, 26)
        return width & 0x3FFF, height & 0x3FFF
    return None


def _tiff(content: bytes) -> tuple[int, int] | None:
    order = "<" if content[:2] == b"II" else ">"
    (start,) = struct.unpack_from(f"{order}I", content, 4)
    (count,) = struct.unpack_from(f"{order}H", content, start)
    found = {}
    for number in range(count):
        tag, kind = struct.unpack_from(f"{order}HH", content, start + 2 + 12 * number)
        if tag in _TIFF_TAGS and kind in _TIFF_TYPES:
            (found[tag],) = struct.unpack_from(f"{order}{_TIFF_TYPES[kind]}", content, start + 10 + 12 * number)
    return (found[256], found[257]) if len(found) == 2 else None
