"""Radiance pictures in their dialects."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.surroundings.radiance_picture import read_radiance_picture

PIXELS = np.random.default_rng(0).uniform(0.0, 5.0, size=(8, 16, 3)).astype(np.float32)
PIXELS[3, 2:13] = 1.5  # a run
HEADER = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n"
#: Radiance's shared exponent: 8 bits of mantissa for the largest of the three.
RGBE = 1.0 / 128.0


def stored(pixels: np.ndarray) -> np.ndarray:
    """Return pixels as quadruples with a shared exponent, (h, w, 4) uint8 (Ward 1991, "Real Pixels")."""
    mantissa, exponent = np.frexp(pixels.max(axis=2))
    scale = mantissa * 256.0 / pixels.max(axis=2)
    return np.dstack([pixels * scale[..., None], exponent + 128]).astype(np.uint8)


def with_old_runs(quadruples: np.ndarray) -> bytes:
    """Return rows in which (1, 1, 1, n) repeats the pixel before it n times."""
    out, flat, at = bytearray(), quadruples.reshape(-1, 4), 0
    while at < len(flat):
        end = at + 1
        while end < len(flat) and (flat[end] == flat[at]).all() and end - at < 256:
            end += 1
        out += flat[at].tobytes()
        if end - at > 1:
            out += bytes([1, 1, 1, end - at - 1])
        at = end
    return bytes(out)


def read(path: Path) -> np.ndarray:
    return read_radiance_picture(path, lambda width, height: None)


def assert_close(found: np.ndarray, expected: np.ndarray) -> None:
    assert found.shape == expected.shape
    assert (np.abs(found - expected).max(axis=2) / expected.max(axis=2)).max() <= RGBE


@pytest.fixture
def new_runs(tmp_path) -> bytes:
    cv2.imwrite(str(tmp_path / "opencv.hdr"), np.ascontiguousarray(PIXELS[..., ::-1]))
    content = (tmp_path / "opencv.hdr").read_bytes()
    return content[content.index(b"+X 16\n") + 6 :]


@pytest.mark.parametrize(
    "header",
    [
        HEADER,
        HEADER.replace(b"RADIANCE", b"RGBE"),
        HEADER.replace(b"FORMAT=32-bit_rle_rgbe\n", b""),
        HEADER.replace(b"FORMAT", b"# made by hand\nSOFTWARE=x\nFORMAT"),
        HEADER.replace(b"\n", b"\r\n"),
    ],
)
def test_headers_of_all_programs_are_read(tmp_path, new_runs, header) -> None:
    (tmp_path / "a.hdr").write_bytes(header + new_runs)
    assert_close(read(tmp_path / "a.hdr"), PIXELS)


def test_old_runs_and_pixels_without_runs_are_read(tmp_path) -> None:
    for name, body in (("flat", stored(PIXELS).tobytes()), ("old", with_old_runs(stored(PIXELS)))):
        (tmp_path / f"{name}.hdr").write_bytes(HEADER + body)
        assert_close(read(tmp_path / f"{name}.hdr"), PIXELS)
    assert (tmp_path / "old.hdr").stat().st_size < (tmp_path / "flat.hdr").stat().st_size


def test_an_old_run_longer_than_255_counts_in_bytes_of_two_digits(tmp_path) -> None:
    even = stored(np.full((1, 1, 3), 1.5, np.float32))
    body = even.tobytes() + bytes([1, 1, 1, 1023 & 255, 1, 1, 1, 1023 >> 8])
    (tmp_path / "a.hdr").write_bytes(b"#?RADIANCE\n\n-Y 16 +X 64\n" + body)
    assert_close(read(tmp_path / "a.hdr"), np.full((16, 64, 3), 1.5, np.float32))


@pytest.mark.parametrize(
    ("size", "turned"),
    [
        (b"+Y 8 +X 16", PIXELS[::-1]),
        (b"-Y 8 -X 16", PIXELS[:, ::-1]),
        (b"+X 16 -Y 8", PIXELS.swapaxes(0, 1)),
        (b"-X 16 +Y 8", PIXELS[::-1, ::-1].swapaxes(0, 1)),
    ],
)
def test_rows_and_columns_come_in_any_order(tmp_path, size, turned) -> None:
    (tmp_path / "a.hdr").write_bytes(b"#?RADIANCE\n\n" + size + b"\n" + stored(turned).tobytes())
    assert_close(read(tmp_path / "a.hdr"), PIXELS)


def test_exposures_are_undone(tmp_path) -> None:
    header = HEADER.replace(b"FORMAT", b"EXPOSURE=2.0\nEXPOSURE= 4\nCOLORCORR=1 2 1\nFORMAT")
    (tmp_path / "a.hdr").write_bytes(header + stored(PIXELS).tobytes())
    assert_close(read(tmp_path / "a.hdr") * [8.0, 16.0, 8.0], PIXELS)


def test_tristimulus_values_become_linear_rec_709(tmp_path) -> None:
    white = np.full((8, 16, 3), [0.9505, 1.0, 1.0891], np.float32)  # D65, the white of Rec.709
    (tmp_path / "a.hdr").write_bytes(HEADER.replace(b"rgbe", b"xyze") + stored(white).tobytes())
    assert read(tmp_path / "a.hdr") == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize(
    "content",
    [
        b"#?RADIANCE\n\nno size\n",
        b"#?RADIANCE\n\n-Y 8 +Y 16\n" + bytes(512),
        HEADER + bytes([1, 1, 1, 5]),
        HEADER + bytes(100),
        HEADER.replace(b"FORMAT", b"EXPOSURE=no\nFORMAT") + bytes(512),
        HEADER.replace(b"FORMAT", b"EXPOSURE=0\nFORMAT") + bytes(512),
    ],
)
def test_a_damaged_file_is_refused(tmp_path, content) -> None:
    (tmp_path / "a.hdr").write_bytes(content)
    with pytest.raises(InputError, match=r"a\.hdr: expected"):
        read(tmp_path / "a.hdr")
