"""The examples do what they say, at a small size; the notebook's cells run one after the other."""

from __future__ import annotations

import ast
import contextlib
import io
import json
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from pycocotools.coco import COCO

import glassware as gw
from glassware.dataset.commands import render_scene
from glassware.dataset.format.pictures import read_png
from glassware.dataset.settings.config import merged

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
SMALL = ["--views", "1", "--width", "48", "--height", "36", "--spp", "2", "--vessel-count", "1", "2"]


def run(program: str, *arguments: str) -> str:
    """Run an example in this process and return what it printed; its exit code is 0."""
    printed, before = io.StringIO(), sys.argv
    sys.argv = [program, *arguments]
    try:
        with contextlib.redirect_stdout(printed), pytest.raises(SystemExit) as stopped:
            runpy.run_path(str(EXAMPLES / program), run_name="__main__")
    finally:
        sys.argv = before
    assert stopped.value.code == 0
    return printed.getvalue()


@pytest.fixture(scope="module")
def data(backend, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set of one small view."""
    folder = tmp_path_factory.mktemp("examples")
    small = ["--vessels.chord-error", "1e-4", "--prop-count", "1", "1"]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        assert render_scene.main(["--seed", "7", "--out", str(folder / "out"), *SMALL, *small]) == 0
    return folder / "out"


#: pycocotools 2.0.10 hands NumPy an array of its own that has no `copy`.
@pytest.mark.filterwarnings("ignore:__array__ implementation doesn't accept a copy keyword")
def test_masks_go_into_a_coco_file_that_its_own_reader_takes(data: Path) -> None:
    assert "1 images" in run("coco_masks.py", str(data))
    with contextlib.redirect_stdout(io.StringIO()):
        found = COCO(str(data / "coco.json"))
    labels = {label.name: label for label in gw.Dataset.open(data).views()[0].labels().objects}
    shown = [mask for mask in gw.masks(gw.Dataset.open(data).views()[0].labels(), "seen").values() if mask.any()]
    entries = found.loadAnns(found.getAnnIds())
    assert len(entries) == len(shown) > 0
    for entry, mask in zip(entries, shown, strict=True):
        np.testing.assert_array_equal(found.annToMask(entry), mask)
        rows, columns = np.nonzero(mask)
        corner = [columns.min(), rows.min()]
        assert entry["bbox"] == [*corner, columns.max() + 1 - corner[0], rows.max() + 1 - corner[1]]
        assert entry["area"] == mask.sum()
    run("coco_masks.py", str(data), "--vessels-only", "--out", str(data / "vessels.json"))
    kinds = {kind["name"] for kind in json.loads((data / "vessels.json").read_text())["categories"]}
    vessels = {vessel.name for vessel in gw.Dataset.open(data).scenes[0].scene().vessels}
    assert kinds == {label.category for name, label in labels.items() if name in vessels}


def test_a_view_becomes_a_point_cloud_in_its_colours(data: Path) -> None:
    out = data / "cloud.ply"
    printed = run("point_cloud.py", str(data), "--out", str(out))
    view = gw.Dataset.open(data).views()[0]
    cloud: Any = trimesh.load(out)
    assert printed == f"{out}: {len(cloud.vertices)} points\n"
    np.testing.assert_allclose(cloud.vertices, view.points("world"), atol=1e-6)
    hit = np.isfinite(view.geometry().Z)
    np.testing.assert_array_equal(np.asarray(cloud.colors)[:, :3], view.picture("left")[hit])
    run("point_cloud.py", str(data), "--out", str(out), "--behind")
    behind: Any = trimesh.load(out)
    assert len(behind.vertices) == np.isfinite(view.geometry().background_Z).sum()


def test_a_changed_scene_is_rendered_and_its_masks_are_counted(data: Path, tmp_path: Path) -> None:
    picture = tmp_path / "changed.png"
    printed = run("change_a_scene.py", str(data / "scenes/000000/scene.json"), "--picture", str(picture))
    assert read_png(picture).shape == (36, 48, 3)
    assert "vessel-00: " in printed


@pytest.mark.slow
def test_the_gap_makes_a_glass_of_water_look_otherwise(backend, tmp_path: Path) -> None:
    picture = tmp_path / "both.png"
    run("shared_interface.py", "--out", str(picture), "--width", "64", "--spp", "16")
    both = read_png(picture).astype(float)
    assert both.shape == (64, 2 * 64 + 8, 3)
    left, right = both[:, :64], both[:, 72:]
    # Above the glass there is nothing but the card, which both show.
    assert np.abs(left - right)[18:60, 18:48].mean() > 3.0 * np.abs(left - right)[:, :8].mean()


@pytest.mark.slow
def test_the_notebook_runs_and_its_results_show_themselves(backend, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    small = {"cameras": {"scale": 0.05}, "picture": {"spp": 2}, "vessels": {"chord_error": 1e-4}}
    draw = gw.draw
    monkeypatch.setattr(gw, "draw", lambda seed, **settings: draw(seed, **merged(settings, small)))
    cells = json.loads((EXAMPLES / "first_afternoon.ipynb").read_text("utf-8"))["cells"]
    names: dict[str, Any] = {"__name__": "__main__"}
    shown = []
    for cell in cells:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == []
            body = ast.parse("".join(cell["source"])).body
            last = body[-1]
            with contextlib.redirect_stdout(io.StringIO()):
                if not isinstance(last, ast.Expr):
                    exec(compile(ast.Module(body, []), "notebook", "exec"), names)
                else:
                    exec(compile(ast.Module(body[:-1], []), "notebook", "exec"), names)
                    shown.append(eval(compile(ast.Expression(last.value), "notebook", "eval"), names))
    kinds = [type(value).__name__ for value in shown]
    assert kinds[:2] == ["Scene", "Frame"]
    assert kinds[-1] == "Dataset"
    for value in shown:
        if type(value).__name__ in ("Scene", "Frame", "Dataset"):
            assert "<img" in value._repr_html_() or "<svg" in value._repr_html_()
