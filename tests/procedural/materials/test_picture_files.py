"""A user's folder of pictures."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.materials.picture_files import LONGEST_SIDE, check_pictures, picture_files, read_picture


def _picture(path: Path, shape: tuple[int, ...] = (2, 2, 3)) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.full(shape, 128, np.uint8))
    return path


def test_pictures_are_found_in_subfolders_in_the_order_of_their_paths(tmp_path: Path) -> None:
    expected = [_picture(tmp_path / name) for name in ("a/z.png", "b.JPG", "c/a.bmp")]
    (tmp_path / "LICENSE").write_text("free")
    assert picture_files(tmp_path) == tuple(expected)


def test_a_missing_an_empty_and_a_spoilt_folder_are_each_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nowhere: expected a folder of pictures, found no such folder"):
        picture_files(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"expected pictures \(.*\), found none"):
        picture_files(tmp_path)
    (tmp_path / "a.png").write_text("not a picture")
    with pytest.raises(InputError, match=r"a\.png: expected a picture, found something else"):
        picture_files(tmp_path)


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


def test_a_whole_folder_can_be_checked_before_anything_is_drawn(tmp_path: Path) -> None:
    path = _picture(tmp_path / "a.png", (64, 64, 3))
    check_pictures(picture_files(tmp_path))
    path.write_bytes(path.read_bytes()[:40])
    with pytest.raises(InputError, match=r"a\.png: expected a readable picture, found a broken file"):
        check_pictures(picture_files(tmp_path))


def test_a_picture_of_floating_point_numbers_is_refused(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.tiff"), np.ones((2, 2, 3), np.float32))
    with pytest.raises(InputError, match="8 or 16 bits per channel, found float32"):
        read_picture(tmp_path / "a.tiff")


def test_a_huge_picture_is_reduced(tmp_path: Path) -> None:
    picture = read_picture(_picture(tmp_path / "a.png", (3, 2 * LONGEST_SIDE, 3)))
    assert picture.shape == (2, LONGEST_SIDE, 3)
