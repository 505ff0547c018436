"""Kinds of tables: closed, flat at z = 0 where things stand, with materials at a scale in metres."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.mesh import check_closed
from glassware.core.randomness import stream
from glassware.procedural.description.material import SurfaceTexture
from glassware.procedural.description.surroundings import Table
from glassware.procedural.surroundings.table import EDGE_RADIUS, SHELF_DEPTH, TableSettings, draw_table, outline
from glassware.procedural.tables.forms import BASIN, BEND, DROP
from glassware.procedural.tables.kinds import DEFAULT_TABLES, TABLE_KINDS


def _table(kind: str, seed: int) -> Table:
    settings = TableSettings.model_validate({"kinds": [kind]})
    return draw_table(stream(seed, 0, "table"), settings, (), stream(seed, 0, "table/kind"))


@pytest.mark.parametrize("kind", TABLE_KINDS)
def test_a_table_is_closed_hangs_below_its_top_and_holds_a_scene(kind: str) -> None:
    for seed in range(3):
        table = _table(kind, seed)
        assert table.kind == kind
        check_closed(kind, table.mesh)
        low, high = table.mesh.bounds
        assert high[2] == 0.0
        assert np.allclose(high - low, table.size, atol=1e-5)
        assert np.allclose(low[:2], -high[:2], atol=1e-6)
        top = outline(table)
        # The disc in which objects are placed lies on it, with their edge.
        sides = np.roll(top, -1, axis=0) - top
        inwards = np.stack([-sides[:, 1], sides[:, 0]], 1) / np.linalg.norm(sides, axis=1, keepdims=True)
        assert (-(top * inwards).sum(1)).min() > 0.16
        assert isinstance(table.material.base_colour, SurfaceTexture) == (kind != "plain")


@pytest.mark.parametrize("kind", [kind for kind in TABLE_KINDS if kind != "plain"])
def test_texture_coordinates_on_the_top_are_metres(kind: str) -> None:
    table = _table(kind, 1)
    assert table.mesh.uv is not None
    assert table.mesh.normals is not None
    top = (table.mesh.vertices[:, 2] == 0.0) & (table.mesh.normals[:, 2] > 0.99)
    shift = table.mesh.uv[top] - table.mesh.vertices[top, :2]
    assert np.ptp(shift, axis=0).max() < 1e-5
    texture = table.material.base_colour
    assert isinstance(texture, SurfaceTexture)
    up = table.material.repeats_v or table.material.repeats
    assert (1 / table.material.repeats, 1 / up) == pytest.approx(texture.extent)


def test_a_cloth_hangs_in_folds_without_being_stretched() -> None:
    for seed in range(4):
        mesh = _table("cloth", seed).mesh
        # Corners hang lower than the rest.
        assert DROP[0] <= -mesh.bounds[0, 2] <= 1.5 * DROP[1]
        assert mesh.uv is not None
        vertices, uv = mesh.vertices.astype(float), mesh.uv.astype(float)
        ends = [(mesh.faces[:, k], mesh.faces[:, (k + 1) % 3]) for k in range(3)]
        a, b = (np.concatenate(side) for side in zip(*ends, strict=True))
        length, shown = np.linalg.norm(vertices[a] - vertices[b], axis=1), np.linalg.norm(uv[a] - uv[b], axis=1)
        hanging = (vertices[a, 2] < -BEND) & (vertices[b, 2] < -BEND) & (shown > 0.004)
        # At the corners a cloth has more to hang than here.
        assert np.percentile(shown[hanging] / length[hanging], [5, 90]) == pytest.approx([1.0, 1.0], abs=0.15)


def test_a_counter_has_a_sink_on_which_nothing_stands() -> None:
    for seed in range(4):
        table = _table("steel", seed)
        assert table.mesh.bounds[0, 2] == pytest.approx(-BASIN[2], abs=0.01)
        top = outline(table)
        assert np.ptp(top[:, 0]) < table.size[0] - BASIN[0]


def test_a_shelf_is_as_deep_as_shelves_are() -> None:
    for seed in range(5):
        assert SHELF_DEPTH[0] <= min(_table("shelf", seed).size[:2]) <= SHELF_DEPTH[1]


def test_settings_name_all_kinds_and_refuse_others() -> None:
    assert {entry.partition("=")[0] for entry in DEFAULT_TABLES} == set(TABLE_KINDS)
    with pytest.raises(ValueError, match=r"stones.*stone"):
        TableSettings.model_validate({"kinds": ["stones"]})


def test_the_pattern_of_a_board_goes_on_over_its_edges() -> None:
    table = draw_table(stream(4, 0, "table"), TableSettings(kinds=("wood",), round_share=0.0), (), stream(4, 0, "kind"))
    mesh = table.mesh
    assert mesh.uv is not None
    # Both faces at an edge have the same texture there, but for the shorter way around its rounding.
    positions, index = np.unique(mesh.vertices, axis=0, return_inverse=True)
    above = positions[:, 2] > -0.4 * table.size[2]
    low, high = (np.full((len(positions), 2), fill) for fill in (np.inf, -np.inf))
    np.minimum.at(low, index.reshape(-1), mesh.uv)
    np.maximum.at(high, index.reshape(-1), mesh.uv)
    assert (high - low)[above].max() < 0.5 * EDGE_RADIUS[1]
