"""Checkpoints: weights with the settings that made them and the data that they learnt from.

A checkpoint is a file of torch that holds tensors, numbers, texts, lists and dicts alone, and is read as such.
"""

from __future__ import annotations

import hashlib
import io
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from pydantic import Field, ValidationError
from torch import Tensor

from ...core.atomic_io import write_atomically
from ...core.errors import InputError
from ...core.model import Model
from ...core.setting_errors import setting_error
from ...dataset.format import layout
from ..networks.build import Network, build_network
from ..networks.reference import load_reference
from ..networks.weights_file import read_torch
from .settings import TrainSettings

CHECKPOINT_SCHEMA = "glassware/checkpoint/1"


class DataRecord(Model):
    """The data set that a network learnt from."""

    name: str
    seed: int
    sha256: str = Field(description="Of its head, its splits and the checksums of every scene (`data_digest`)")


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """All that a run needs to go on, and all that its network needs to be used."""

    settings: TrainSettings
    data: DataRecord | None  #: None for weights that were not trained here
    step: int  #: steps taken
    network: dict[str, Tensor]
    ema: dict[str, Tensor] | None  #: the mean of the weights, where it is kept
    optimiser: dict[str, Any]
    rng: Tensor  #: state of torch's generator
    best: float  #: least validation loss so far; infinite before the first

    def used(self) -> dict[str, Tensor]:
        """Return the weights that are evaluated: their mean where it is kept."""
        return self.network if self.ema is None else self.ema


def save_checkpoint(path: Path, checkpoint: Checkpoint) -> None:
    """Write a checkpoint; the file appears whole or not at all."""
    content = {
        "schema_version": CHECKPOINT_SCHEMA,
        "settings": checkpoint.settings.model_dump(mode="json"),
        "data": None if checkpoint.data is None else checkpoint.data.model_dump(mode="json"),
        "step": checkpoint.step,
        "network": checkpoint.network,
        "ema": checkpoint.ema,
        "optimiser": checkpoint.optimiser,
        "rng": checkpoint.rng,
        "best": checkpoint.best,
    }
    buffer = io.BytesIO()
    torch.save(content, buffer)
    write_atomically(path, buffer.getvalue())


def load_checkpoint(path: Path) -> Checkpoint:
    """Return a checkpoint; InputError where the file is none, is damaged, or holds more than data."""
    content = read_torch(path)
    found = content.get("schema_version", "none") if isinstance(content, dict) else type(content).__name__
    if found != CHECKPOINT_SCHEMA:
        raise InputError(f"{path}: schema_version", CHECKPOINT_SCHEMA, found)
    missing = {"settings", "data", "step", "network", "ema", "optimiser", "rng", "best"} - content.keys()
    if missing:
        raise InputError(path, f"the field {min(missing)}", "none")
    try:
        settings = TrainSettings.model_validate(content["settings"])
        data = None if content["data"] is None else DataRecord.model_validate(content["data"])
    except ValidationError as error:
        raise setting_error(f"{path}: settings", error, TrainSettings) from error
    _check_kinds(content, path)
    names = ("step", "network", "ema", "optimiser", "rng", "best")
    return Checkpoint(settings, data, **{name: content[name] for name in names})


def _check_kinds(content: dict[str, Any], path: Path) -> None:
    """Raise InputError where a field of a checkpoint is of another kind than `save_checkpoint` writes."""
    for name in ("network", "ema"):
        value = content[name]
        if not (_is_state_dict(value) or (name == "ema" and value is None)):
            raise InputError(f"{path}: {name}", "names and dense tensors", type(value).__name__)
    for name, kind in (("step", int), ("best", float), ("optimiser", dict), ("rng", Tensor)):
        if not isinstance(content[name], kind):
            raise InputError(f"{path}: {name}", f"a {kind.__name__}", type(content[name]).__name__)
    steps = content["settings"]["steps"]
    if not 0 <= content["step"] <= steps:
        raise InputError(f"{path}: step", f"one of 0 to {steps}", content["step"])
    if math.isnan(content["best"]):
        raise InputError(f"{path}: best", "a number", "nan")


def _is_state_dict(value: object) -> bool:
    return isinstance(value, dict) and all(
        isinstance(name, str) and isinstance(one, Tensor) and one.layout == torch.strided and not one.is_meta
        for name, one in value.items()
    )


def load_network(path: Path) -> tuple[Network, TrainSettings]:
    """Return the network of a file in evaluation mode, and its settings.

    The file is a checkpoint of ours, or one of the released code: a state dict, or a dict that has it as
    ``state_dict``.
    """
    content = read_torch(path)
    if isinstance(content, dict) and "schema_version" not in content:
        released = content.get("state_dict", content)
        if _is_state_dict(released) and any(name.startswith(("model.", "matchingFeature.")) for name in released):
            settings = TrainSettings.model_validate({"network": {"variant": "reference"}})
            return load_reference(released, str(path)), settings
    checkpoint = load_checkpoint(path)
    network = build_network(checkpoint.settings.network)
    restore(network, checkpoint.used(), path)
    return network.eval(), checkpoint.settings


def restore(network: torch.nn.Module, weights: dict[str, Tensor], where: Path) -> None:
    """Load weights into a network; InputError that names the first one which does not fit."""
    check_weights(network, weights, where)
    network.load_state_dict(weights)


def check_weights(network: torch.nn.Module, weights: dict[str, Tensor], where: Path) -> None:
    """Raise InputError that names the first weights which a network has not, or has of another shape or type."""
    own = network.state_dict()
    for name in sorted(own.keys() | weights.keys()):
        expected = _shape(own[name]) if name in own else "no such weights"
        found = _shape(weights[name]) if name in weights else "none"
        if expected != found:
            raise InputError(f"{where}: {name}", f"{expected}", found)


def _shape(value: Tensor) -> str:
    return f"{tuple(value.shape)}" + ("" if value.dtype == torch.float32 else f" {value.dtype}")


def data_digest(root: Path) -> str:
    """Return a digest of a data set: its head, its splits, and each scene's number and checksums of all its files."""
    digest = hashlib.sha256(_content(root / layout.DATASET))
    if (root / layout.SPLITS).is_file():
        digest.update((root / layout.SPLITS).read_bytes())
    for scene_id in layout.scene_ids(root):
        digest.update(layout.scene_name(scene_id).encode())
        digest.update(_content(layout.scene_folder(root, scene_id) / layout.CHECKSUMS))
    return digest.hexdigest()


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, "a readable file of a data set", error.strerror) from error
