from __future__ import annotations

import pytest

from glassware.dataset.commands.report import main


def test_a_damaged_scene_is_named_and_left_out(files, page, capsys):
    (files.root / "scenes" / "000001" / "objects.json").write_text("{")
    assert main([str(files.root)]) == 1
    told = capsys.readouterr()
    assert "report.html: 2 scenes" in told.out
    first, second = told.err.splitlines()
    assert first == "1 scene left out"
    assert second.startswith("scene 1: scenes/000001/objects.json: expected a JSON file")
    shown = page(files.root / "report.html")
    assert "scene 1 is left out: scenes/000001/objects.json" in shown.text
    assert shown.statistics("objects")["n"] == 2


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("scene.json", lambda data: data.pop("environment")),
        ("scene.json", lambda data: data["cameras"].clear()),
        ("scene.json", lambda data: data.update(vessels=[1])),
        ("views.json", lambda data: data["views"][0].update(view=7)),
        ("views.json", lambda data: data["views"][0].update(object_ids=[2])),
        ("checksums.json", lambda data: data.update(files=3)),
    ],
)
def test_each_file_of_a_scene_is_checked_as_it_is_read(files, capsys, name, change):
    files.change(files.root / "scenes" / "000002" / name, change)
    assert main([str(files.root)]) == 1
    _, line = capsys.readouterr().err.splitlines()
    assert line.startswith(f"scene 2: scenes/000002/{name}")


def test_a_scene_without_a_picture_is_named(files, capsys):
    (files.views[0] / "left.png").write_bytes(b"no picture")
    assert main([str(files.root)]) == 1
    assert "scene 0: scenes/000000/000/left.png" in capsys.readouterr().err


def test_what_cannot_be_done_is_one_line(files, tmp_path, capsys):
    root = str(files.root)
    (tmp_path / "folder.html").mkdir()
    for arguments, words in (
        ([str(tmp_path)], "expected the folder of a data set, with dataset.json, found none"),
        ([root, "--out", str(tmp_path / "none" / "a.html")], "expected a file in a folder that is there"),
        ([root, "--out", str(files.root / "dataset.json")], "--out: expected a file that ends in .html or .htm"),
        ([root, "--out", str(tmp_path / "folder.html")], "--out: expected a file, found the folder"),
        ([root, "--out", str(files.scenes[0] / "a.html")], "--out: expected a file outside the folders of scenes"),
        ([root, "--out", "/proc/a.html"], "/proc/a.html: expected a file that can be written"),
        ([root, "--pictures", "-1"], "pictures: expected"),
    ):
        assert main(arguments) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert words in line, line
    files.change(files.root / "dataset.json", lambda data: data.update(seed="x"))
    assert main([root]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "dataset.json: seed" in line
