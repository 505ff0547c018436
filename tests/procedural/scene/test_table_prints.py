"""Prints on tables in scenes: drawn from a stream of their own, kept in the file, metered, and refused off the top."""

from __future__ import annotations

from pathlib import Path

import pytest

import glassware as gw
from glassware.core.images import KNEE
from glassware.dataset.format.scene_outline import read_outline
from glassware.procedural.description.scene import Scene
from glassware.procedural.description.surroundings import ConstantEnvironment, TablePrint
from glassware.procedural.primitives import scenes
from glassware.procedural.scene.validate import check_scene
from glassware.procedural.surroundings.environments import bake_environment
from glassware.procedural.surroundings.photographer import camera_exposure

FEW = {
    "vessel_count": (0, 0),
    "prop_count": (1, 1),
    "environment": {"room_share": 0.0, "shipped_share": 0.0},
    "cameras": {"views": 1, "width": 32, "height": 24},
}


def _drawn(probability: float) -> Scene:
    return gw.draw(seed=4, table={"kinds": ["laminate"], "print_probability": probability, "prints": [4, 4]}, **FEW)


def _sheet(centre: tuple[float, float], reflectance: float = 0.9) -> TablePrint:
    paper = scenes.matte((reflectance, reflectance, reflectance), "paper")
    return TablePrint(kind="sheet", centre=centre, size=(0.297, 0.21), material=paper)


def test_prints_change_nothing_else_of_a_scene_but_its_exposure() -> None:
    without, having = (_drawn(probability).model_dump(mode="json") for probability in (0.0, 1.0))
    assert len(having["table"].pop("prints")) >= 4
    for camera in (*without["cameras"], *having["cameras"]):
        assert camera.pop("exposure") > 0.0
        camera.pop("balance", None)
    assert having == without


def test_a_scene_file_has_the_prints_and_reads_them_back(tmp_path: Path) -> None:
    scene = _drawn(1.0)
    gw.save_scene(scene, tmp_path / "scene.json")
    assert gw.load_scene(tmp_path / "scene.json").table.prints == scene.table.prints
    assert read_outline(tmp_path).prints == tuple(item.kind for item in scene.table.prints)


def test_a_print_beside_the_top_is_refused_with_where_it_is() -> None:
    board = scenes.board((0.8, 0.6, 0.03))
    view = scenes.camera((0.0, -0.5, 0.5), width=32, height=24)
    check_scene(scenes.scene([], [view], table=board.model_copy(update={"prints": (_sheet((0.25, 0.0)),)})))
    beside = scenes.scene([], [view], table=board.model_copy(update={"prints": (_sheet((0.3, 0.0)),)}))
    with pytest.raises(gw.InputError, match=r"table, prints 0 \(sheet\): expected .*flat top, x -0.400 to 0.400.*0.44"):
        check_scene(beside)


def test_white_paper_on_a_dark_table_is_kept_from_being_blown_out() -> None:
    even = ConstantEnvironment(radiance=(1.0, 1.0, 1.0))
    board = scenes.board((0.8, 0.6, 0.03), scenes.matte((0.05, 0.05, 0.05)))
    printed = board.model_copy(update={"prints": (_sheet((0.0, 0.0), 0.95),)})
    (dark, _), (found, light) = (camera_exposure(one, even, bake_environment(even), ()) for one in (board, printed))
    assert found < dark
    assert found * 0.95 * light[0] / 3.141592653589793 == pytest.approx(KNEE, rel=1e-3)
