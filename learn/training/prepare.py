"""What a training run works with: devices, samples, the network and its optimiser."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import torch
from lightning_fabric import Fabric

from ...core.errors import InputError
from ...dataset.reader import Dataset
from ..data.samples import SampleDataset
from ..networks.build import Network, build_network
from ..networks.corrected import CorrectedNetwork
from ..networks.resnet import load_pretrained
from ..networks.settings import NetworkSettings
from ..targets.encoding import encoding_of
from .checkpoint import DataRecord, data_digest
from .settings import MachineSettings, TrainSettings

#: The same for validation in every run: its samples are drawn once.
_VALIDATION_SEED = 0
#: How far beyond the depths of the training data planes reach, as a share: other scenes are a little larger.
_MARGIN = 0.1


@dataclass(frozen=True, eq=False)
class Parts:
    """What a run works with."""

    fabric: Fabric
    settings: TrainSettings
    train: SampleDataset
    val: SampleDataset | None
    data: DataRecord
    network: Network
    optimiser: torch.optim.Optimizer
    out: Path


def prepared(settings: TrainSettings, data: Path, out: Path) -> Parts:
    """Return the parts of a run, the network with its first weights; InputError where one cannot be."""
    machine = settings.machine
    fabric = _fabric(machine)
    fabric.launch()
    if settings.batch % fabric.world_size:
        raise InputError("batch", f"a multiple of the {fabric.world_size} devices", settings.batch)
    encoding = encoding_of(settings.network.variant)
    views, seed = settings.views, settings.seed
    learnt = SampleDataset(data, settings.train_split, views, encoding, augment=settings.augment, seed=seed)
    val = None
    if settings.val_split != "none":
        val = SampleDataset(data, settings.val_split, views, encoding, seed=_VALIDATION_SEED)
    settings = _with_range(settings, learnt)
    torch.manual_seed(settings.seed)
    network = build_network(settings.network)
    options = {"lr": settings.optimiser.rate, "betas": settings.optimiser.betas}
    kind = torch.optim.Adam if settings.optimiser.name == "adam" else torch.optim.AdamW
    network.to(fabric.device)
    optimiser = kind(network.parameters(), weight_decay=settings.optimiser.weight_decay, **options)
    head = Dataset.open(data).head
    record = DataRecord(name=head.name, seed=head.seed, sha256=data_digest(data))
    return Parts(fabric, settings, learnt, val, record, network, optimiser, out)


def _fabric(machine: MachineSettings) -> Fabric:
    try:
        return Fabric(
            accelerator=machine.accelerator,
            devices=machine.devices,
            num_nodes=machine.nodes,
            strategy=machine.strategy,
            precision=machine.precision,
        )
    except (ValueError, TypeError, RuntimeError) as error:  # what Lightning raises of names and numbers
        found = (str(error) or type(error).__name__).splitlines()[0]
        raise InputError("machine", "devices that are there and a strategy for them", found) from error


def _with_range(settings: TrainSettings, data: SampleDataset) -> TrainSettings:
    if settings.network.variant == "reference" or settings.network.depth_range is not None:
        return settings
    near, far = data.depth_range()
    limits = ((1.0 - _MARGIN) * near, (1.0 + _MARGIN) * far)
    network = settings.network.model_dump() | {"depth_range": limits}
    return settings.model_copy(update={"network": NetworkSettings.model_validate(network)})


def load_first_weights(parts: Parts) -> None:
    """Load the weights that the context network is to begin with, where some are named."""
    path = parts.settings.pretrained
    if path is None:
        return
    if not isinstance(parts.network, CorrectedNetwork):
        raise InputError("pretrained", "none with the reference, whose weights come from its checkpoints", path)
    load_pretrained(parts.network.context, path)
