"""Patterns: reflectances that can be, features of the size that they say, no seams where they repeat."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from pydantic import ValidationError

from glassware.procedural.description.material import OpaqueMaterial, SurfacePattern, SurfaceTexture
from glassware.procedural.materials.textures import bake
from glassware.procedural.patterns.bake import PATTERNS, bake_material, bake_surface
from glassware.procedural.patterns.grid import Grid, covered
from glassware.procedural.patterns.skins import cube_directions

COLOURS = ((0.6, 0.5, 0.4), (0.2, 0.1, 0.05), (0.1, 0.2, 0.5), (0.03, 0.03, 0.03))
LAYOUTS = {"carton": (0.3,), "cover": (0.1,), "marker": (8.0,)}
#: Largest relative difference between a counted length and the drawn one: a whole number of them fits the picture.
COUNTED = 0.2


def _surface(pattern: str, extent: tuple[float, float] = (0.24, 0.16), **fields: object) -> SurfaceTexture:
    sizes = {"extent": extent, "size": (96, 64), "colours": COLOURS, "seed": 5, "layout": LAYOUTS.get(pattern, ())}
    return SurfaceTexture.model_validate({"pattern": pattern} | sizes | fields)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_pattern_gives_reflectances_roughness_and_relief_by_its_numbers_alone(pattern: str) -> None:
    new, worn = bake_surface(_surface(pattern)), bake_surface(_surface(pattern, wear=1.0))
    for layers in (new, worn):
        assert layers.colour.shape == (64, 96, 3)
        assert layers.roughness.shape == layers.height.shape == (64, 96)
        assert {layers.colour.dtype, layers.roughness.dtype, layers.height.dtype} == {np.dtype(np.float32)}
        assert 0.0 <= layers.colour.min() <= layers.colour.max() <= 1.0
        assert layers.roughness.min() >= 0.0
        assert np.ptp(layers.height) < 0.004
    assert not np.array_equal(new.colour, worn.colour)
    other = bake_surface(_surface(pattern, seed=6))
    assert not (np.array_equal(new.colour, other.colour) and np.array_equal(new.roughness, other.roughness))


def test_all_patterns_of_the_description_are_there() -> None:
    assert tuple(PATTERNS) == get_args(SurfacePattern)


@pytest.mark.parametrize("size", [0.004, 0.02])
def test_noise_has_features_of_the_size_asked_for(size: float) -> None:
    grid = Grid(0.4, 0.4, 512, 512, np.random.default_rng(3))
    noise = grid.noise(size)
    zeros = np.count_nonzero(np.diff(np.sign(noise), axis=1)) / 512
    assert 0.4 / zeros == pytest.approx(size, rel=0.08)
    assert noise.std() == pytest.approx(1.0, rel=0.15)


def test_chequers_tiles_and_threads_have_their_widths_in_metres() -> None:
    squares = bake_surface(_surface("chequer", (0.4, 0.4), size=(400, 400))).colour[..., 0]
    edges = np.count_nonzero(np.abs(np.diff(squares[13])) > 0.2)
    assert 0.015 * (1 - COUNTED) <= 0.4 / (edges + 1) <= 0.05 * (1 + COUNTED)
    height = bake_surface(_surface("tiles", (0.6, 0.6), size=(600, 600))).height
    joints = height < np.median(height) - 4e-4
    rows = np.flatnonzero(joints.mean(axis=1) > 0.9)
    assert 2 <= len(np.split(rows, np.flatnonzero(np.diff(rows) > 3) + 1)) <= 13
    cloth = bake_surface(_surface("cloth", (0.03, 0.03), size=(300, 300))).height
    spectrum = np.abs(np.fft.rfft(cloth - cloth.mean(), axis=1)).mean(axis=0)
    # A plain weave repeats after two threads.
    assert 0.0005 * (1 - COUNTED) <= 0.03 / (5 + np.argmax(spectrum[5:])) <= 0.0024 * (1 + COUNTED)


def test_the_grain_of_wood_runs_along_its_boards() -> None:
    for pattern in ("planks", "staves", "solid wood"):
        colour = bake_surface(_surface(pattern, (1.0, 0.5), size=(400, 400))).colour.mean(axis=2)
        along, across = np.abs(np.diff(colour, axis=1)).mean() / 2.5, np.abs(np.diff(colour, axis=0)).mean() / 1.25
        assert across > 3.0 * along


@pytest.mark.parametrize("pattern", ["granite", "cloth", "brushed metal", "lacquer", "laminate", "tiles", "marble"])
def test_a_repeated_pattern_has_no_seam(pattern: str) -> None:
    # Away from the lines of tiles and threads, whose own edges lie at the border.
    colour = bake_surface(_surface(pattern, (0.48, 0.32), size=(480, 320))).colour.mean(axis=2)
    inside = np.abs(np.diff(colour, axis=1)).mean(axis=0)
    assert np.abs(colour[:, 0] - colour[:, -1]).mean() <= 1.5 * inside.max()


def test_skins_meet_at_the_edges_of_the_cube() -> None:
    directions = cube_directions(3 * 20, 2 * 20)
    assert np.allclose(np.linalg.norm(directions, axis=2), 1.0)
    faces = directions.reshape(2, 20, 3, 20, 3).transpose(0, 2, 1, 3, 4).reshape(6, 20, 20, 3)
    rims = [np.concatenate([face[0], face[-1], face[:, 0], face[:, -1]]) for face in faces]
    for number, rim in enumerate(rims):
        others = np.concatenate([other for index, other in enumerate(rims) if index != number])
        nearest = np.linalg.norm(rim[:, None] - others[None], axis=2).min(axis=1)
        assert nearest.max() < 1e-9
    assert np.allclose(faces[4].mean((0, 1)) / np.linalg.norm(faces[4].mean((0, 1))), [0, 0, 1])


def test_a_line_covers_as_much_of_the_texels_as_it_is_wide() -> None:
    distance = np.abs(np.arange(-50, 51) * 0.001)
    for width in (0.0004, 0.003, 0.0101):
        assert covered(distance, width / 2, 0.001).sum() * 0.001 == pytest.approx(width, rel=0.15)


def test_relief_tilts_normals_by_its_slope() -> None:
    texture = _surface("tiles", (0.6, 0.6), size=(300, 300))
    made = OpaqueMaterial(name="tiles", base_colour=texture, roughness=0.2)
    assert made.is_mapped
    colour, maps = bake_material(made)
    height = bake_surface(texture).height
    assert maps is not None
    assert colour.shape == (300, 300, 3)
    assert maps[40, 60, 0] == pytest.approx((height[40, 61] - height[40, 59]) / 0.004, abs=1e-5)
    assert maps[40, 60, 1] == pytest.approx((height[41, 60] - height[39, 60]) / 0.004, abs=1e-5)
    flat = made.model_copy(update={"base_colour": texture.model_copy(update={"relief": False})})
    assert bake_material(flat)[1] is None
    assert not flat.is_mapped


def test_a_surface_is_no_plain_texture_and_a_wrong_layout_is_refused() -> None:
    with pytest.raises(ValueError, match="expected a texture without relief"):
        bake(_surface("planks"))
    for pattern, layout in (("carton", ()), ("planks", (0.3,))):
        with pytest.raises(ValidationError, match="layout"):
            _surface(pattern, layout=layout)
