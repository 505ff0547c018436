"""Surfaces with holes in the opacity of their picture."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.mesh_files.cutouts import cut
from glassware.procedural.mesh_files.model import Cutout, FilePart, Look


def _card(opacity: np.ndarray, uv: np.ndarray) -> FilePart:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    look = Look(cutout=Cutout(opacity.astype(np.float32), 0.5))
    return FilePart(corners, np.array([[0, 1, 2], [0, 2, 3]]), look, uv=uv)


@pytest.mark.parametrize("repeats", [1, 3])
def test_a_card_keeps_the_area_that_its_opacity_leaves(repeats: int) -> None:
    y, x = (np.mgrid[:64, :64] + 0.5) / 64
    disc = (x - 0.5) ** 2 + (y - 0.5) ** 2 < 0.4**2
    uv = repeats * np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    part = cut(_card(disc, uv))
    corners = part.vertices[part.faces]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    assert area.sum() == pytest.approx(np.pi * 0.4**2, rel=0.04)
    assert part.uv is not None
    assert np.allclose(part.uv, repeats * part.vertices[:, :2])


def test_the_lower_half_of_a_picture_is_the_lower_half_of_a_card() -> None:
    opacity = np.zeros((8, 8))
    opacity[4:] = 1.0  # lower rows
    part = cut(_card(opacity, np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)))
    assert part.vertices[:, 1].max() == pytest.approx(0.5, abs=0.15)


def test_a_masked_material_of_a_glb_is_cut_and_a_solid_one_is_not(makers: ModuleType, tmp_path: Path) -> None:
    material = {"alphaMode": "MASK", **makers.surface(baseColorTexture={"index": 0})}
    clear, solid = (
        makers.written(tmp_path, {f"{a}.glb": makers.glb([material], makers.png((9, 9, 9, a)))}) / f"{a}.glb"
        for a in (0, 255)
    )
    assert len(makers.parts_of(solid)[0][0].faces) == 4
    with pytest.raises(InputError, match="a mesh with faces, found none that its opacity leaves"):
        makers.parts_of(clear)
