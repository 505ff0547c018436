"""Parts of a network that a run leaves as they are."""

from __future__ import annotations

import pytest
import torch

from glassware.core.errors import InputError
from glassware.learn.networks.build import build_network
from glassware.learn.training.checkpoint import load_checkpoint
from glassware.learn.training.frozen import freeze
from glassware.learn.training.run import train


def test_frozen_parts_keep_weights_and_statistics_and_the_others_learn(settings, rendered, tmp_path):
    optimiser = settings.optimiser.model_copy(update={"frozen": ("context", "pyramid"), "ema": 0.5})
    train(settings.model_copy(update={"optimiser": optimiser}), rendered, tmp_path, None, lambda line: None)
    found = load_checkpoint(tmp_path / "last.safetensors")
    torch.manual_seed(settings.seed)
    first = build_network(found.settings.network).state_dict()
    assert found.ema is not None
    for name, value in first.items():
        if name.startswith(("context.", "pyramid.")):
            assert torch.equal(found.network[name], value), name
            assert torch.equal(found.ema[name], value), name
        elif name.startswith("features.") and name.endswith((".weight", "running_mean")):
            assert not torch.equal(found.network[name], value), name


def test_one_sample_a_step_is_refused_where_a_batch_norm_has_one_value(settings, rendered, tmp_path):
    network = settings.network.model_copy(update={"objects_at": "half", "norm": "batch"})
    changes = {"network": network, "views": settings.views.model_copy(update={"size": (64, 128)})}
    one = settings.model_copy(update={**changes, "batch": 1, "steps": 1, "val_split": "none"})
    with pytest.raises(InputError, match=r"batch: expected 2 or more on each device with network\.objects_at half"):
        train(one, rendered, tmp_path / "one", None, lambda line: None)
    frozen = one.optimiser.model_copy(update={"frozen": ("object_features",)})
    train(one.model_copy(update={"optimiser": frozen}), rendered, tmp_path / "frozen", None, lambda line: None)
    assert load_checkpoint(tmp_path / "frozen" / "last.safetensors").step == 1


def test_only_parts_that_exist_can_be_frozen_and_one_must_learn(tiny):
    network = build_network(tiny)
    with pytest.raises(
        InputError, match=r"optimiser\.frozen: expected parts of the network: features,.*context.*found contxt"
    ):
        freeze(network, ["contxt"])
    with pytest.raises(InputError, match=r"optimiser\.frozen: expected a part that is trained, found none"):
        freeze(network, [name for name, _ in network.named_children()])
