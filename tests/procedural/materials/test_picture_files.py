"""A user's folder of pictures."""

from __future__ import annotations

import struct
from pathlib import Path

import cv2
import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.materials.picture_files import LONGEST_SIDE, read_numbers, read_picture, srgb_to_linear


def _picture(path: Path, shape: tuple[int, ...] = (2, 2, 3)) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.full(shape, 128, np.uint8))
    return path


def test_a_picture_that_cannot_be_decoded_is_refused(tmp_path: Path) -> None:
    path = _picture(tmp_path / "a.png", (64, 64, 3))
    path.write_bytes(path.read_bytes()[:40])
    with pytest.raises(InputError, match=r"a\.png: expected a readable picture, found a broken file"):
        read_picture(path)
    path.write_bytes(b"")
    with pytest.raises(InputError, match="a readable picture"):
        read_picture(path)
    with pytest.raises(InputError, match=r"b\.png: expected a readable picture, found none"):
        read_picture(tmp_path / "b.png")


def test_a_picture_of_floating_point_numbers_is_linear(tmp_path: Path) -> None:
    values = np.linspace(0.0, 1.0, 12, dtype=np.float32).reshape(2, 2, 3)
    cv2.imwrite(str(tmp_path / "a.tiff"), values)
    np.testing.assert_array_equal(read_picture(tmp_path / "a.tiff"), values[..., ::-1])


def test_numbers_have_no_srgb_curve(tmp_path: Path) -> None:
    path = _picture(tmp_path / "a.png")
    assert read_numbers(path) == pytest.approx(128 / 255)
    assert read_picture(path) == pytest.approx(float(srgb_to_linear(np.array(128 / 255))))


def test_a_pointer_of_git_lfs_says_how_to_fetch_the_file(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n")
    with pytest.raises(InputError, match=r"a\.png: expected the file itself, found a pointer to it \(git lfs pull"):
        read_picture(tmp_path / "a.png")


def test_a_picture_that_claims_too_many_pixels_is_refused_from_its_header(tmp_path: Path) -> None:
    path = _picture(tmp_path / "a.png")
    content = bytearray(path.read_bytes())
    content[16:24] = struct.pack(">II", 100_000, 100_000)
    path.write_bytes(content)
    with pytest.raises(InputError, match="1 to 16384 pixels a side, found 100000 x 100000"):
        read_picture(path)


def test_a_huge_picture_is_reduced(tmp_path: Path) -> None:
    picture = read_picture(_picture(tmp_path / "a.png", (3, 2 * LONGEST_SIDE, 3)))
    assert picture.shape == (2, LONGEST_SIDE, 3)
