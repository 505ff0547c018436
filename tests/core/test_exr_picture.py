"""OpenEXR files as programs write them."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from glassware.core.errors import InputError
from glassware.core.exr_picture import read_exr_picture

PIXELS = np.random.default_rng(0).uniform(0.0, 5.0, size=(8, 16, 3)).astype(np.float32)
#: Half has 11 bits, and green is a difference that is divided by 0.7.
HALF = 2e-3


def write(path: Path, *parts: tuple[dict, dict]) -> Path:
    made = [OpenEXR.Part({"type": OpenEXR.scanlineimage} | header, channels) for header, channels in parts]
    with OpenEXR.File(made) as file:
        file.write(str(path))
    return path


def planes(pixels: np.ndarray, names: str = "RGB", prefix: str = "") -> dict:
    return {prefix + name: np.ascontiguousarray(pixels[..., k]) for k, name in enumerate(names)}


def read(path: Path) -> np.ndarray:
    return read_exr_picture(path, lambda width, height: None)


@pytest.mark.parametrize(
    "channels",
    [
        planes(PIXELS),
        planes(PIXELS, "rgb"),
        planes(PIXELS, prefix="ViewLayer.Combined."),
        planes(PIXELS, prefix="diffuse."),
        planes(PIXELS) | planes(PIXELS + 1.0, prefix="diffuse."),
        planes(PIXELS, prefix="beauty.") | planes(PIXELS + 1.0, prefix="albedo.") | {"Z": PIXELS[..., 0].copy()},
    ],
)
def test_the_layer_of_the_finished_picture_is_read(tmp_path, channels) -> None:
    np.testing.assert_array_equal(read(write(tmp_path / "a.exr", ({}, channels))), PIXELS)


def test_the_part_of_the_finished_picture_is_read(tmp_path) -> None:
    depth = ({"name": "depth"}, {"Z": PIXELS[..., 0].copy()})
    normals = ({"name": "normals"}, planes(PIXELS + 1.0, "XYZ"))
    path = write(tmp_path / "a.exr", depth, normals, ({"name": "rgba"}, planes(PIXELS)))
    np.testing.assert_array_equal(read(path), PIXELS)


def test_what_the_data_window_lacks_is_black_and_what_lies_outside_the_picture_is_cut(tmp_path) -> None:
    shown = (np.array([0, 0], np.int32), np.array([15, 7], np.int32))
    part = {"displayWindow": shown, "dataWindow": (np.array([-2, 2], np.int32), np.array([13, 9], np.int32))}
    found = read(write(tmp_path / "a.exr", (part, planes(PIXELS))))
    expected = np.zeros_like(PIXELS)
    expected[2:, :14] = PIXELS[:6, 2:]
    np.testing.assert_array_equal(found, expected)


def test_luminance_and_chroma_become_red_green_and_blue(tmp_path) -> None:
    colour = np.array([2.0, 1.0, 0.5])
    Y = float(colour @ [0.2126, 0.7152, 0.0722])
    path = tmp_path / "a.exr"
    path.write_bytes(luminance_chroma(8, 16, Y, colour[0] / Y - 1.0, colour[2] / Y - 1.0))
    assert read(path) == pytest.approx(np.broadcast_to(colour, (8, 16, 3)), rel=HALF)


def luminance_chroma(height: int, width: int, *values: float) -> bytes:
    """Return an uncompressed file (Y, RY, BY) by the layout on openexr.com: the package writes full planes only."""

    def attribute(name: str, kind: str, value: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    listed = b"".join(
        name + b"\0" + struct.pack("<iB3xii", 1, 0, step, step) for name, step in ((b"BY", 2), (b"RY", 2), (b"Y", 1))
    )
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = b"\x76\x2f\x31\x01\x02\0\0\0" + attribute("channels", "chlist", listed + b"\0")
    head += attribute("compression", "compression", b"\0") + attribute("dataWindow", "box2i", window)
    head += attribute("displayWindow", "box2i", window) + attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0))
    head += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)) + b"\0"
    Y, RY, BY = (np.full(width, value, "<f2").tobytes() for value in values)
    rows = [(BY[:width] + RY[:width] if y % 2 == 0 else b"") + Y for y in range(height)]
    blocks = [struct.pack("<ii", y, len(row)) + row for y, row in enumerate(rows)]
    ends = np.cumsum([len(block) for block in blocks])
    starts = len(head) + 8 * height + np.concatenate([[0], ends[:-1]])
    return head + starts.astype("<u8").tobytes() + b"".join(blocks)


@pytest.mark.parametrize(
    ("channels", "expected"),
    [
        ({"Z": PIXELS[..., 0].copy()}, "channels R, G, B or Y, found Z"),
        ({k: v for k, v in planes(PIXELS).items() if k != "B"}, "found G, R"),
        ({k: v.astype(np.uint32) for k, v in planes(PIXELS).items()}, "half or float"),
        (planes(PIXELS, prefix="a.") | planes(PIXELS, prefix="b."), "one layer, or one named .*, found a, b"),
    ],
)
def test_channels_that_are_no_picture_are_refused(tmp_path, channels, expected) -> None:
    with pytest.raises(InputError, match=expected):
        read(write(tmp_path / "a.exr", ({}, channels)))


def test_a_size_is_refused_before_any_pixel_is_read(tmp_path) -> None:
    path = write(tmp_path / "a.exr", ({}, planes(PIXELS)))
    content = path.read_bytes()
    whole = struct.pack("<4i", 0, 0, 15, 7)
    path.write_bytes(content.replace(whole, struct.pack("<4i", 0, 0, 99_999, 99_999)))
    asked = []

    def check(width: int, height: int) -> None:
        asked.append((width, height))
        raise InputError(path, "a smaller picture", f"{width} x {height}")

    with pytest.raises(InputError, match="found 100000 x 100000"):
        read_exr_picture(path, check)
    assert asked == [(100_000, 100_000)]
