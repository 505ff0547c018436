from __future__ import annotations

import json

import numpy as np
import pytest
import torch
import yaml

from glassware.annotate.masks import decode_mask
from glassware.core.folder_lock import locked_folder
from glassware.dataset.commands.glassware import main
from glassware.dataset.format.exr import read_exr
from glassware.dataset.format.pictures import read_png
from glassware.dataset.reader import Dataset


@pytest.fixture(scope="module")
def run(rendered, tiny, tmp_path_factory):
    """A short run by the command: its folder and its settings."""
    folder = tmp_path_factory.mktemp("run")
    settings = {
        "network": tiny.model_dump(mode="json") | {"depth_range": None},
        "machine": {"accelerator": "cpu", "workers": 0, "threads": 1},
        "steps": 2,
        "batch": 1,
        "validate_samples": 1,
    }
    (folder / "run.yaml").write_text(yaml.safe_dump(settings))
    assert main(["train", str(rendered), "--config", str(folder / "run.yaml"), "--out", str(folder)]) == 0
    return folder


def error_line(capsys) -> str:
    return capsys.readouterr().err.strip()


def test_train_evaluate_and_predict_follow_one_another(run, rendered, tmp_path, capsys):
    checkpoint = str(run / "last.safetensors")
    options = ["--device", "cpu", "--threads", "1", "--out", str(tmp_path)]
    assert main(["evaluate", checkpoint, str(rendered), "--worst", "2", "--workers", "0", *options]) == 0
    printed = capsys.readouterr().out
    assert "5 samples" in printed
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["data"]["split"] == "val"
    assert report["samples"] == 5
    assert len(list(tmp_path.glob("worst-0?-scenes-000001-*.png"))) == 2

    view = rendered / "scenes" / "000001" / "003"
    assert main(["predict", checkpoint, str(view / "left.png"), str(view / "right.png"), *options]) == 0
    height, width, _ = read_png(tmp_path / "prediction.png").shape
    assert (height > 5 * 96, width > 2 * 640) == (True, True)  # enlarged five times, depth and legend beside and below
    depth = read_exr(tmp_path / "depth.exr")["Z"]
    assert depth.shape == (96, 128)
    assert np.isfinite(depth).all()
    record = json.loads((tmp_path / "prediction.json").read_text())
    assert len(record["images"]) == 2
    for found in record["objects"]:
        assert found["category"] in ("transparent", "opaque")
        assert decode_mask(found["mask"]["counts"], tuple(found["mask"]["size"])).sum() == found["pixels"]


def test_pictures_with_cameras_of_their_own_give_the_same(run, rendered, tmp_path):
    """A picture and a JSON file of its name, as a user would bring them."""
    stored, paths = Dataset.open(rendered).scene(1).views[:2], []
    for number, view in enumerate(stored):
        camera = view.camera()
        paths.append(tmp_path / f"{number}.png")
        paths[-1].write_bytes((view.folder / "left.png").read_bytes())
        record = {"K": camera.K.tolist(), "world_T_camera": camera.world_T_camera.tolist()}
        paths[-1].with_suffix(".json").write_text(json.dumps(record))
    options = ["--device", "cpu", "--threads", "1"]
    predict = ["predict", str(run / "last.safetensors"), *options]
    assert main([*predict, *map(str, paths), "--out", str(tmp_path / "a")]) == 0
    lefts = [str(view.folder / "left.png") for view in stored]
    assert main([*predict, *lefts, "--out", str(tmp_path / "b")]) == 0
    a, b = (read_exr(tmp_path / name / "depth.exr")["Z"] for name in "ab")
    np.testing.assert_array_equal(a, b)


def test_weights_of_whole_pairs_are_evaluated_on_what_both_eyes_see(rendered, tmp_path):
    reports = []
    for more in ([], ["--convergence", "0.8"]):
        out = ["--out", str(tmp_path), "--worst", "0", "--workers", "0", "--threads", "1", "--device", "cpu"]
        assert main(["evaluate", "base", str(rendered), *out, *more]) == 0
        reports.append(json.loads((tmp_path / "report.json").read_text()))
    whole, cut = reports
    assert (whole["views"]["convergence"], cut["views"]["convergence"]) == (None, 0.8)
    for pixels in ("transparent", "opaque", "all"):  # the floors see the labels alone
        floors = [report["floors"]["full"][pixels]["constant"]["mae"] for report in reports]
        assert floors[0] != floors[1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["train"], "glassware train: expected the folder of a data set, found none"),
        (["train", "none"], "none: expected the folder of a data set, found none"),
        (["train", "{data}", "--network.planes", "1"], "network.planes: expected greater than or equal to 2, found 1"),
        (["train", "{data}", "--train-split", "test"], "split test: expected scenes that exist, found none"),
        (["train", "{data}", "--views.count", "9", "--machine.workers", "1"], "expected 8 others by the rule distance"),
        (["evaluate", "{ckpt}"], "glassware evaluate: expected a checkpoint and the folder of a data set"),
        (
            ["evaluate", "{data}/dataset.json", "{data}"],
            "dataset.json: expected an undamaged safetensors or",
        ),
        (["evaluate", "{ckpt}", "{data}", "--convergence", "0.6"], "views.convergence: expected the rule stereo"),
        (["evaluate", "{ckpt}", "{data}", "--device", "moon"], "--device: expected a device of this machine"),
        (["evaluate", "{ckpt}", "{data}", "--device", "cuda:7"], "--device: expected a device of this machine"),
        (
            ["predict", "{ckpt}", "{data}/preview.png"],
            "pictures: expected two or more views of one scene, such as left.png right.png, found one eye",
        ),
        (["predict", "{ckpt}", "{data}/dataset.json", "{data}/dataset.json"], "expected a PNG or JPEG picture"),
        (["predict", "{ckpt}", "{data}/none.png", "{data}/none.png"], "none.png: expected a readable picture"),
    ],
)
def test_a_wrong_request_is_one_line_and_code_2(run, rendered, tmp_path, capsys, arguments, message):
    filled = [word.format(data=rendered, ckpt=run / "last.safetensors") for word in arguments]
    quick = ["--machine.accelerator", "cpu"] if arguments[0] == "train" else []
    assert main([*filled, *quick, "--out", str(tmp_path / "out")]) == 2
    line = error_line(capsys)
    assert message in line
    assert "\n" not in line


@pytest.mark.parametrize("command", ["train", "tables"])
def test_a_folder_is_taken_by_one_run_at_a_time(rendered, tmp_path, capsys, command):
    with locked_folder(tmp_path / "out", "run", print):
        assert main([command, str(rendered), "--machine.accelerator", "cpu", "--out", str(tmp_path / "out")]) == 2
    assert error_line(capsys).endswith("out: expected a folder that no other run works in, found another run")


def test_a_hostile_checkpoint_runs_nothing(run, rendered, tmp_path, capsys, monkeypatch):
    class Attack:
        def __reduce__(self):
            import os

            return os.system, ("touch attacked",)

    monkeypatch.chdir(tmp_path)
    torch.save({"state_dict": Attack()}, tmp_path / "bad.ckpt")
    assert main(["evaluate", "bad.ckpt", str(rendered)]) == 2
    assert "bad.ckpt: expected an undamaged safetensors or torch file" in error_line(capsys)
    assert not (tmp_path / "attacked").exists()


def test_a_picture_without_a_camera_is_one_clear_line(run, rendered, tmp_path, capsys):
    view = rendered / "scenes" / "000001" / "003"
    alone = tmp_path / "alone.png"
    alone.write_bytes((view / "left.png").read_bytes())
    assert main(["predict", str(run / "last.safetensors"), str(alone), str(view / "left.png"), "--device", "cpu"]) == 2
    assert "alone.png: expected its camera in alone.json or camera.json, or --camera, found neither" in error_line(
        capsys
    )
    alone.with_suffix(".json").write_text('{"K": [1, 2]}')
    assert main(["predict", str(run / "last.safetensors"), str(alone), str(view / "left.png"), "--device", "cpu"]) == 2
    assert "alone.json: K: expected 3 rows of 3 finite numbers" in error_line(capsys)
    record = {"K": [[99.0, 0.0, 64.0], [0.0, 99.0, 48.0], [0.0, 0.0, 1.0]], "world_T_camera": np.eye(4).tolist()}
    for number in ("NaN", "null", '"1"', "true", "1e400", "1" + "0" * 400, "1e30"):
        text = json.dumps(record).replace("64.0", number)
        alone.with_suffix(".json").write_text(text)
        assert (
            main(["predict", str(run / "last.safetensors"), str(alone), str(view / "left.png"), "--device", "cpu"]) == 2
        )
        assert "alone.json" in error_line(capsys)


def test_a_folder_that_cannot_be_written_to_is_reported_before_any_work(run, rendered, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    for command in (["evaluate", str(run / "last.safetensors"), str(rendered)], ["train", str(rendered)]):
        assert main([*command, "--out", str(tmp_path / "file")]) == 2
        assert "file: expected a folder that can be made and written to" in error_line(capsys)


def test_machines_that_do_not_exist_are_one_line(rendered, tmp_path, capsys):
    for option in (["--machine.accelerator", "foo"], ["--machine.devices", "0"], ["--machine.strategy", "foo"]):
        assert main(["train", str(rendered), *option, "--out", str(tmp_path / "out")]) == 2
        assert "machine: expected existing devices and a strategy for them" in error_line(capsys)


def test_help_names_the_commands(capsys):
    assert main(["--help"]) == 0
    printed = capsys.readouterr().out
    for name in ("evaluate", "predict", "render", "train"):
        assert f"  {name} " in printed


def test_a_data_set_without_splits_points_at_the_split_of_all_scenes(copied, tmp_path, capsys):
    (copied / "splits.json").unlink()
    quick = ["--machine.accelerator", "cpu", "--out", str(tmp_path / "out")]
    assert main(["train", str(copied), *quick]) == 2
    assert "--train-split all takes every scene" in error_line(capsys)
