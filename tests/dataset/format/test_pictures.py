from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.images import srgb8
from glassware.dataset.format.pictures import read_png, write_png


def test_srgb_has_the_values_of_its_standard():
    # IEC 61966-2-1: 18 % grey is 118 (117.6...), 50 % is 188 (187.5...), black and white are 0 and 255.
    linear = np.array([[[0.0, 0.18, 0.5], [1.0, 7.0, -1.0], [0.001, 0.0031308, np.inf]]], np.float32)
    expected = [[[0, 118, 188], [255, 255, 0], [3, 10, 255]]]
    assert srgb8(linear, 1.0).tolist() == expected


def test_exposure_is_a_factor_on_radiance(rng):
    linear = rng.random((4, 5, 3)).astype(np.float32)
    np.testing.assert_array_equal(srgb8(linear, 0.25), srgb8(linear * np.float32(0.25), 1.0))


def test_colours_come_back_in_their_order(tmp_path, rng):
    picture = rng.integers(0, 256, (6, 7, 3), dtype=np.uint8)
    write_png(tmp_path / "a.png", picture)
    np.testing.assert_array_equal(read_png(tmp_path / "a.png"), picture)


def test_ids_of_sixteen_bits_come_back(tmp_path, rng):
    ids = rng.integers(0, 65536, (6, 7)).astype(np.uint16)
    write_png(tmp_path / "a.png", ids)
    again = read_png(tmp_path / "a.png")
    assert again.dtype == np.uint16
    np.testing.assert_array_equal(again, ids)


@pytest.mark.parametrize("data", [b"", b"hello", b"\x89PNG\r\n\x1a\n" + b"0" * 50])
def test_a_damaged_picture_is_one_clear_line(tmp_path, data):
    (tmp_path / "a.png").write_bytes(data)
    with pytest.raises(InputError, match="PNG"):
        read_png(tmp_path / "a.png")


def test_a_picture_cut_short_is_refused(tmp_path, rng):
    write_png(tmp_path / "a.png", rng.integers(0, 256, (60, 70, 3), dtype=np.uint8))
    (tmp_path / "a.png").write_bytes((tmp_path / "a.png").read_bytes()[:-30])
    with pytest.raises(InputError, match="whole PNG"):
        read_png(tmp_path / "a.png")


def test_other_pictures_are_not_written(tmp_path):
    with pytest.raises(ValueError, match="uint16"):
        write_png(tmp_path / "a.png", np.zeros((4, 4), np.float32))
