"""Weights alone: what is in the file, and what is said where it is not usable."""

from __future__ import annotations

import json

import pytest
import torch

from glassware.core.errors import InputError
from glassware.learn import build_network
from glassware.learn.networks.weights_file import read_safetensors, write_safetensors
from glassware.learn.training import weights as weights_module
from glassware.learn.training.checkpoint import Checkpoint, load_network, load_trained, save_checkpoint
from glassware.learn.training.export_weights import export_weights
from glassware.learn.training.run import train
from glassware.learn.training.settings import TrainSettings
from glassware.learn.training.weights import weights_path

#: Half of the last place of half precision, whose mantissa has 11 bits.
HALF = 2.0**-11


@pytest.fixture
def checkpoint(tiny, tmp_path):
    """A checkpoint whose averaged weights are others than its last ones, and its averaged network."""
    network = build_network(tiny)
    averaged = {
        name: value + 0.25 if value.is_floating_point() else value.clone()
        for name, value in network.state_dict().items()
    }
    views = {"size": (96, 128)}
    settings = TrainSettings.model_validate({"network": tiny, "views": views, "also": ("/home/me/more",)})
    state = Checkpoint(settings, None, 7, network.state_dict(), averaged, {}, torch.get_rng_state(), 1.0)
    save_checkpoint(tmp_path / "run.safetensors", state)
    return tmp_path / "run.safetensors", averaged


@pytest.fixture
def exported(checkpoint, tmp_path):
    return export_weights(checkpoint[0], tmp_path / "out", "mine")


def changed_header(path, **changes):
    tensors, metadata = read_safetensors(path)
    header = json.loads(metadata["weights"]) | changes
    write_safetensors(path, tensors, {"weights": json.dumps(header)})
    return path


def test_weights_are_the_averaged_ones_to_half_precision_and_statistics_are_exact(checkpoint, exported):
    averaged = checkpoint[1]
    found = load_trained(exported).weights
    assert found.keys() == averaged.keys()
    for name, value in averaged.items():
        bound = HALF if value.ndim >= 2 else 0.0
        assert bool(((found[name] - value).abs() <= bound * value.abs() + 1e-7 * (value.ndim >= 2)).all()), name
        assert found[name].dtype == value.dtype
    network, settings = load_network(exported)
    assert not network.training
    assert settings.views.size == (96, 128)


def test_the_file_holds_kernels_in_half_precision_and_no_state_of_a_run(checkpoint, exported):
    tensors, _ = read_safetensors(exported)
    assert {value.dtype for value in tensors.values() if value.ndim >= 2} == {torch.float16}
    assert not [name for name in tensors if name.startswith(("optimiser", "rng", "network.", "ema"))]
    assert exported.stat().st_size < 0.4 * checkpoint[0].stat().st_size


def test_the_record_of_the_model_card_has_settings_and_reports_without_paths_of_the_machine(checkpoint, tmp_path):
    report = {"samples": 3, "checkpoint": "/home/me/run", "data": {"path": "/home/me/data", "split": "val"}}
    (tmp_path / "report.json").write_text(json.dumps(report))
    (tmp_path / "notes.yaml").write_text("machine: two cores\n")
    export_weights(
        checkpoint[0], tmp_path, "mine", reports={"val": tmp_path / "report.json"}, notes=tmp_path / "notes.yaml"
    )
    text = (tmp_path / "mine.json").read_text()
    record = json.loads(text)
    assert record["reports"]["val"] == {"samples": 3, "data": {"split": "val"}}
    assert record["notes"] == {"machine": "two cores"}
    assert record["weights"]["step"] == 7
    assert record["settings"]["also"] == ["more"]
    assert "/home/me" not in text


def test_weights_may_lie_between_those_before_and_after_a_run(checkpoint, tiny, tmp_path):
    """By the definition of the mean, kernels and statistics alike; 0 and 1 are the weights before and after."""
    after = checkpoint[1]
    settings = TrainSettings.model_validate({"network": tiny})
    torch.manual_seed(5)
    before = build_network(tiny).state_dict()
    save_checkpoint(
        tmp_path / "before.ckpt", Checkpoint(settings, None, 1, before, None, {}, torch.get_rng_state(), 1.0)
    )
    for alpha in (0.0, 0.3, 1.0):
        path = export_weights(
            checkpoint[0], tmp_path / "out", "mine", interpolate_with=tmp_path / "before.ckpt", alpha=alpha
        )
        found = load_trained(path).weights
        for name, value in after.items():
            if value.is_floating_point():
                expected = (1.0 - alpha) * before[name].double() + alpha * value.double()
                bound = HALF if value.ndim >= 2 else 1e-6
                torch.testing.assert_close(found[name].double(), expected, rtol=bound, atol=1e-6)
            else:
                assert torch.equal(found[name], value), name
    assert json.loads((tmp_path / "out" / "mine.json").read_text())["interpolated"] == {"with": "before", "alpha": 1.0}
    other = settings.model_copy(update={"network": tiny.model_copy(update={"planes": 9})})
    network = build_network(other.network)
    save_checkpoint(
        tmp_path / "other.ckpt", Checkpoint(other, None, 1, network.state_dict(), None, {}, torch.get_rng_state(), 1.0)
    )
    with pytest.raises(InputError, match=r"network\.planes: expected 8, as in the checkpoint, found 9"):
        export_weights(checkpoint[0], tmp_path, "mine", interpolate_with=tmp_path / "other.ckpt")


def test_the_cameras_of_the_training_go_with_the_weights(tiny, rendered, tmp_path, checkpoint):
    """Pictures of 128 x 96 px with a focal length f have f at 128 x 96, whatever the settings of the views."""
    path = export_weights(checkpoint[0], tmp_path, "mine", data=rendered)
    header = load_trained(path).header
    record = json.loads((rendered / "scenes" / "000000" / "000" / "camera.json").read_text())
    assert header is not None
    assert header.focal == pytest.approx(record["K"][0][0])
    assert header.baseline == pytest.approx(record["baseline"])


def test_weights_of_another_version_are_one_clear_line(exported):
    changed_header(exported, schema_version="glassware/weights/9", glassware="7.0")
    with pytest.raises(
        InputError,
        match=r"mine\.safetensors: expected weights of the version glassware/weights/1, which "
        r"glassware \S+ reads, found glassware/weights/9 of glassware 7\.0$",
    ):
        load_network(exported)


def test_truncated_and_changed_files_are_one_clear_line(exported, tmp_path):
    content = exported.read_bytes()
    for name, damaged in (("cut", content[:-1000]), ("changed", content[:-500] + b"\x07" + content[-499:])):
        path = tmp_path / f"{name}.safetensors"
        path.write_bytes(damaged)
        with pytest.raises(InputError, match=rf"{name}\.safetensors: expected an undamaged safetensors or torch file"):
            load_network(path)


def test_weights_that_come_with_glassware_go_by_their_names(exported, tmp_path, monkeypatch):
    monkeypatch.setattr(weights_module, "SHIPPED", exported.parent)
    monkeypatch.chdir(tmp_path)
    name = type(exported)("mine")
    assert weights_path(name) == exported
    (tmp_path / "mine").mkdir()  # a folder of that name is no weights
    assert weights_path(name) == exported
    with pytest.raises(
        InputError, match=r"mime: expected the name of weights .*\(mine\) \(is it mine\?\), or a checkpoint"
    ):
        load_network(type(exported)("mime"))


def test_a_run_begins_with_weights_alone_and_takes_their_network_and_views_but_does_not_resume(
    exported, rendered, tmp_path
):
    settings = TrainSettings.model_validate(
        {
            "steps": 1,
            "batch": 1,
            "machine": {"accelerator": "cpu", "workers": 0},
            "val_split": "none",
            "optimiser": {"learning_rate": 1e-9, "warmup": 0},
        }
    )
    train(settings, rendered, tmp_path / "tuned", None, lambda _line: None, init=exported)
    found, start = load_trained(tmp_path / "tuned" / "last.safetensors"), load_trained(exported)
    assert found.settings.views.size == (96, 128)
    learnt = [name for name, value in start.weights.items() if value.ndim >= 2]
    assert all(torch.allclose(found.weights[name], start.weights[name], atol=1e-6) for name in learnt)
    with pytest.raises(InputError, match="expected a checkpoint of glassware train, found weights alone"):
        train(settings, rendered, tmp_path / "again", exported, lambda _line: None)
