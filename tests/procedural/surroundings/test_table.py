"""The table."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from glassware.core.mesh import as_trimesh
from glassware.procedural.description.surroundings import Table
from glassware.procedural.materials.surface_files import SurfaceFiles
from glassware.procedural.surroundings.table import EDGE_RADIUS, THICKNESS, TableSettings, draw_table, outline

SEEDS = range(20)


def _tables(round_share: float) -> list[Table]:
    return [draw_table(np.random.default_rng(seed), TableSettings(round_share=round_share)) for seed in SEEDS]


BOTH = pytest.mark.parametrize("round_share", [0.0, 1.0])


@BOTH
def test_the_top_is_exactly_flat_at_zero_out_to_its_rounded_edge(round_share: float) -> None:
    for table in _tables(round_share):
        vertices = table.mesh.vertices
        assert vertices[:, 2].max() == 0.0
        top = vertices[vertices[:, 2] == 0.0]
        assert (top.max(axis=0)[:2] > np.array(table.size[:2]) / 2 - EDGE_RADIUS[1] - 1e-6).all()
        on_top = (vertices[table.mesh.faces][..., 2] == 0.0).all(axis=1)
        across = vertices[table.mesh.faces][on_top]
        area = np.abs(np.cross(across[:, 1] - across[:, 0], across[:, 2] - across[:, 0])[:, 2]).sum() / 2
        half_x, half_y = np.array(table.size[:2], float) / 2 - EDGE_RADIUS[1]
        # 96 chords enclose 0.07 % less than the circle.
        assert area >= (0.999 * np.pi * half_x**2 if round_share else 4 * half_x * half_y)


@BOTH
def test_a_table_is_a_closed_board_of_the_size_it_states(round_share: float) -> None:
    for table in _tables(round_share):
        assert as_trimesh(table.mesh).is_watertight
        assert as_trimesh(table.mesh).volume > 0
        assert np.ptp(table.mesh.bounds, axis=0) == pytest.approx(table.size, abs=1e-6)
        assert min(table.size[:2]) >= 0.9
        assert max(table.size[:2]) <= 1.8
        assert THICKNESS[0] <= table.size[2] <= THICKNESS[1]


@pytest.mark.parametrize(("round_share", "corners"), [(0.0, 4), (1.0, 96)])
def test_the_outline_runs_round_the_flat_top(round_share: float, corners: int) -> None:
    for table in _tables(round_share):
        line = outline(table)
        assert line.shape == (corners, 2)
        x, y = line.T
        enclosed = 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
        full = table.size[0] * table.size[1] * (np.pi / 4 if round_share else 1.0)
        # The rounded edge takes at most 10 mm off each side of at least 0.9 m.
        assert 0.95 * full < enclosed < full


@BOTH
def test_texture_coordinates_of_the_top_are_metres(round_share: float) -> None:
    for table in _tables(round_share):
        top = table.mesh.vertices[:, 2] == 0.0
        assert table.mesh.uv is not None
        assert np.allclose(table.mesh.uv[top], table.mesh.vertices[top, :2], atol=1e-6)
        assert np.isfinite(table.mesh.uv).all()


def test_a_table_depends_on_its_generator_alone() -> None:
    draw: Callable[[], Table] = lambda: draw_table(np.random.default_rng(7), TableSettings())  # noqa: E731
    assert draw().size == draw().size
    assert draw().material == draw().material


def test_one_repeat_of_the_picture_has_the_width_that_is_given_and_the_pictures_shape(tmp_path: Path) -> None:
    path = tmp_path / "wide.png"
    assert cv2.imwrite(str(path), np.full((20, 40, 3), 128, np.uint8))
    settings = TableSettings.model_validate({"texture_size": "60cm"})
    drawn, given = (
        draw_table(np.random.default_rng(4), one, [SurfaceFiles(path, tmp_path, "wide")])
        for one in (TableSettings(), settings)
    )
    assert given.material.repeats == pytest.approx(1.0 / 0.6)
    assert given.material.repeats_v == pytest.approx(1.0 / 0.3)
    assert given.material.roughness == drawn.material.roughness
    np.testing.assert_array_equal(given.mesh.vertices, drawn.mesh.vertices)
