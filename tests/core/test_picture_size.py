"""Sizes of pictures from their headers."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from glassware.core.picture_size import picture_size


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".bmp", ".webp", ".tif"])
def test_the_header_has_the_size_of_the_picture(suffix) -> None:
    pixels = np.random.default_rng(0).integers(0, 255, (37, 53, 3), np.uint8)
    _, content = cv2.imencode(suffix, pixels)
    assert picture_size(content.tobytes()) == (53, 37)


def test_lossless_webp_and_grey_pictures_have_sizes_too() -> None:
    grey = np.zeros((37, 53), np.uint8)
    for suffix, options in ((".webp", [cv2.IMWRITE_WEBP_QUALITY, 101]), (".png", []), (".jpg", [])):
        assert picture_size(cv2.imencode(suffix, grey, options)[1].tobytes()) == (53, 37)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".bmp", ".webp", ".tif"])
def test_damaged_headers_have_no_size_and_raise_nothing(suffix) -> None:
    content = cv2.imencode(suffix, np.zeros((8, 8, 3), np.uint8))[1].tobytes()
    for end in range(40):
        picture_size(content[:end])
    assert picture_size(b"") is None
    assert picture_size(b"hello") is None
