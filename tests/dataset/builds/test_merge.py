from __future__ import annotations

import json
import shutil

import pytest

from glassware.dataset.commands.merge import main


@pytest.fixture
def twins(undisturbed, tmp_path):
    """Two copies of the data set."""
    return [shutil.copytree(undisturbed, tmp_path / name) for name in ("one", "two")]


def test_data_sets_that_share_scenes_merge_where_these_are_the_same(twins, undisturbed, content, tmp_path):
    shutil.rmtree(twins[0] / "scenes/000000")
    assert main([*map(str, twins), "--out", str(tmp_path / "whole")]) == 0
    assert content(tmp_path / "whole") == content(undisturbed)


@pytest.mark.parametrize(
    ("file", "change", "says"),
    [
        ("dataset.json", {"seed": 4}, "seed 4 (in "),
        ("dataset.json", {"config": {}}, "cameras not set (in "),
        ("dataset.json", {"backend": "cuda_ad_rgb"}, "backend 'cuda_ad_rgb' (in "),
        ("scenes/000003/checksums.json", {"files": {}}, "scenes/000003: expected the same bytes"),
    ],
    ids=["seed", "settings", "backend", "bytes"],
)
def test_data_sets_of_other_makes_are_refused_with_what_differs(twins, capsys, tmp_path, file, change, says):
    path = twins[1] / file
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    assert main([*map(str, twins), "--out", str(tmp_path / "whole")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line
    assert not (tmp_path / "whole" / "dataset.json").exists()


def test_a_folder_that_holds_another_scene_is_refused(twins, capsys, tmp_path):
    (twins[1] / "scenes/000002").rename(twins[1] / "scenes/000007")
    assert main([str(twins[1]), "--out", str(tmp_path / "whole")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("scenes/000007/views.json: expected the views of scene 7, found those of scene 2")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((), "nothing"),
        (("--out", "x"), "expected folders of data sets, found none"),
        (("nowhere", "--out", "x"), "nowhere: expected the folder of a data set"),
    ],
)
def test_a_wrong_request_is_one_line(capsys, tmp_path, monkeypatch, arguments, says):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line
    assert list(tmp_path.iterdir()) == []
