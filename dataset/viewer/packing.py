"""Arrays as text inside a page: differences along rows, byte by byte, deflated (RFC 1951 in RFC 1950), in base 64.

The differences make smooth maps small, as PNG's filter `Sub` does (W3C, "Portable Network Graphics", section 9.2).
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np

#: Level of zlib [0 to 9]: higher ones take twice the time for 2 % less.
_LEVEL = 6


def packed(values: np.ndarray) -> dict[str, Any]:
    """Return an array as a JSON record: ``type``, ``shape`` and ``data``; `unpack` of ``decode.js`` is its inverse.

    Rows are those of the first axis. Each number is stored as its difference to the one before it in its row, modulo
    its size, and the low bytes of all numbers come before the high ones. Float32 is stored by its bits.
    """
    values = np.ascontiguousarray(values)
    kind = f"{values.dtype.kind}{values.dtype.itemsize}"
    if kind not in ("u1", "i1", "u2", "i2", "u4", "f4"):
        raise ValueError(f"an array of {values.dtype}: expected one of at most 32 bits")
    words = values.view(f"u{values.dtype.itemsize}").reshape(len(values), -1) if values.size else values.view("u1")
    # Channels of a pixel differ among each other, so that each is compared with its own of the pixel before.
    stride = values.shape[-1] if values.ndim == 3 else 1
    differences = words.copy()
    differences[:, stride:] -= words[:, :-stride]
    planes = differences.view(np.uint8).reshape(-1, values.dtype.itemsize).T
    data = zlib.compress(np.ascontiguousarray(planes).tobytes(), _LEVEL)
    return {"type": kind, "shape": list(values.shape), "data": base64.b64encode(data).decode("ascii")}
