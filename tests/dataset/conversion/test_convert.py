"""A converted data set has what the other one has, and refuses in one line what it lacks."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.dataset.builds.verify import head_faults, index_faults, label_faults, scene_faults
from glassware.dataset.commands.convert import main as convert
from glassware.dataset.commands.inspect import main as inspect
from glassware.dataset.commands.verify import main as verify
from glassware.dataset.exports.run import export
from glassware.dataset.reader import Dataset

#: Makers and how many views they write: where cameras move, their masks fit those of the first view alone.
LAYOUTS = {"keypose": 2, "bop": 1, "bop_shards": 1, "todd": 1, "clearpose": 1, "syn_todd": 1}


def converted(makers, root: Path, write: str = "keypose", *options: str) -> Any:
    getattr(makers, write)(root / "source")
    assert convert([str(root / "source"), "--out", str(root / "out"), *options]) == 0
    return Dataset.open(root / "out")


def faults(data: Any) -> list[str]:
    found = [*head_faults(data.root, data.head), *index_faults(data.root)]
    for scene in data.scenes:
        found += [*scene_faults(data.root, data.head, scene.scene_id)]
        found += [*label_faults(data.root, scene.scene_id, data.head)]
    return found


def test_views_are_read_back_as_they_were(makers, tmp_path):
    data = converted(makers, tmp_path)
    first, second = data.scene(0).views
    assert (first.picture("right") == makers.picture(100)).all()
    assert first.camera().baseline == 0.12
    assert second.camera().world_T_camera == pytest.approx(makers.world_T_camera(1), abs=1e-6)
    assert np.isnan(first.depth()[0, 0])
    assert first.depth()[20, 20] == pytest.approx(0.57)
    assert np.isnan(first.sensor_depth()[20, 20])
    assert (first.instances() == 2 * (makers.ids() == 1)).all()
    labels = first.partial_labels()
    assert labels.source == "bottle_0/texture_5_pose_0/000000"
    assert labels.objects[0].box2d == (17.5, 17.5, 25.5, 32.5)
    assert labels.objects[0].pose_from == "keypoints"
    assert len(first.points()) == np.isfinite(first.depth()).sum()
    assert data.index(["vessels", "right"]).to_pydict()["vessels"] == [1, 1]
    assert [scene.scene_id for scene in data.split("test")] == [0]
    assert (data.root / "preview.png").is_file()


@pytest.mark.parametrize("write", LAYOUTS)
def test_the_labels_of_each_layout_agree_with_each_other(makers, tmp_path, write):
    getattr(makers, write)(tmp_path / "source", LAYOUTS[write])
    assert convert([str(tmp_path / "source"), "--out", str(tmp_path / "out"), "--rows", "0"]) == 0
    assert faults(Dataset.open(tmp_path / "out")) == []


def test_what_a_data_set_lacks_has_no_file_and_null_fields(makers, tmp_path):
    makers.trans10k(tmp_path / "source", 2)
    assert convert([str(tmp_path / "source"), "--out", str(tmp_path / "out")]) == 0
    data: Any = Dataset.open(tmp_path / "out")
    view = data.scene(0).views[0]
    assert sorted(path.name for path in view.folder.iterdir()) == [
        "camera.json",
        "classes.png",
        "labels.json",
        "left.png",
    ]
    record = view.camera_record()
    assert (record.K, record.baseline, record.world_T_right, record.exposure) == (None, None, None, None)
    assert view.partial_labels().objects is None
    assert data.head.converted.has == {"classes": 2}
    assert data.head.converted.classes[7] == "cup"
    assert faults(data) == []
    for read, match in (
        (view.camera, "K: expected a calibrated camera, found null"),
        (view.depth, "expected a data set with depth, found one without depth"),
        (view.instances, "expected a data set with instances, found one without"),
        (view.labels, "expected the labels of a rendered view, found those of a converted data set"),
        (data.scene(0).objects, "expected a rendered scene, found one of a converted data set"),
        (data.scene(0).scene, "expected a rendered scene, found one of a converted data set"),
    ):
        with pytest.raises(InputError, match=match):
            read()


def test_a_damaged_view_is_left_out_counted_and_named(makers, tmp_path, capsys):
    folder = makers.keypose(tmp_path / "source", frames=3)
    path = folder / "000001_L.png"
    path.write_bytes(path.read_bytes()[:-100])
    assert inspect([str(tmp_path / "source"), "--sheet", str(tmp_path / "sheet.png")]) == 0
    assert "left out: 0 incomplete, 1 of 3 damaged" in capsys.readouterr().out
    assert (tmp_path / "sheet.png").is_file()
    assert convert([str(tmp_path / "source"), "--out", str(tmp_path / "out")]) == 0
    data: Any = Dataset.open(tmp_path / "out")
    assert (data.head.converted.views, data.head.converted.left_out) == (2, 1)
    assert [item.path for item in data.head.findings] == ["bottle_0/texture_5_pose_0/000001"]
    assert "a whole PNG file" in data.head.findings[0].reason
    assert faults(data) == []


def test_a_contact_sheet_replaces_no_file_of_another_kind(makers, tmp_path, capsys):
    makers.keypose(tmp_path / "source", frames=1)
    settings = tmp_path / "run.png"
    settings.write_text("batch: 4")
    for sheet, message in (
        (tmp_path / "run.yaml", "sheet: expected a file that ends in .png"),
        (settings, "sheet: expected a new file, or a .png file that is replaced, found another file"),
        (tmp_path, "sheet: expected a file that ends in .png"),
        (tmp_path / "none" / "x.png", "sheet: expected a file in a folder that is there"),
    ):
        assert inspect([str(tmp_path / "source"), "--sheet", str(sheet)]) == 2
        assert message in capsys.readouterr().err
    assert settings.read_text() == "batch: 4"
    for _ in range(2):  # its own it does
        assert inspect([str(tmp_path / "source"), "--sheet", str(tmp_path / "sheet.png")]) == 0


def test_a_second_conversion_replaces_the_first_and_no_other_data_set(makers, tmp_path, capsys):
    makers.transcg(tmp_path / "source")
    out = ["--out", str(tmp_path / "out")]
    assert convert([str(tmp_path / "source"), *out]) == 0
    assert len(Dataset.open(tmp_path / "out").scenes) == 3
    (tmp_path / "source" / "scene1" / "1" / "rgb2.png").unlink()
    assert convert([str(tmp_path / "source"), *out]) == 0
    data: Any = Dataset.open(tmp_path / "out")
    assert len(data.scenes) == 2
    assert faults(data) == []
    makers.keypose(tmp_path / "other", frames=1)
    capsys.readouterr()
    assert convert([str(tmp_path / "other"), *out]) == 2
    assert "expected an empty folder or an earlier conversion of other" in capsys.readouterr().err


def test_verify_finds_labels_that_contradict_each_other(makers, tmp_path):
    data = converted(makers, tmp_path)
    path = data.scene(0).views[0].folder / "labels.json"
    record = json.loads(path.read_text())
    record["objects"][0]["camera_T_object"][0][3] += 0.1
    record["objects"][0]["pixels"] += 1
    path.write_text(json.dumps(record))
    found = " ".join(label_faults(data.root, 0, data.head))
    assert "pose: expected its pixels" in found
    assert "pixels: expected 120, found 121" in found
    assert "labels.json" in " ".join(scene_faults(data.root, data.head, 0))  # its checksum
    assert verify([str(data.root), "--labels"]) == 1


@pytest.mark.parametrize(
    ("command", "match"),
    [
        (["verify", "--rerender", "1"], "expected a rendered data set, found one that was converted from KeyPose"),
        (["report"], "expected a rendered data set, found one that was converted from KeyPose"),
    ],
)
def test_commands_that_need_a_rendered_data_set_say_so(makers, tmp_path, capsys, command, match):
    from glassware.dataset.commands.glassware import main

    data = converted(makers, tmp_path)
    capsys.readouterr()
    assert main([command[0], str(data.root), *command[1:]]) == 2
    error = capsys.readouterr().err
    assert match in error
    assert error.count("\n") == 1


def test_masks_boxes_and_keypoints_go_to_coco_and_nothing_else(makers, tmp_path):
    data = converted(makers, tmp_path)
    assert export(data.root, "coco", tmp_path / "coco").written == 1
    found = json.loads((tmp_path / "coco" / "annotations" / "keypoints_test.json").read_text())
    assert [image["file_name"] for image in found["images"]] == ["000000/000.png", "000000/001.png"]
    assert found["annotations"][0]["area"] == 120
    assert found["annotations"][0]["num_keypoints"] == 2
    assert json.loads((tmp_path / "coco" / "annotations" / "amodal_test.json").read_text())["annotations"] == []
    with pytest.raises(InputError, match="expected coco, because the data set was converted from KeyPose"):
        export(data.root, "bop", tmp_path / "bop")


def test_what_is_transparent_is_stated_where_the_data_set_does_not_say(makers, tmp_path):
    data = converted(makers, tmp_path, "bop", "--transparent", "obj_000001")
    assert [item.transparent for item in data.scene(0).views[0].partial_labels().objects] == [True, False]


def test_some_views_are_converted_by_their_names(makers, tmp_path, capsys):
    makers.keypose(tmp_path / "source", frames=1, obj="bottle_0")
    makers.keypose(tmp_path / "source", frames=2, obj="cup_1")
    out = ["--out", str(tmp_path / "out"), "--rows", "0"]
    assert convert([str(tmp_path / "source"), *out, "--only", "cup_*/*"]) == 0
    assert [view.partial_labels().source[:5] for view in Dataset.open(tmp_path / "out").views()] == ["cup_1"] * 2
    capsys.readouterr()
    assert convert([str(tmp_path / "source"), *out, "--only", "mug*"]) == 2
    assert "--only: expected patterns of names of views, such as bottle_0/" in capsys.readouterr().err
