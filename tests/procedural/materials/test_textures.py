"""Baked textures: reflectances without a seam, from nothing but their numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from glassware.core.assets import asset
from glassware.core.errors import InputError
from glassware.procedural.description.material import PictureTexture, ProceduralTexture, UniformTexture
from glassware.procedural.materials import textures
from glassware.procedural.materials.textures import PATTERNS, bake

COLOURS = ((0.7, 0.65, 0.5), (0.1, 0.2, 0.35), (0.4, 0.1, 0.1))
REAL = Path(__file__).resolve().parents[4] / "shared" / "assets" / "textures"


def _texture(kind: Any, seed: int = 1, resolution: int = 128) -> ProceduralTexture:
    return ProceduralTexture(kind=kind, colours=COLOURS, seed=seed, resolution=resolution)


@pytest.mark.parametrize("kind", PATTERNS)
@pytest.mark.parametrize("seed", range(4))
def test_a_pattern_goes_on_across_the_edges_of_its_tile(kind: str, seed: int) -> None:
    picture = bake(_texture(kind, seed))
    for axis in (0, 1):
        inside = np.abs(np.diff(picture, axis=axis)).mean(axis=(1 - axis, 2))
        first, last = np.take(picture, 0, axis), np.take(picture, -1, axis)
        seam = np.abs(first - last).mean()
        # The seam is one step among 128: no larger than the largest of the others, with a tenth for the one case in
        # about a hundred that it is itself the largest.
        assert seam <= 1.1 * inside.max()


def test_a_picture_cut_from_a_tile_shows_a_seam() -> None:
    """The measure above tells a seam: a part of a tile does not continue."""
    picture = bake(_texture("noise", 2))[:, :77]
    inside = np.abs(np.diff(picture, axis=1)).mean(axis=(0, 2))
    assert np.abs(picture[:, 0] - picture[:, -1]).mean() > 1.1 * inside.max()


@pytest.mark.parametrize("kind", PATTERNS)
def test_a_pattern_is_made_of_reflectances_and_is_no_single_colour(kind: str) -> None:
    picture = bake(_texture(kind))
    assert picture.shape == (128, 128, 3)
    assert picture.dtype == np.float32
    assert picture.min() >= 0.0
    assert picture.max() <= 1.0
    assert picture.std(axis=(0, 1)).max() > 0.01


@pytest.mark.parametrize("kind", PATTERNS)
def test_a_pattern_depends_on_its_seed_alone(kind: str) -> None:
    first = bake(_texture(kind, 5))
    textures._procedural.cache_clear()  # baked again, not remembered
    assert np.array_equal(bake(_texture(kind, 5)), first)
    assert not np.array_equal(bake(_texture(kind, 5)), bake(_texture(kind, 6)))


@pytest.mark.parametrize("kind", PATTERNS)
def test_bright_colours_do_not_reflect_more_than_they_receive(kind: Any) -> None:
    white = ProceduralTexture(kind=kind, colours=((1.0, 1.0, 1.0), (0.9, 1.0, 1.0)), seed=3, resolution=16)
    assert bake(white).max() <= 1.0


def test_one_colour_is_one_pixel() -> None:
    assert np.allclose(bake(UniformTexture(colour=(0.1, 0.2, 0.3))), [[[0.1, 0.2, 0.3]]], rtol=1e-7)


@pytest.mark.parametrize(("dtype", "top"), [(np.uint8, 255), (np.uint16, 65535)])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_a_picture_is_decoded_to_linear_light_with_its_lower_edge_first(
    tmp_path: Path, dtype: type, top: int, channels: int
) -> None:
    stored = np.zeros((2, 3, channels), dtype)
    stored[0] = top
    stored[1, :, :3] = round(0.5 * top)
    cv2.imwrite(str(tmp_path / "a.png"), stored)
    picture = bake(PictureTexture(asset=asset(tmp_path / "a.png")))
    assert picture.shape == (2, 3, 3)
    assert np.array_equal(picture[1], np.ones((3, 3), np.float32))
    # IEC 61966-2-1 by hand at the stored level; float32 arithmetic has seven digits.
    level = round(0.5 * top) / top
    assert np.allclose(picture[0], ((level + 0.055) / 1.055) ** 2.4, rtol=1e-5)


def test_a_picture_keeps_the_order_of_its_colours(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), np.full((1, 1, 3), (0, 0, 255), np.uint8))  # OpenCV writes B, G, R
    assert bake(PictureTexture(asset=asset(tmp_path / "a.png"))).ravel().tolist() == [1.0, 0.0, 0.0]


def test_a_picture_that_changed_since_it_was_pinned_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), np.zeros((2, 2, 3), np.uint8))
    pinned = PictureTexture(asset=asset(path))
    cv2.imwrite(str(path), np.ones((2, 2, 3), np.uint8))
    with pytest.raises(InputError, match=r"a\.png: expected the file with SHA-256"):
        bake(pinned)


@pytest.mark.skipif(not REAL.is_dir(), reason="shared/assets/textures is not beside the checkout")
def test_real_pictures_are_read() -> None:
    for path in sorted(REAL.glob("*.png")):
        picture = bake(PictureTexture(asset=asset(path)))
        assert picture.shape[2] == 3
        assert 0.005 < picture.mean() < 0.95
