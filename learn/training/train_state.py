"""The state of a training run: devices, data sets, network and optimiser; set up, or restored from a checkpoint."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import torch
from lightning_fabric import Fabric
from torch import Tensor

from ...core.errors import InputError
from ...core.model import differences
from ..data.dataset_digest import DatasetRecord, dataset_record
from ..data.samples import Samples
from ..data.settings import ViewSettings
from ..networks.build import Network, build_network
from ..networks.efficientnet import EfficientNet, load_efficientnet, published_weights
from ..networks.layers import set_memory_formats
from ..networks.mvtrans import MVTrans
from ..networks.resnet import load_pretrained
from ..networks.settings import NetworkSettings
from .checkpoint import Checkpoint, check_weights, load_weights
from .frozen import freeze
from .initial_weights import MAY_DIFFER, MAY_GROW
from .methods import samples_of, training_samples, with_data
from .settings import MachineSettings, TrainSettings

#: Seed of the validation samples: the same in every run, so that their losses compare.
_VALIDATION_SEED = 0
#: Settings that may change when a run resumes: they decide where it runs and what it logs, not what it computes.
_FREE = ("machine", "log_every", "pictures_every", "save_every")
#: Samples of a step for which batch norms over one picture of each are defined.
_LEAST_AT_HALF = 2


@dataclass(frozen=True, eq=False)
class TrainState:
    """All that the steps of a run use."""

    fabric: Fabric
    settings: TrainSettings
    train: Samples
    val: Samples | None
    data: DatasetRecord
    network: Network
    optimiser: torch.optim.Optimizer
    out: Path


def set_up_training(settings: TrainSettings, data: Path, out: Path) -> TrainState:
    """Launch the processes of a run, seed torch, and return the run's state with new weights.

    Raises
    ------
    InputError
        Where devices, data or settings cannot be used.
    """
    fabric = _fabric(settings.machine)
    fabric.launch()
    if settings.batch % fabric.world_size:
        raise InputError("batch", f"a multiple of the {fabric.world_size} devices", settings.batch)
    train = training_samples(settings, data)
    settings, train = with_data(settings, train)
    val = None
    if settings.val_split != "none":
        val = samples_of(settings, data, settings.val_split, seed=_VALIDATION_SEED)
    torch.manual_seed(settings.seed)
    network = build_network(settings.network)
    options = {"lr": settings.optimiser.learning_rate, "betas": settings.optimiser.betas}
    kind = torch.optim.Adam if settings.optimiser.name == "adam" else torch.optim.AdamW
    network.to(fabric.device)
    set_memory_formats(network)
    freeze(network, settings.optimiser.frozen)
    _check_batch(network, settings.batch // fabric.world_size)
    learnt = [parameter for parameter in network.parameters() if parameter.requires_grad]
    optimiser = kind(learnt, weight_decay=settings.optimiser.weight_decay, fused=True, **options)
    return TrainState(fabric, settings, train, val, dataset_record(data, settings.also), network, optimiser, out)


def _check_batch(network: Network, batch: int) -> None:
    """Refuse one sample a step where a batch norm would have a single value to normalise.

    The features of objects at half size see one picture of a sample, and average it as a whole; those of matching see
    two or more.
    """
    features = network.object_features if isinstance(network, MVTrans) and network.settings.norm == "batch" else None
    learns = features is not None and any(parameter.requires_grad for parameter in features.parameters())
    if learns and batch < _LEAST_AT_HALF:
        expected = f"{_LEAST_AT_HALF} or more on each device with network.objects_at half, or object_features frozen"
        raise InputError("batch", expected, batch)


def load_pretrained_context(state: TrainState) -> None:
    """Load the pretrained weights of the context network: of the file that the settings name, or of its package."""
    path = state.settings.pretrained
    context = state.network.context if isinstance(state.network, MVTrans) else None
    if isinstance(context, EfficientNet):
        load_efficientnet(context, path or published_weights())
    elif path is not None:
        if context is None:
            expected = "none for the reference variant and for other networks, whose weights come from checkpoints"
            raise InputError("pretrained", expected, path)
        load_pretrained(context, path)


def with_network_of(settings: TrainSettings, trained: TrainSettings, where: Path) -> TrainSettings:
    """Return settings with the network of trained weights, and their views where the settings leave these open.

    A run on nearer or farther things may ask for other planes, a refinement of depth, or more candidates for one, may
    be added, and objects may be found at half size (`initial_weights`). What is computed again to save memory is free.

    Raises
    ------
    InputError
        Where the settings ask for another network.
    """
    wanted, found = settings.network.model_dump(), trained.network.model_dump()
    default = NetworkSettings().model_dump()
    for name, value in wanted.items():
        grown = MAY_GROW.get(name, ())
        free = name in MAY_DIFFER or value in grown[grown.index(found[name]) if grown else 0 :]
        if not free and value not in (default[name], found[name]):
            raise InputError(f"{where}: network.{name}", f"{value}, as the settings say", found[name])
    of_views = (one.model_dump() for one in (settings.views, trained.views, ViewSettings()))
    views = ViewSettings.model_validate(_with_open_values(*of_views))
    moved = {name: wanted[name] for name in (*MAY_DIFFER, *MAY_GROW) if wanted[name] != default[name]}
    return settings.model_copy(update={"network": trained.network.model_copy(update=moved), "views": views})


def resumed_checkpoint(start: Checkpoint, settings: TrainSettings, data: Path, where: Path) -> Checkpoint:
    """Return a checkpoint with the new values of the settings that may change; InputError where others changed.

    Settings of the network and of the views that are left open are those of the checkpoint: its run may have taken
    them from its data, or from the weights that it began with.
    """
    if start.data is None or start.data.sha256 != dataset_record(data, settings.also).sha256:
        found = "none" if start.data is None else f"{start.data.name} with seed {start.data.seed} and other content"
        raise InputError(f"{where}: data set", f"that of {data}", found)
    new, old = settings.model_dump(mode="json"), start.settings.model_dump(mode="json")
    for group, default in (("network", NetworkSettings()), ("views", ViewSettings())):
        new[group] = _with_open_values(new[group], old[group], default.model_dump(mode="json"))
    for name, expected, found in differences(new, old):
        if name.partition(".")[0] not in _FREE:
            raise InputError(f"{where}: {name}", f"{expected}", f"{found} in the checkpoint")
    free = {name: getattr(settings, name) for name in _FREE}
    return replace(start, settings=start.settings.model_copy(update=free))


def restore_train_state(state: TrainState, start: Checkpoint, where: Path) -> None:
    """Load weights, optimiser state and random state of a checkpoint; InputError where one does not fit."""
    load_weights(state.network, start.network, where)
    if start.ema is not None:
        check_weights(state.network.state_dict(), start.ema, where)
    _load_optimiser(state.optimiser, start, where)
    try:
        torch.set_rng_state(start.rng)
    except (TypeError, RuntimeError) as error:
        raise InputError(f"{where}: rng", "a state of torch's generator", str(error).splitlines()[0]) from error


def optimiser_tensors(optimiser: torch.optim.Optimizer) -> dict[str, Tensor]:
    """Return the state of an optimiser by ``<parameter number>.<field>``; Adam's are step, exp_avg, exp_avg_sq."""
    state = optimiser.state_dict()["state"]
    return {f"{number}.{field}": value for number, fields in state.items() for field, value in fields.items()}


def _load_optimiser(optimiser: torch.optim.Optimizer, start: Checkpoint, where: Path) -> None:
    """Load the tensors of `optimiser_tensors`; parameters that no loss depends on have none."""
    state: dict[int, dict[str, Tensor]] = {}
    expected: dict[str, Tensor] = {}
    parameters = [value for group in optimiser.param_groups for value in group["params"]]
    for number, parameter in enumerate(parameters):
        moment = torch.zeros_like(parameter, device="cpu")
        fields = {"step": torch.zeros(()), "exp_avg": moment, "exp_avg_sq": moment}
        if any(f"{number}.{field}" in start.optimiser for field in fields):
            expected |= {f"{number}.{field}": value for field, value in fields.items()}
            state[number] = {field: start.optimiser.get(f"{number}.{field}", moment) for field in fields}
    check_weights(expected, start.optimiser, f"{where}: optimiser")
    if start.step and not state:
        raise InputError(f"{where}: optimiser", "a state for the weights", "none")
    for number, fields in state.items():
        # The fused optimiser walks through memory, so moments are laid out as their weights are.
        for name in ("exp_avg", "exp_avg_sq"):
            fields[name] = torch.empty_like(parameters[number], device="cpu").copy_(fields[name])
    optimiser.load_state_dict({"state": state, "param_groups": optimiser.state_dict()["param_groups"]})


def _fabric(machine: MachineSettings) -> Fabric:
    try:
        return Fabric(
            accelerator=machine.accelerator,
            devices=machine.devices,
            num_nodes=machine.nodes,
            strategy=machine.strategy,
            precision=_precision(machine),
        )
    except (ValueError, TypeError, RuntimeError) as error:  # Lightning's errors for unknown names and numbers
        found = (str(error) or type(error).__name__).splitlines()[0]
        raise InputError("machine", "existing devices and a strategy for them", found) from error


def _precision(machine: MachineSettings) -> Literal["32-true", "bf16-mixed"]:
    """Return the precision of a run: by `auto`, bfloat16 where the device multiplies it in hardware.

    Emulated, as on processors without its instructions, bfloat16 takes twice the time of float32.
    """
    if machine.precision != "auto":
        return machine.precision
    if machine.accelerator == "cpu" or not torch.cuda.is_available():
        has = torch.cpu.get_capabilities()
        return "bf16-mixed" if has.get("avx512_bf16") or has.get("amx_bf16") else "32-true"
    return "bf16-mixed" if torch.cuda.is_bf16_supported(including_emulation=False) else "32-true"


def _with_open_values(new: dict[str, Any], old: dict[str, Any], default: dict[str, Any]) -> dict[str, Any]:
    """Return settings with those of a checkpoint where they are left open, at their default."""
    result = dict(new)
    for name, value in new.items():
        if isinstance(value, dict):
            result[name] = _with_open_values(value, old[name], default[name])
        elif value == default[name]:
            result[name] = old[name]
    return result
