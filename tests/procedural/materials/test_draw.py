"""Drawn materials are ones that exist."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from glassware.procedural.description.material import OpaqueMaterial, ProceduralTexture, UniformTexture
from glassware.procedural.materials.draw import draw_material, draw_plain_material, draw_table_material
from glassware.procedural.materials.surface_files import SurfaceFiles

#: Draws enough to meet every family.
DRAWS = 300


def _colours(material: OpaqueMaterial) -> np.ndarray:
    texture = material.base_colour
    assert isinstance(texture, UniformTexture | ProceduralTexture)
    return np.array([texture.colour] if isinstance(texture, UniformTexture) else texture.colours)


@pytest.mark.parametrize("draw", [draw_material, draw_table_material, draw_plain_material])
def test_dielectrics_are_neither_black_nor_brighter_than_snow_and_metals_are_bright(
    draw: Callable[[np.random.Generator], OpaqueMaterial],
) -> None:
    rng = np.random.default_rng(1)
    for _ in range(DRAWS):
        material = draw(rng)
        colours = _colours(material)
        if material.metallic:
            assert colours.mean(axis=1).min() > 0.5
        else:
            assert colours.min() >= 0.013
            assert colours.max() <= 0.871


def test_the_same_generator_draws_the_same_material() -> None:
    assert draw_material(np.random.default_rng(4)) == draw_material(np.random.default_rng(4))


def test_many_kinds_are_drawn() -> None:
    rng = np.random.default_rng(2)
    assert len({draw_material(rng).name for _ in range(DRAWS)}) >= 12
    assert len({draw_table_material(rng).name for _ in range(DRAWS)}) >= 8


def test_a_table_takes_a_picture_where_there_is_one_and_a_prop_now_and_then(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), np.zeros((2, 2, 3), np.uint8))
    rng, files = np.random.default_rng(3), [SurfaceFiles(path, tmp_path, "a")]
    assert all(draw_table_material(rng, files).base_colour.kind == "picture" for _ in range(20))
    share = np.mean([draw_material(rng, files).base_colour.kind == "picture" for _ in range(DRAWS)])
    # PICTURE_PROBABILITY is 0.25; four standard deviations of 300 draws are 0.1.
    assert 0.15 < share < 0.35
