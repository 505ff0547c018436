"""Maps of a material as numbers."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from glassware.core.assets import asset
from glassware.procedural.description.material import BumpMap, ChannelMap, NormalMap, OpaqueMaterial, UniformTexture
from glassware.procedural.materials.surface_maps import (
    STEEPEST,
    bake_maps,
    mean_metallic,
    mean_roughness,
    slopes_of_heights,
    slopes_of_normals,
)

#: Half a step of 8 bits, as a slope.
STEP = 0.5 / 127.5 * 1.5


def stored(path: Path, rgb: np.ndarray) -> Path:
    cv2.imwrite(str(path), np.ascontiguousarray(rgb[..., ::-1]))
    return path


def material(**fields) -> OpaqueMaterial:
    return OpaqueMaterial(name="m", base_colour=UniformTexture(colour=(0.5, 0.5, 0.5)), roughness=1.0, **fields)


@pytest.mark.parametrize(("convention", "sign"), [("opengl", 1.0), ("directx", -1.0)])
def test_green_points_up_in_opengl_and_down_in_directx(tmp_path, convention, sign) -> None:
    n = np.array([-0.4, -0.3 * sign, 1.0])
    pixels = np.rint(127.5 * (1.0 + n / np.linalg.norm(n))).astype(np.uint8)
    path = stored(tmp_path / "n.png", np.broadcast_to(pixels, (4, 4, 3)))
    record = NormalMap(asset=asset(path), convention=convention)
    slopes = bake_maps(material(normal_map=record))[..., :2]
    assert slopes == pytest.approx(np.broadcast_to([0.4, 0.3], (4, 4, 2)), abs=STEP)
    half = slopes_of_normals(np.broadcast_to(pixels / 255.0, (1, 1, 3)), record.model_copy(update={"strength": 0.5}))
    assert half[0, 0] == pytest.approx([0.2, 0.15], abs=STEP)


def test_normals_of_no_length_and_below_the_surface_are_flat_or_steep_at_most(tmp_path) -> None:
    path = stored(tmp_path / "n.png", np.zeros((1, 1, 3), np.uint8))
    record = NormalMap(asset=asset(path))
    assert slopes_of_normals(np.full((1, 1, 3), 0.5), record)[0, 0] == pytest.approx([0.0, 0.0])
    assert np.abs(slopes_of_normals(np.array([[[0.0, 0.5, 0.0]]]), record)).max() == pytest.approx(STEEPEST)


def test_heights_have_the_slopes_of_their_surface_over_a_repeat(tmp_path) -> None:
    path = stored(tmp_path / "h.png", np.zeros((1, 1, 3), np.uint8))
    n, depth = 256, 0.05
    x = (np.arange(n) + 0.5) / n
    heights = np.broadcast_to(0.5 + 0.5 * np.sin(2 * np.pi * x), (n, n))
    slopes = slopes_of_heights(heights, BumpMap(asset=asset(path), depth=depth))
    expected = depth * np.pi * np.cos(2 * np.pi * x)
    # Central differences of a sine are too small by (2 pi / n)^2 / 6.
    assert slopes[..., 0] == pytest.approx(np.broadcast_to(expected, (n, n)), abs=depth * np.pi * 2e-4)
    assert np.abs(slopes[..., 1]).max() == 0.0


def test_channels_are_taken_apart_and_upright(tmp_path) -> None:
    pixels = np.zeros((2, 2, 3), np.uint8)
    pixels[0] = [10, 51, 255]  # the upper row
    path = stored(tmp_path / "arm.png", pixels)
    rough = ChannelMap(asset=asset(path), channel="green")
    gloss = ChannelMap(asset=asset(path), channel="green", inverted=True)
    metal = ChannelMap(asset=asset(path), channel="blue")
    found = bake_maps(material(roughness_map=rough, metallic_map=metal, metallic=0.5))
    assert found[:, 0, 2] == pytest.approx([0.0, 0.2])
    assert found[:, 0, 3] == pytest.approx([0.0, 0.5])
    assert mean_roughness(material(roughness_map=gloss)) == pytest.approx(0.9)
    assert mean_metallic(material(metallic_map=metal, metallic=1.0)) == pytest.approx(0.5)
    assert mean_metallic(material(metallic=0.25)) == 0.25


def test_maps_of_different_sizes_become_one_array(tmp_path) -> None:
    small = stored(tmp_path / "r.png", np.full((2, 2, 3), 128, np.uint8))
    large = stored(tmp_path / "n.png", np.full((8, 16, 3), [128, 128, 255], np.uint8))
    maps = bake_maps(material(roughness_map=ChannelMap(asset=asset(small)), normal_map=NormalMap(asset=asset(large))))
    assert maps.shape == (8, 16, 4)
    assert maps[..., 2] == pytest.approx(128 / 255)


def test_descriptions_without_maps_are_stored_as_before() -> None:
    assert material().model_dump(mode="json").keys() == {"name", "base_colour", "repeats", "roughness", "metallic"}
    assert not material().is_mapped
