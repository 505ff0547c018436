"""Prints on tables: flat on the top, whole, of the sizes that they state, and nothing without the setting."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.randomness import stream
from glassware.procedural.description.material import OpaqueMaterial, SurfaceTexture, UniformTexture, VertexColours
from glassware.procedural.description.surroundings import Table, TablePrint
from glassware.procedural.patterns.bake import bake_material
from glassware.procedural.patterns.markers import marker_cells
from glassware.procedural.surroundings.table import TableSettings, draw_table, outline
from glassware.procedural.tables.kinds import TABLE_KINDS
from glassware.procedural.tables.printed_top import MOST_TEXELS, TEXEL, PrintedTop, printed_top
from glassware.procedural.tables.prints import DEFAULT_PRINTS, PRINT_KINDS, PRINTED_TABLES, draw_prints

WHITE = OpaqueMaterial(name="paper", base_colour=UniformTexture(colour=(0.8, 0.8, 0.8)), roughness=0.9)


def _table(kind: str, seed: int, probability: float = 1.0, **fields: object) -> Table:
    settings = TableSettings.model_validate({"kinds": [kind], "print_probability": probability, **fields})
    return draw_table(
        *(stream(seed, 0, "table"), settings, ()), *(stream(seed, 0, name) for name in ("kind", "prints"))
    )


def _with(table: Table, *prints: TablePrint) -> Table:
    return table.model_copy(update={"prints": prints})


def _print(angle: float = 0.0, size: tuple[float, float] = (0.210, 0.297), **fields: object) -> TablePrint:
    return TablePrint.model_validate(
        {"kind": "sheet", "centre": (0.05, -0.03), "angle": angle, "size": size, "material": WHITE} | fields
    )


def _is_print(top: PrintedTop) -> np.ndarray:
    return np.abs(top.colour - 0.8).max(axis=2) < 1e-3


def test_without_the_setting_a_table_is_the_same_and_has_none() -> None:
    for kind in TABLE_KINDS:
        plain, never = _table(kind, 3, 0.0), _table(kind, 3, 0.0, prints=[9, 9])
        assert plain.prints == never.prints == ()
        assert plain.material == _table(kind, 3).material
        assert "prints" not in plain.model_dump()
        np.testing.assert_array_equal(plain.mesh.vertices, _table(kind, 3).mesh.vertices)


@pytest.mark.parametrize("kind", TABLE_KINDS)
def test_boards_have_prints_and_all_of_each_lies_on_the_flat_top(kind: str) -> None:
    for seed in range(3):
        table = _table(kind, seed, prints=[3, 3], smallest=0.6, largest=0.9)
        assert (len(table.prints) >= 3) == (kind in PRINTED_TABLES)
        top = outline(table)
        sides = np.roll(top, -1, axis=0) - top
        for item in table.prints:
            away = item.corners[:, None] - top
            assert (sides[:, 0] * away[..., 1] - sides[:, 1] * away[..., 0] > 0.0).all()
            sizes = np.linalg.norm(np.diff(item.corners, axis=0), axis=1)
            assert sizes[:2] == pytest.approx(item.size)


def test_all_kinds_are_drawn_and_another_seed_draws_others() -> None:
    square = np.array([[-0.8, -0.8], [0.8, -0.8], [0.8, 0.8], [-0.8, 0.8]])
    drawn = [draw_prints(stream(seed, 0, "p"), dict.fromkeys(PRINT_KINDS, 1.0), 9, square, 0.2) for seed in range(8)]
    assert {item.kind for items in drawn for item in items} == set(PRINT_KINDS)
    assert {entry.partition("=")[0] for entry in DEFAULT_PRINTS} == set(PRINT_KINDS)
    assert len({item.centre for items in drawn for item in items}) == sum(len(items) for items in drawn)
    assert drawn[0] == draw_prints(stream(0, 0, "p"), dict.fromkeys(PRINT_KINDS, 1.0), 9, square, 0.2)


def test_mats_lie_below_paper_and_paper_below_markers() -> None:
    square = np.array([[-0.8, -0.8], [0.8, -0.8], [0.8, 0.8], [-0.8, 0.8]])
    kinds = [item.kind for item in draw_prints(stream(1, 0, "p"), {"mat": 1, "sheet": 1, "markers": 1}, 12, square, 0)]
    assert len(set(kinds)) == 3
    assert kinds == sorted(kinds, key=["mat", "sheet", "markers"].index)


def test_a_print_that_fits_nowhere_is_refused_with_its_size() -> None:
    small = np.array([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]])
    with pytest.raises(InputError, match=r"table.print_kinds.*0.20 x 0.20 m.*mat, such as one of"):
        draw_prints(stream(1, 0, "p"), {"mat": 1.0}, 1, small, 0.0)
    with pytest.raises(ValueError, match=r"matt.*mat"):
        TableSettings.model_validate({"print_kinds": ["matt"]})


def test_a_kind_that_does_not_fit_gives_way_to_those_that_do() -> None:
    """On a shelf 20 cm deep no newspaper lies whole, and no place mat."""
    shelf = np.array([[-0.6, -0.1], [0.6, -0.1], [0.6, 0.1], [-0.6, 0.1]])
    kinds = {"newspaper": 5.0, "mat": 5.0, "sticker": 1.0}
    for seed in range(10):
        drawn = draw_prints(stream(seed, 0, "p"), kinds, 3, shelf, 0.0)
        assert [item.kind for item in drawn] == ["sticker"] * 3
    with pytest.raises(InputError, match=r"table.print_kinds.*1.20 x 0.20 m"):
        draw_prints(stream(1, 0, "p"), {"newspaper": 5.0, "mat": 5.0}, 1, shelf, 0.0)


@pytest.mark.parametrize("kind", ["wood", "tiles", "plain"])
@pytest.mark.parametrize("angle", [0.0, 0.4])
def test_a_print_has_its_size_and_place_in_metres_to_a_texel(kind: str, angle: float) -> None:
    item = _print(angle)
    top = printed_top(_with(_table(kind, 2, 0.0, round_share=0.0), item))
    assert max(top.texel) < 1.2 * TEXEL
    rows, columns = np.nonzero(_is_print(top))
    x, y = ((index + 0.5) * top.texel[k] + top.corner[k] for k, index in enumerate((columns, rows)))
    assert len(x) * top.texel[0] * top.texel[1] == pytest.approx(0.210 * 0.297, abs=2 * (0.210 + 0.297) * TEXEL)
    assert (x.mean(), y.mean()) == pytest.approx(item.centre, abs=TEXEL)
    found = np.array([x.min(), y.min(), x.max(), y.max()])
    assert found == pytest.approx(np.concatenate([item.corners.min(0), item.corners.max(0)]), abs=2 * TEXEL)


@pytest.mark.parametrize("kind", ["wood", "tiles", "plain"])
def test_beside_prints_the_top_is_the_table_s_own_and_its_mesh_is_the_same(kind: str) -> None:
    table = _table(kind, 5, 0.0, smallest=0.5, largest=0.7)
    own, _ = bake_material(table.material)
    top = printed_top(_with(table, _print()))
    np.testing.assert_array_equal(top.mesh.vertices, table.mesh.vertices)
    np.testing.assert_array_equal(top.mesh.faces, table.mesh.faces)
    beside = top.colour[~_is_print(top)]
    assert beside.mean(axis=0) == pytest.approx(own.mean(axis=(0, 1)), abs=0.04)
    assert top.maps[~_is_print(top)][:, 2].mean() == pytest.approx(table.material.roughness, abs=0.15)
    assert top.maps[_is_print(top)][:, 2] == pytest.approx(0.9)
    # Texture coordinates still say where a place of the top is in the picture.
    assert top.mesh.uv is not None
    flat = (table.mesh.vertices[:, 2] == 0.0) & (top.mesh.uv[:, 0] > 0.01)
    shown = top.mesh.uv[flat] * np.array(top.texel) * top.colour.shape[1::-1] + top.corner
    np.testing.assert_allclose(shown, table.mesh.vertices[flat, :2], atol=1e-5)


def test_the_relief_of_a_print_turns_with_it() -> None:
    board = _table("plain", 2, 0.0)
    texture = SurfaceTexture(
        pattern="ribbed rubber", colours=((0.1, 0.1, 0.1),), seed=4, extent=(0.2, 0.2), size=(256, 256)
    )
    ribs = OpaqueMaterial(name="rubber", base_colour=texture, roughness=0.9)
    places = np.random.default_rng(3).uniform(-0.09, 0.09, (400, 2))
    found = []
    for angle in (0.0, np.pi / 2):
        top = printed_top(_with(board, _print(angle, (0.2, 0.2), material=ribs)))
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        columns, rows = np.floor((places @ turn.T + (0.05, -0.03) - top.corner) / top.texel).astype(int).T
        # Slopes back in the frame of the print.
        found.append(top.maps[rows, columns, :2] @ turn)
    for axis in range(2):
        if np.std(found[0][:, axis]) > 0.01:
            assert np.corrcoef(found[0][:, axis], found[1][:, axis])[0, 1] > 0.8
    assert max(np.std(one) for one in found) > 0.01


@pytest.mark.slow
def test_a_large_table_has_no_more_texels_than_memory_allows() -> None:
    board = _table("laminate", 1, 0.0, smallest=4.0, largest=4.0, round_share=0.0)
    top = printed_top(_with(board, _print()))
    assert top.colour.shape[0] * top.colour.shape[1] <= 1.02 * MOST_TEXELS


def test_a_marker_has_a_dark_border_and_random_cells_of_both_colours() -> None:
    rng = np.random.default_rng(2)
    cells = [marker_cells(rng, 8) for _ in range(50)]
    for one in cells:
        assert one.shape == (8, 8)
        border = np.ones((8, 8), bool)
        border[1:-1, 1:-1] = False
        assert (one[border] == 1.0).all()
        assert {*np.unique(one[1:-1, 1:-1])} == {0.0, 1.0}
    assert len({one.tobytes() for one in cells}) == len(cells)


def test_a_print_needs_a_texture_and_a_table_that_can_show_one() -> None:
    with pytest.raises(ValueError, match="expected a texture"):
        _print(material=WHITE.model_copy(update={"base_colour": VertexColours()}))
    board = _table("wood", 1, 0.0)
    with pytest.raises(ValueError, match="prints: expected a table with a texture"):
        Table(
            mesh=board.mesh,
            material=WHITE.model_copy(update={"base_colour": VertexColours()}),
            size=board.size,
            prints=(_print(),),
        )
