"""`glassware export`: bad requests are one line, and what is complete is kept."""

from __future__ import annotations

import json
import re
import resource
import shutil
import tarfile

import pytest

from glassware.core.atomic_io import is_leftover
from glassware.core.errors import InputError
from glassware.dataset.commands.export import main
from glassware.dataset.exports.formats import FORMATS
from glassware.dataset.exports.run import Exported, export
from glassware.dataset.writer import finish_dataset, start_dataset

#: Formats that hold scenes without their views.
WITHOUT_VIEWS = ("gltf", "mjcf", "urdf", "usd")
#: Largest file while the disk is full [bytes]: some file of every format is larger.
FULL = 700


def formats(quick: str):
    """All formats; those that are not named are slow tests, because the machinery is the same."""
    return [pytest.param(name, marks=() if name in quick.split() else pytest.mark.slow) for name in FORMATS]


@pytest.fixture
def two_scenes(made, head, stored, write_scene, add_sensor_depth):
    """The stored data set with a second scene, of one view, and a sensor's depth."""
    scene, points, views = made
    start_dataset(stored, head, [1])
    write_scene(stored, scene.model_copy(update={"scene_id": 1}), points, views[:1])
    finish_dataset(stored)
    return add_sensor_depth(stored)


def _files(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("name", formats("coco bop gltf keypose nerfstudio ply syn-todd webdataset"))
def test_a_stopped_export_keeps_what_is_complete_and_ends_the_same(two_scenes, tmp_path, name):
    export(two_scenes, name, tmp_path / "whole")
    file = "objects.json" if name in WITHOUT_VIEWS else "000/labels.json" if name != "keypose" else "000/geometry.exr"
    file = f"000001/{file}"
    damaged = two_scenes / "scenes" / file
    good = damaged.read_bytes()
    damaged.write_bytes(good[: len(good) // 2])
    with pytest.raises(InputError, match=re.escape(file)):
        export(two_scenes, name, tmp_path / "out")
    damaged.write_bytes(good)
    assert export(two_scenes, name, tmp_path / "out") == Exported(scenes=2, written=1)
    assert export(two_scenes, name, tmp_path / "out") == Exported(scenes=2, written=0)
    assert _files(tmp_path / "out") == _files(tmp_path / "whole")


@pytest.mark.parametrize("name", formats("coco bop bop-webdataset gltf ply syn-todd webdataset"))
def test_scenes_that_are_added_later_are_exported_as_well(
    made, head, stored, write_scene, add_sensor_depth, tmp_path, name
):
    export(add_sensor_depth(stored), name, tmp_path / "out")
    scene, points, views = made
    start_dataset(stored, head, [1])
    write_scene(stored, scene.model_copy(update={"scene_id": 1}), points, views[:1])
    finish_dataset(stored)
    add_sensor_depth(stored)
    assert export(stored, name, tmp_path / "out").scenes == 2
    export(stored, name, tmp_path / "whole")
    assert _files(tmp_path / "out") == _files(tmp_path / "whole")


@pytest.mark.parametrize("name", [name for name in FORMATS if name not in WITHOUT_VIEWS])
def test_a_damaged_picture_is_one_line_and_leaves_nothing_behind(stored, add_sensor_depth, tmp_path, capsys, name):
    add_sensor_depth(stored)
    for view in ("000", "001"):
        (stored / "scenes/000000" / view / "left.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    assert main([str(stored), "--format", name, "--out", str(tmp_path / "out")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "left.png: expected a whole PNG file" in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", formats("coco ply"))
def test_a_full_disk_is_one_line_and_the_same_command_goes_on(two_scenes, tmp_path, capsys, name):
    export(two_scenes, name, tmp_path / "whole")
    request = [str(two_scenes), "--format", name, "--out", str(tmp_path / "out")]
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (FULL, limits[1]))
    try:
        code = main(request)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    (line,) = capsys.readouterr().err.splitlines()
    assert code == 1
    assert line.startswith("no room to write: ")
    assert not [path for path in (tmp_path / "out").rglob("*") if is_leftover(path.name)]
    assert main(request) == 0
    assert _files(tmp_path / "out") == _files(tmp_path / "whole")


@pytest.mark.parametrize(
    ("name", "options", "missing"),
    [
        ("dreds", {}, "000/camera.json: expected a data set with a depth camera, made with --sensors.depth d435"),
        ("ply", {"layers": True}, r"000/layers.exr: expected a data set with layers, made with --write layers"),
    ],
)
def test_a_label_that_is_missing_is_named_with_how_to_build_it(stored, tmp_path, name, options, missing):
    for path in stored.rglob("layers.exr"):
        path.unlink()
    with pytest.raises(InputError, match=missing):
        export(stored, name, tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", [name for name, exporter in FORMATS.items() if exporter.labels])
def test_labels_that_are_not_asked_for_are_left_out(stored, tmp_path, name):
    export(stored, name, tmp_path / "whole")
    first, *others = FORMATS[name].labels
    export(stored, name, tmp_path / "out", labels=(first,))
    whole, some = _contents(tmp_path / "whole"), _contents(tmp_path / "out")
    assert some < whole
    assert {label for label in (first, *others) if any(_is_of(label, path) for path in some)} <= {first}
    again = export(stored, name, tmp_path / "out", labels=(first,))
    assert again.written == 0


def _contents(folder) -> set[str]:
    """Paths of files, those in shards included."""
    found = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    for shard in folder.rglob("*.tar"):
        with tarfile.open(shard) as tar:
            found |= {f"{shard.relative_to(folder)}/{member}" for member in tar.getnames()}
    return found


def _is_of(label: str, path: str) -> bool:
    return re.search(rf"(^|[/._]){re.escape(label)}([/._]|$)", path) is not None


def test_an_unknown_format_names_the_known_ones(stored, tmp_path, capsys):
    assert main([str(stored), "--format", "cocoo", "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.startswith("--format: expected one of coco")
    assert not (tmp_path / "out").exists()


def test_a_folder_that_holds_something_else_is_left_as_it_is(stored, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.tex").write_text("mine")
    with pytest.raises(InputError, match=r"expected an empty folder or an earlier export, found something else"):
        export(stored, "coco", tmp_path / "out")
    with pytest.raises(InputError, match="a folder outside of the data set"):
        export(stored, "coco", stored / "coco")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.tex"]


def test_an_export_of_another_choice_or_data_set_is_not_mixed_in(stored, tmp_path):
    export(stored, "coco", tmp_path / "out")
    with pytest.raises(InputError, match=r"option vessels-only: expected True, or another --out, found an export with"):
        export(stored, "coco", tmp_path / "out", vessels_only=True)
    shutil.copytree(stored, tmp_path / "other")
    head = json.loads((stored / "dataset.json").read_text())
    (tmp_path / "other" / "dataset.json").write_text(json.dumps(head | {"seed": 8}))
    with pytest.raises(InputError, match="data set's seed: expected 8"):
        export(tmp_path / "other", "coco", tmp_path / "out")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"eye": "right"}, "--eye: expected left, because coco holds labels"),
        ({"split": "val"}, "expected a data set that is split"),
        ({"views": 3}, "views"),
        ({"layers": True}, "--layers: expected the format ply, found coco"),
        ({"liquids": True}, "--liquids: expected the format bop or bop-webdataset, found coco"),
        ({"labels": ("masks",)}, "--labels: expected some of instances, amodal, keypoints, found 'masks'"),
    ],
)
def test_options_that_make_no_sense_are_refused(stored, tmp_path, options, says):
    with pytest.raises(InputError, match=says):
        export(stored, "coco", tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_no_data_set_is_one_line(tmp_path, capsys):
    assert main([str(tmp_path), "--format", "coco", "--out", str(tmp_path / "out")]) == 2
    assert "the folder of a data set" in capsys.readouterr().err
