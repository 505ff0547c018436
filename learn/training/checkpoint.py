"""Checkpoints: one safetensors file with weights, optimiser state, random state, settings and data set.

Tensors are named ``network.<name>``, ``ema.<name>``, ``optimiser.<parameter>.<field>`` and ``rng.cpu``. The metadata
entry ``checkpoint`` is a `CheckpointHeader` as JSON.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import torch
from pydantic import Field, ValidationError
from pydantic_core import from_json
from torch import Tensor

from ...core.errors import InputError
from ...core.json_file import json_text
from ...core.model import Model
from ...core.setting_errors import setting_error
from ..data.dataset_digest import DatasetRecord
from ..networks.build import Network, build_network
from ..networks.reference import load_reference
from ..networks.weights_file import (
    is_safetensors,
    read_metadata,
    read_safetensors,
    read_weights,
    write_safetensors,
)
from .settings import TrainSettings
from .weights import ENTRY, WeightsHeader, read_shipped, weights_path

CHECKPOINT_SCHEMA = "glassware/checkpoint/2"
#: Groups of tensors, and the state of torch's generator on the CPU.
_GROUPS, _RNG = ("network", "ema", "optimiser", "rng"), "rng.cpu"


class CheckpointHeader(Model):
    """All of a checkpoint but its tensors."""

    schema_version: Literal["glassware/checkpoint/2"] = CHECKPOINT_SCHEMA
    settings: TrainSettings
    data: DatasetRecord | None
    step: int = Field(ge=0)
    best_loss: float | None


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """The state of a training run, from which it resumes and from which its network is used."""

    settings: TrainSettings
    data: DatasetRecord | None  #: None for weights that were not trained here
    step: int  #: optimiser steps taken
    network: dict[str, Tensor]
    ema: dict[str, Tensor] | None  #: exponential moving average of the weights, where the run keeps one
    optimiser: dict[str, Tensor]  #: of `train_state.optimiser_tensors`
    rng: Tensor  #: state of torch's generator on the CPU
    best_loss: float  #: least validation loss so far; infinite before the first validation

    def eval_weights(self) -> dict[str, Tensor]:
        """Return the weights to evaluate: their moving average where the run keeps one."""
        return self.network if self.ema is None else self.ema


def save_checkpoint(path: Path, checkpoint: Checkpoint) -> None:
    """Write a checkpoint; the file appears complete or not at all."""
    header = CheckpointHeader(
        settings=checkpoint.settings,
        data=checkpoint.data,
        step=checkpoint.step,
        best_loss=checkpoint.best_loss if math.isfinite(checkpoint.best_loss) else None,
    )
    groups = {"network": checkpoint.network, "ema": checkpoint.ema or {}, "optimiser": checkpoint.optimiser}
    tensors = {f"{group}.{name}": value for group, values in groups.items() for name, value in values.items()}
    write_safetensors(
        path, {**tensors, _RNG: checkpoint.rng}, {"checkpoint": json_text(header.model_dump(mode="json"))}
    )


def load_checkpoint(path: Path) -> Checkpoint:
    """Return a checkpoint; InputError where the file is damaged or no checkpoint of ours."""
    tensors, metadata = read_safetensors(path)
    if ENTRY in metadata:
        raise InputError(path, "a checkpoint of glassware train", "weights alone, from which --init begins a run")
    if "checkpoint" not in metadata:
        raise InputError(path, "a checkpoint of glassware train", "a safetensors file without its header")
    try:
        # Not by `model_validate_json`, whose strict mode refuses the paths among the settings.
        header = CheckpointHeader.model_validate(from_json(metadata["checkpoint"], allow_inf_nan=False), strict=False)
    except ValidationError as error:
        raise setting_error(path, error, CheckpointHeader) from error
    except ValueError as error:  # pydantic's for a text that is no JSON
        raise InputError(path, "a checkpoint of glassware train", "a header that is no JSON") from error
    if header.step > header.settings.steps:
        raise InputError(f"{path}: step", f"one of 0 to {header.settings.steps}", header.step)
    groups: dict[str, dict[str, Tensor]] = {group: {} for group in _GROUPS}
    for name, value in tensors.items():
        group, _, rest = name.partition(".")
        if group not in groups:
            raise InputError(f"{path}: {name}", f"a tensor of {', '.join(_GROUPS)}", "another name")
        groups[group][rest] = value
    if _RNG not in tensors:
        raise InputError(path, f"the tensor {_RNG}", "none")
    return Checkpoint(
        settings=header.settings,
        data=header.data,
        step=header.step,
        network=groups["network"],
        ema=groups["ema"] or None,
        optimiser=groups["optimiser"],
        rng=tensors[_RNG],
        best_loss=math.inf if header.best_loss is None else header.best_loss,
    )


@dataclass(frozen=True, eq=False)
class TrainedWeights:
    """The weights of a network that is to be used, or that a run begins with."""

    settings: TrainSettings
    weights: dict[str, Tensor]
    header: WeightsHeader | None  #: None for a checkpoint


def load_trained(path: Path) -> TrainedWeights:
    """Return settings and weights of a checkpoint of ours (the averaged ones), or of weights alone (`weights`).

    Parameters
    ----------
    path : Path
        A file, or the name of weights that come with glassware.
    """
    path = weights_path(path)
    if ENTRY in read_metadata(path):
        header, weights = read_shipped(path)
        return TrainedWeights(TrainSettings(network=header.network, views=header.views), weights, header)
    checkpoint = load_checkpoint(path)
    return TrainedWeights(checkpoint.settings, checkpoint.eval_weights(), None)


def load_network(path: Path) -> tuple[Network, TrainSettings]:
    """Return the network of a file in evaluation mode, and its settings.

    The file is a checkpoint of ours, weights alone (or their name), or a torch file with the weights of the released
    code.
    """
    path = weights_path(path)
    if not is_safetensors(path):
        settings = TrainSettings.model_validate({"network": {"variant": "reference"}})
        return load_reference(read_weights(path), str(path)), settings
    trained = load_trained(path)
    network = build_network(trained.settings.network)
    load_weights(network, trained.weights, path)
    return network.eval(), trained.settings


def load_weights(network: torch.nn.Module, weights: Mapping[str, Tensor], where: Path) -> None:
    """Load weights into a network; InputError for the first one that does not fit."""
    check_weights(network.state_dict(), weights, where)
    network.load_state_dict(weights)


def check_weights(expected: Mapping[str, Tensor], found: Mapping[str, Tensor], where: Path | str) -> None:
    """Raise InputError for the first tensor that is missing, not expected, or of another shape or type."""
    for name in sorted(expected.keys() | found.keys()):
        wanted = _shape(expected[name]) if name in expected else "no such tensor"
        given = _shape(found[name]) if name in found else "none"
        if wanted != given:
            raise InputError(f"{where}: {name}", wanted, f"{given} (weights of another version or network?)")


def _shape(value: Tensor) -> str:
    return f"{tuple(value.shape)}" + ("" if value.dtype == torch.float32 else f" {value.dtype}")
