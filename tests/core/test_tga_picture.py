"""TGA pictures against Pillow's writer and a header by hand."""

from __future__ import annotations

import io
import struct

import numpy as np
import pytest
from PIL import Image

from glassware.core.tga_picture import read_tga, tga_size

RNG = np.random.default_rng(0)


@pytest.mark.parametrize("mode", ["L", "RGB", "RGBA", "P"])
@pytest.mark.parametrize("compression", [None, "tga_rle"])
def test_a_tga_reads_as_another_program_wrote_it(mode: str, compression: str | None) -> None:
    pixels = np.repeat(RNG.integers(0, 256, (7, 5, 3), dtype=np.uint8), 3, axis=1)
    picture = Image.fromarray(pixels).convert(mode)
    file = io.BytesIO()
    picture.save(file, "TGA", compression=compression)
    assert tga_size(file.getvalue()) == (15, 7)
    found = read_tga(file.getvalue())
    expected = np.array(picture if mode in ("L", "RGB", "RGBA") else picture.convert("RGB"))
    assert np.array_equal(found if found.ndim == 2 else found[..., [2, 1, 0, 3][: found.shape[2]]], expected)


def test_a_tga_that_is_cut_short_or_something_else_is_refused() -> None:
    file = io.BytesIO()
    Image.fromarray(RNG.integers(0, 256, (7, 5, 3), dtype=np.uint8)).save(file, "TGA")
    for content in (file.getvalue()[:60], b"", b"\x89PNG\r\n\x1a\n" + bytes(30)):
        with pytest.raises(ValueError, match="expected"):
            read_tga(content)
    claim = struct.pack("<BBBHHBHHHHBB", 0, 0, 10, 0, 0, 0, 0, 0, 65535, 65535, 24, 0)
    with pytest.raises(ValueError, match="pixels"):
        read_tga(claim + b"\xff\0\0\0")
