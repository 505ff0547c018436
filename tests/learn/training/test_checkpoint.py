from __future__ import annotations

import math
import zipfile

import pytest
import torch

from glassware.core.errors import InputError
from glassware.learn.networks.build import build_network
from glassware.learn.training.checkpoint import Checkpoint, load_checkpoint, load_network, restore, save_checkpoint
from glassware.learn.training.settings import TrainSettings


@pytest.fixture
def path(tiny, tmp_path):
    state = build_network(tiny).state_dict()
    settings = TrainSettings(network=tiny)
    save_checkpoint(
        tmp_path / "some.ckpt", Checkpoint(settings, None, 7, state, None, {}, torch.get_rng_state(), math.inf)
    )
    return tmp_path / "some.ckpt"


class Attack:
    """Runs a command when it is unpickled."""

    def __reduce__(self):
        import os

        return os.system, ("touch attacked",)


def test_a_checkpoint_comes_back_as_it_was(path, tiny):
    checkpoint = load_checkpoint(path)
    assert (checkpoint.step, checkpoint.settings.network, checkpoint.data) == (7, tiny, None)
    network, _ = load_network(path)
    assert all(torch.equal(value, checkpoint.network[name]) for name, value in network.state_dict().items())


def test_a_file_that_is_cut_short_hostile_or_something_else_is_one_clear_line(path, monkeypatch):
    monkeypatch.chdir(path.parent)
    content = torch.load(path, weights_only=True)
    bad = path.with_name("bad.ckpt")
    bad.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(InputError, match=r"bad\.ckpt: expected an undamaged file of torch"):
        load_network(bad)
    torch.save(content | {"optimiser": Attack()}, bad)
    with pytest.raises(
        InputError, match=r"bad\.ckpt: expected an undamaged file of torch, found something else, or mo"
    ):
        load_network(bad)
    # Somewhere in the weights, which torch itself would read without a word.
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    bad.write_bytes(data)
    with pytest.raises(InputError, match=r"expected an undamaged file of torch, found (a wrong checksum|Bad CRC)"):
        load_network(bad)
    with zipfile.ZipFile(bad, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("archive/data/0", bytes(1 << 20))
    with pytest.raises(InputError, match=r"found compressed members \(archive/data/0\)"):
        load_network(bad)
    assert not (path.parent / "attacked").exists()
    for change, message in (
        ({"schema_version": "glassware/checkpoint/9"}, "schema_version: expected glassware/checkpoint/1"),
        ({"settings": {"network": {"planes": 1}}}, r"settings: network\.planes: expected greater than or equal to 2"),
    ):
        torch.save(content | change, bad)
        with pytest.raises(InputError, match=message):
            load_network(bad)
    sparse = {"a": torch.eye(3).to_sparse()}
    for change, message in (
        ({"network": [1.0]}, "network: expected names and dense tensors, found list"),
        ({"network": {1: torch.zeros(1)}}, "network: expected names and dense tensors, found dict"),
        ({"network": sparse}, "network: expected names and dense tensors, found dict"),
        ({"ema": "abc"}, "ema: expected names and dense tensors, found str"),
        ({"rng": None}, "rng: expected a Tensor, found NoneType"),
        ({"optimiser": 3}, "optimiser: expected a dict, found int"),
        ({"step": 1 << 40}, "step: expected one of 0 to 20000, found 1099511627776"),
        ({"step": -1}, "step: expected one of 0 to 20000, found -1"),
        ({"best": math.nan}, "best: expected a number, found nan"),
        ({"network": content["network"] | {"matching.source.weight": torch.zeros(1)}}, "no such weights, found"),
    ):
        torch.save(content | change, bad)
        with pytest.raises(InputError, match=message):
            load_network(bad)
    first = next(iter(content["network"]))
    torch.save(content | {"network": content["network"] | {first: content["network"][first].long()}}, bad)
    with pytest.raises(InputError, match=r"expected \(.*\), found \(.*\) torch\.int64"):
        load_network(bad)
    torch.save({name: value for name, value in content.items() if name != "rng"}, bad)
    with pytest.raises(InputError, match="the field rng"):
        load_network(bad)
    torch.save([1, 2, 3], bad)
    with pytest.raises(InputError, match="schema_version: expected glassware/checkpoint/1, found list"):
        load_network(bad)
    with pytest.raises(InputError, match="a readable file, found none"):
        load_network(path.with_name("none.ckpt"))


def test_weights_of_another_network_are_one_clear_line(path, tiny):
    other = build_network(tiny.model_copy(update={"volume_channels": 6}))
    with pytest.raises(InputError, match=r"some\.ckpt: matching\.pair\.first\.0\.bias: expected \(6,\), found \(4,\)"):
        restore(other, load_checkpoint(path).network, path)


def test_a_released_checkpoint_is_known_by_its_names(tmp_path):
    from glassware.learn import ReferenceNetwork

    state = {f"model.{name}": value for name, value in ReferenceNetwork().state_dict().items()}
    torch.save({"state_dict": state, "epoch": 100, "global_step": 734169}, tmp_path / "released.ckpt")
    network, settings = load_network(tmp_path / "released.ckpt")
    assert isinstance(network, ReferenceNetwork)
    assert settings.network.variant == "reference"
