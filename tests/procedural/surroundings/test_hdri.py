"""Environment maps from files."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import OpenEXR
import pytest

from glassware.core.assets import asset
from glassware.core.errors import InputError
from glassware.procedural.surroundings.hdri import hdri_files, read_hdri, usable_hdris

REAL = Path(__file__).resolve().parents[4] / "shared" / "assets" / "hdri"
PIXELS = np.random.default_rng(0).uniform(0.0, 5.0, size=(8, 16, 3)).astype(np.float32)
# Radiance's shared exponent: 8 bits of mantissa for the largest of the three.
RGBE = 1.0 / 128.0

needs_real_files = pytest.mark.skipif(not REAL.is_dir(), reason="shared/assets/hdri is not beside this checkout")


def write_exr(path: Path, channels: dict, compression=OpenEXR.ZIP_COMPRESSION) -> Path:
    with OpenEXR.File({"compression": compression, "type": OpenEXR.scanlineimage}, channels) as file:
        file.write(str(path))
    return path


def rgb(pixels: np.ndarray) -> dict:
    return {name: np.ascontiguousarray(pixels[..., k]) for k, name in enumerate("RGB")}


def refused(path: Path, expected: str) -> str:
    with pytest.raises(InputError, match=expected) as error:
        read_hdri(asset(path))
    message = str(error.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    return message


def test_files_come_sorted_by_name_and_others_are_left_out(tmp_path):
    for name in ("b.exr", "a.HDR", "c.exr", "notes.txt"):
        (tmp_path / name).write_bytes(b"")
    assert [path.name for path in hdri_files(tmp_path)] == ["a.HDR", "b.exr", "c.exr"]


def test_a_missing_folder_a_file_and_an_empty_folder_are_refused(tmp_path):
    for path, expected in ((tmp_path / "none", "found no such folder"), (tmp_path, "found none")):
        with pytest.raises(InputError, match=expected):
            hdri_files(path)
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(InputError, match="found a file"):
        hdri_files(tmp_path / "file")


@pytest.mark.parametrize("dtype", [np.float16, np.float32])
def test_an_exr_is_read_as_stored_with_its_columns_turned_round(tmp_path, dtype):
    stored = PIXELS.astype(dtype)
    read = read_hdri(asset(write_exr(tmp_path / "a.exr", rgb(stored))))
    assert read.dtype == np.float32
    np.testing.assert_array_equal(read, stored[:, ::-1].astype(np.float32))


def test_what_stands_right_of_the_middle_in_the_picture_stands_right_in_the_scene(tmp_path):
    stored = np.zeros((8, 16, 3), dtype=np.float32)
    stored[4, 11] = 1.0  # right of the middle column
    read = read_hdri(asset(write_exr(tmp_path / "a.exr", rgb(stored))))
    azimuth = 2 * np.pi * (np.argmax(read[4, :, 0]) + 0.5) / 16
    # The middle is -x; somebody who looks along -x with +z up has +y on the right... and -x cross z is +y.
    ahead, up = np.array([-1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    assert np.array([np.cos(azimuth), np.sin(azimuth), 0.0]) @ np.cross(ahead, up) > 0.5


def test_alpha_is_ignored_and_a_single_luminance_is_grey(tmp_path):
    with_alpha = {**rgb(PIXELS), "A": np.zeros((8, 16), np.float32)}
    np.testing.assert_array_equal(read_hdri(asset(write_exr(tmp_path / "a.exr", with_alpha))), PIXELS[:, ::-1])
    grey = read_hdri(asset(write_exr(tmp_path / "y.exr", {"Y": PIXELS[..., 0].copy()})))
    np.testing.assert_array_equal(grey, np.repeat(PIXELS[:, ::-1, :1], 3, axis=2))


def test_a_radiance_file_is_read(tmp_path):
    cv2.imwrite(str(tmp_path / "a.hdr"), np.ascontiguousarray(PIXELS[..., ::-1]))
    read = read_hdri(asset(tmp_path / "a.hdr"))
    error = np.abs(read - PIXELS[:, ::-1]).max(axis=2) / PIXELS[:, ::-1].max(axis=2)
    assert error.max() <= RGBE


@pytest.mark.parametrize("compression", [OpenEXR.DWAB_COMPRESSION, OpenEXR.ZIP_COMPRESSION])
def test_shallow_dips_beside_bright_pixels_become_zero(tmp_path, compression):
    signed = PIXELS.copy()
    signed[3:5, 4:9] = -0.6
    path = write_exr(tmp_path / "a.exr", rgb(signed.astype(np.float16)), compression)
    with OpenEXR.File(str(path), num_threads=0) as file:
        stored = file.channels()["RGB"].pixels.astype(np.float32)
    assert stored.min() < 0.0
    np.testing.assert_array_equal(read_hdri(asset(path)), np.maximum(stored[:, ::-1], 0.0))


@pytest.mark.parametrize(
    ("value", "read", "remark"),
    [
        (np.nan, 0.0, "1 pixel without a number (NaN), read as black"),
        (np.inf, 65504.0, "1 infinite pixel, read as 65504"),
        (-np.inf, 0.0, "1 infinite pixel, read as 65504"),
        (-30.0, 0.0, "1 pixel far below 0, read as black"),
    ],
)
def test_single_pixels_that_are_no_radiance_are_replaced_and_told(tmp_path, value, read, remark):
    pixels = np.tile(PIXELS, (2, 2, 1))
    pixels[2, 3, 1] = value
    path = write_exr(tmp_path / "a.exr", rgb(pixels))
    assert read_hdri(asset(path))[2, -4, 1] == read
    _, findings = usable_hdris(tmp_path)
    assert [(item.path, item.reason, item.used) for item in findings] == [("a.exr", remark, True)]


@pytest.mark.parametrize(
    ("value", "expected"), [(np.nan, "8 that are NaN"), (np.inf, "or infinite"), (-30.0, "8 far below, such as -30")]
)
def test_many_pixels_that_are_no_radiance_are_damage(tmp_path, value, expected):
    pixels = PIXELS.copy()
    pixels[2, :8, 1] = value
    refused(write_exr(tmp_path / "a.exr", rgb(pixels)), expected)


def test_a_folder_with_a_bad_file_keeps_the_good_ones_and_one_without_a_good_one_is_refused(tmp_path):
    (tmp_path / "deep" / "er").mkdir(parents=True)
    good = write_exr(tmp_path / "deep" / "er" / "good.exr", rgb(PIXELS))
    (tmp_path / "bad.hdr").write_bytes(b"no picture")
    (tmp_path / "._good.exr").write_bytes(b"\0\5\x16\7")
    files, findings = usable_hdris(tmp_path)
    assert files == (good,)
    assert [(item.path, item.used) for item in findings] == [("bad.hdr", False)]
    good.unlink()
    with pytest.raises(InputError, match=r"environment maps that can be used, found none in 1 file; .*bad\.hdr"):
        usable_hdris(tmp_path)


def test_a_panorama_in_jpeg_is_read_as_light_of_low_range(tmp_path):
    cv2.imwrite(str(tmp_path / "a.jpg"), np.full((8, 16, 3), 188, np.uint8))
    cv2.imwrite(str(tmp_path / "b.jpg"), np.full((8, 8, 3), 188, np.uint8))
    files, findings = usable_hdris(tmp_path)
    assert [path.name for path in files] == ["a.jpg"]
    assert [item.path for item in findings if "low range" in item.reason] == ["a.jpg"]
    assert read_hdri(asset(files[0])) == pytest.approx(0.5, abs=0.01)  # sRGB 188 is half of white


def test_a_jpeg_beside_its_map_is_no_map(tmp_path):
    write_exr(tmp_path / "hall_4k.exr", rgb(PIXELS))
    cv2.imwrite(str(tmp_path / "hall_tonemapped.jpg"), np.full((8, 16, 3), 188, np.uint8))
    assert [path.name for path in hdri_files(tmp_path)] == ["hall_4k.exr"]


def test_a_map_one_column_too_wide_is_read_as_one_of_the_right_shape(tmp_path):
    path = write_exr(tmp_path / "a.exr", rgb(np.full((32, 65, 3), 2.0, np.float32)))
    assert read_hdri(asset(path)).shape == (32, 64, 3)
    assert "65 x 32 pixels, read as 64 x 32" in usable_hdris(tmp_path)[1][0].reason


def test_a_map_that_is_not_twice_as_wide_as_high_is_refused(tmp_path):
    refused(write_exr(tmp_path / "a.exr", rgb(PIXELS[:, :15])), "found 15 x 8 pixels")
    cv2.imwrite(str(tmp_path / "a.hdr"), PIXELS[:, :8])
    refused(tmp_path / "a.hdr", "found 8 x 8 pixels")


@pytest.mark.parametrize("name", ["a.exr", "a.hdr"])
@pytest.mark.parametrize("content", [b"", b"hello world, this is no picture"])
def test_a_file_of_another_kind_is_refused(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    refused(tmp_path / name, "first bytes" if content else "an empty file")


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("suffix", [".exr", ".hdr"])
def test_a_file_cut_short_is_refused(tmp_path, suffix, share):
    pixels = np.random.default_rng(0).uniform(size=(64, 128, 3)).astype(np.float32)
    path = tmp_path / f"a{suffix}"
    write_exr(path, rgb(pixels)) if suffix == ".exr" else cv2.imwrite(str(path), pixels)
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    refused(path, "a damaged one")


def test_a_file_that_changed_or_went_is_refused(tmp_path):
    pinned = asset(write_exr(tmp_path / "a.exr", rgb(PIXELS)))
    write_exr(tmp_path / "a.exr", rgb(PIXELS + 1))
    with pytest.raises(InputError, match="SHA-256"):
        read_hdri(pinned)
    (tmp_path / "a.exr").unlink()
    with pytest.raises(InputError, match="a readable file"):
        read_hdri(pinned)


@needs_real_files
def test_real_maps_keep_the_energy_that_is_stored():
    files = hdri_files(REAL)
    assert len(files) == 12
    for path in files:
        with OpenEXR.File(str(path), num_threads=0) as file:
            stored = file.channels()["RGB"].pixels.astype(np.float64)
        read = read_hdri(asset(path))
        assert read.shape == (256, 512, 3)
        np.testing.assert_allclose(read.sum(axis=1), np.maximum(stored, 0.0).sum(axis=1), rtol=1e-5)
        assert read.min() >= 0.0
