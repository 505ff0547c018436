"""``glassware assets``: what it says of a folder."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from glassware.dataset.commands.assets import main
from glassware.dataset.preview.asset_sheet import asset_sheet


def test_a_folder_is_listed_with_what_is_left_out_and_what_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    box = trimesh.creation.box((0.1, 0.05, 0.04)).export(file_type="stl")
    assert isinstance(box, bytes)
    for name in ("025_mug/google_16k/textured.stl", "025_mug/tsdf/textured.stl", "toy.stl"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(box)
    (tmp_path / "broken.glb").write_bytes(b"glTF")
    (tmp_path / "tool.FBX").write_bytes(b"Kaydara")
    (tmp_path / "LICENSE").write_text("CC0 1.0")
    assert main([str(tmp_path), "--most", "0"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[1] == "layout: ycb 1, plain 1"
    assert (
        "  025_mug/google_16k/textured.stl: 100 mm, 12 faces, 1 part (1 no material), category mug, licence CC BY 4.0"
        in said
    )
    assert "  toy.stl: 100 mm, 12 faces, 1 part (1 no material), licence CC0" in said
    assert "  025_mug/tsdf/textured.stl: the same object as 025_mug/google_16k/textured.stl" in said
    assert said[-4:] == [
        "not read: 1 file (.fbx); Blender and others write them as GLB",
        "  tool.FBX",
        "mesh_dir: 1 file passed over",
        "  broken.glb: expected a readable GLB mesh, found one that is cut short (4 of 12 bytes)",
    ]


def test_further_files_of_a_vessel_are_listed(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    for suffix in ("ply", "stl"):
        trimesh.creation.box((0.1, 0.05, 0.04)).export(tmp_path / f"block.{suffix}")
    assert main([str(tmp_path), "--glass", "--most", "0"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].endswith(": 1 object, 1 further file of these")
    assert "  block.stl: the same object as block.ply" in said


def test_a_folder_that_is_not_there_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    assert main([str(tmp_path / "gone"), "--most", "0"]) == 2
    assert "gone: expected a folder of meshes, found no such folder" in capsys.readouterr().err


def test_a_sheet_has_a_cell_for_each_picture(rng: np.random.Generator) -> None:
    pictures = [rng.integers(0, 255, (20, 30, 3)).astype("uint8") for _ in range(5)]
    sheet = asset_sheet(pictures, [("a name that is long", "10 mm")] * 5)
    for picture in pictures:
        windows = [
            (y, x) for y in range(sheet.shape[0] - 20) for x in (6, 42, 78) if (sheet[y, x] == picture[0, 0]).all()
        ]
        assert any((sheet[y : y + 20, x : x + 30] == picture).all() for y, x in windows)
