from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.images import srgb8
from glassware.dataset.format.pictures import read_png, save_png, write_png


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


def test_radiance_is_saved_as_its_camera_shows_it(tmp_path, rng):
    radiance = rng.random((4, 5, 3)).astype(np.float32)
    save_png(tmp_path / "a.png", radiance, exposure=0.5)
    np.testing.assert_array_equal(read_png(tmp_path / "a.png"), srgb8(radiance, 0.5))
    picture = srgb8(radiance, 1.0)
    save_png(str(tmp_path / "b.png"), picture)
    np.testing.assert_array_equal(read_png(tmp_path / "b.png"), picture)


@pytest.mark.parametrize(
    ("name", "picture", "exposure", "line"),
    [
        ("a.png", np.zeros((4, 5)), 1.0, "save_png: picture: expected radiance or 8-bit colours of shape (H, W, 3)"),
        ("a.png", "b.png", 1.0, "save_png: picture: expected a Frame, or an array of shape (H, W, 3), found 'b.png'"),
        ("a.png", np.zeros((4, 5, 3)), 0.0, "save_png: exposure: expected a number from "),
        ("absent/a.png", np.zeros((4, 5, 3)), 1.0, "absent/a.png: expected a file that can be written, found none"),
    ],
)
def test_what_cannot_be_saved_is_one_line(tmp_path, name, picture, exposure, line):
    with pytest.raises(InputError) as error:
        save_png(tmp_path / name, picture, exposure)
    assert line in str(error.value)
