from __future__ import annotations

import json
import math
import zipfile

import pytest
import torch
from safetensors.torch import save_file

from glassware.core.errors import InputError
from glassware.learn import ReferenceMVTrans
from glassware.learn.networks.build import build_network
from glassware.learn.networks.weights_file import read_safetensors, write_safetensors
from glassware.learn.training.checkpoint import (
    Checkpoint,
    load_checkpoint,
    load_network,
    load_weights,
    save_checkpoint,
)
from glassware.learn.training.settings import TrainSettings


@pytest.fixture
def path(tiny, tmp_path):
    state = build_network(tiny).state_dict()
    settings = TrainSettings(network=tiny)
    optimiser = {"0.step": torch.tensor(7.0), "0.exp_avg": torch.rand(3, 2)}
    save_checkpoint(
        tmp_path / "some.safetensors",
        Checkpoint(settings, None, 7, state, None, optimiser, torch.get_rng_state(), math.inf),
    )
    return tmp_path / "some.safetensors"


class Attack:
    """Runs a command when it is unpickled."""

    def __reduce__(self):
        import os

        return os.system, ("touch attacked",)


def test_a_checkpoint_comes_back_as_it_was(path, tiny):
    checkpoint = load_checkpoint(path)
    assert (checkpoint.step, checkpoint.settings.network, checkpoint.data) == (7, tiny, None)
    assert (checkpoint.ema, checkpoint.best_loss) == (None, math.inf)
    assert checkpoint.optimiser["0.step"] == 7.0
    assert checkpoint.optimiser["0.exp_avg"].shape == (3, 2)
    assert torch.equal(checkpoint.rng, torch.get_rng_state())
    network, _ = load_network(path)
    assert all(torch.equal(value, checkpoint.network[name]) for name, value in network.state_dict().items())


@pytest.mark.parametrize("place", [0.001, 0.2, 0.5, 0.999])
def test_a_changed_bit_anywhere_is_one_clear_line(path, place):
    """In the length, the header, and the weights, of which safetensors itself has no checksum."""
    data = bytearray(path.read_bytes())
    data[int(place * len(data))] ^= 1
    bad = path.with_name("bad.safetensors")
    bad.write_bytes(data)
    with pytest.raises(InputError, match=r"bad\.safetensors: "):
        load_network(bad)


def test_a_file_that_is_cut_short_too_long_or_something_else_is_one_clear_line(path):
    whole, bad = path.read_bytes(), path.with_name("bad.safetensors")
    huge = (1 << 60).to_bytes(8, "little") + whole[8:]
    shape = b'{"a":{"dtype":"F32","shape":[1099511627776],"data_offsets":[0,4398046511104]}}'
    for data in (whole[:5000], whole[:-1], whole + b"\0", huge, len(shape).to_bytes(8, "little") + shape):
        bad.write_bytes(data)
        with pytest.raises(InputError, match=r"bad\.safetensors: expected an undamaged safetensors or torch file"):
            load_network(bad)
    for data in (b"", b"{}", b"something else"):
        bad.write_bytes(data)
        with pytest.raises(InputError, match=r"bad\.safetensors: expected an undamaged safetensors or torch file"):
            load_network(bad)
    save_file({"weight": torch.zeros(2)}, bad)
    with pytest.raises(InputError, match=r"bad\.safetensors: expected a checkpoint of glassware train"):
        load_network(bad)
    with pytest.raises(InputError, match="a readable file, found none"):
        load_network(path.with_name("none.safetensors"))
    with pytest.raises(InputError, match="a readable file, found a folder"):
        load_network(path.parent)


def test_a_header_with_wrong_values_is_one_clear_line(path):
    tensors, metadata = read_safetensors(path)
    header = json.loads(metadata["checkpoint"])
    bad = path.with_name("bad.safetensors")
    for change, message in (
        ({"schema_version": "glassware/checkpoint/9"}, "schema_version: expected 'glassware/checkpoint/2'"),
        ({"settings": {"network": {"planes": 1}}}, r"network\.planes: expected greater than or equal to 2"),
        ({"step": 1 << 40}, "step: expected one of 0 to 20000, found 1099511627776"),
        ({"step": -1}, "step: expected greater than or equal to 0, found -1"),
        ({"best_loss": "low"}, "best_loss: expected a number"),
    ):
        write_safetensors(bad, tensors, {"checkpoint": json.dumps(header | change)})
        with pytest.raises(InputError, match=message):
            load_network(bad)
    write_safetensors(bad, tensors, {"checkpoint": "[" * 100_000})
    with pytest.raises(InputError, match=r"bad\.safetensors: "):
        load_network(bad)


def test_tensors_that_do_not_fit_are_one_clear_line(path):
    tensors, metadata = read_safetensors(path)
    bad = path.with_name("bad.safetensors")
    first = next(name for name in sorted(tensors) if name.startswith("network."))
    for change, message in (
        ({"network.matching.source.weight": torch.zeros(1)}, "expected no such tensor, found"),
        (
            {first: tensors[first].long()},
            r"expected \(.*\), found \(.*\) torch\.int64 \(weights of another version or network",
        ),
        ({"other": torch.zeros(1)}, "other: expected a tensor of network, ema, optimiser, rng"),
    ):
        write_safetensors(bad, tensors | change, metadata)
        with pytest.raises(InputError, match=message):
            load_network(bad)
    write_safetensors(bad, {name: value for name, value in tensors.items() if name != "rng.cpu"}, metadata)
    with pytest.raises(InputError, match=r"the tensor rng\.cpu, found none"):
        load_network(bad)


def test_weights_of_another_network_are_one_clear_line(path, tiny):
    other = build_network(tiny.model_copy(update={"volume_channels": 6}))
    with pytest.raises(
        InputError, match=r"some\.safet.*: matching\.pair\.first\.0\.bias: expected \(6,\), found \(4,\)"
    ):
        load_weights(other, load_checkpoint(path).network, path)


@pytest.mark.slow
def test_a_torch_file_that_is_damaged_hostile_or_something_else_is_one_clear_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bad, state = tmp_path / "bad.ckpt", ReferenceMVTrans().state_dict()
    torch.save(state, bad)
    data = bytearray(bad.read_bytes())
    bad.write_bytes(data[:5000])
    with pytest.raises(InputError, match=r"bad\.ckpt: expected an undamaged safetensors or torch file"):
        load_network(bad)
    # Somewhere in the weights, which torch itself would read without an error.
    data[len(data) // 2] ^= 1
    bad.write_bytes(data)
    with pytest.raises(InputError, match=r"or torch file, found (a wrong checksum|Bad CRC)"):
        load_network(bad)
    torch.save({"state_dict": Attack()}, bad)
    with pytest.raises(InputError, match=r"or torch file, found something else, or more than tensors"):
        load_network(bad)
    assert not (tmp_path / "attacked").exists()
    with zipfile.ZipFile(bad, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("archive/data/0", bytes(1 << 20))
    with pytest.raises(InputError, match=r"found compressed members \(archive/data/0\)"):
        load_network(bad)
    for content in ([1.0], {1: torch.zeros(1)}, {"a": torch.eye(3).to_sparse()}, {"state_dict": 3}, {"epoch": 3}):
        torch.save(content, bad)
        with pytest.raises(InputError, match="expected a state dict: names and dense tensors"):
            load_network(bad)
    torch.save({"a": torch.zeros(1)}, bad)
    with pytest.raises(InputError, match=r"bad\.ckpt: .*: expected .*, found none|a: expected no such tensor"):
        load_network(bad)


def test_a_released_checkpoint_is_read(tmp_path):
    state = {f"model.{name}": value for name, value in ReferenceMVTrans().state_dict().items()}
    torch.save({"state_dict": state, "epoch": 100, "global_step": 734169}, tmp_path / "released.ckpt")
    network, settings = load_network(tmp_path / "released.ckpt")
    assert isinstance(network, ReferenceMVTrans)
    assert settings.network.variant == "reference"


def test_paths_among_the_settings_are_kept(tiny, tmp_path):
    settings = TrainSettings.model_validate({"network": tiny.model_dump(), "pretrained": tmp_path / "weights.pth"})
    checkpoint = Checkpoint(settings, None, 0, {}, None, {}, torch.get_rng_state(), math.inf)
    save_checkpoint(tmp_path / "kept.safetensors", checkpoint)
    assert load_checkpoint(tmp_path / "kept.safetensors").settings == settings
