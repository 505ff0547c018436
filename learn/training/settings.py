"""Settings of a training run."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...core.model import Model
from ...core.user_text import UserPath
from ..data.settings import AugmentSettings, ViewSettings
from ..data.splits import SplitName
from ..networks.settings import NetworkSettings
from .loss_weights import LossWeights

_Beta = Annotated[float, Field(ge=0.0, lt=1.0)]


class OptimiserSettings(Model):
    """The optimiser and its learning rate; the defaults are the paper's (section IV-B)."""

    name: Literal["adam", "adamw"] = Field(default="adam", description="Adam, or Adam with decoupled weight decay")
    learning_rate: float = Field(default=6e-4, gt=0.0, le=1.0, description="Greatest learning rate")
    betas: tuple[_Beta, _Beta] = Field(
        default=(0.9, 0.99), description="Decay of the moving averages of the gradient and its square"
    )
    weight_decay: float = Field(default=1e-4, ge=0.0, le=1.0, description="Weight decay")
    clip: float = Field(default=10.0, gt=0.0, description="Greatest norm of the gradient; larger gradients are scaled")
    warmup: int = Field(default=100, ge=0, description="Steps of linear warm-up of the learning rate")
    schedule: Literal["constant", "polynomial", "cosine"] = Field(
        default="polynomial", description="Decay of the learning rate over the run: none, (1 - t)^0.9, or half a cosine"
    )
    ema: float = Field(
        default=0.0,
        ge=0.0,
        lt=1.0,
        description="Decay of the exponential moving average of the weights, which is then evaluated; 0: none",
    )
    frozen: tuple[str, ...] = Field(
        default=(),
        max_length=64,
        description="Parts of the network that stay as they are, such as context: few pictures do not spoil what many "
        "have taught. Names are the first parts of the names of weights",
    )


class MachineSettings(Model):
    """Devices, precision and processes of a run, as Lightning Fabric names them."""

    accelerator: str = Field(default="auto", description="cpu, cuda, mps or auto")
    devices: str = Field(default="auto", description="Number of devices of each machine, a list such as 0,2, or auto")
    nodes: int = Field(default=1, ge=1, description="Number of machines")
    strategy: str = Field(
        default="auto", description="auto, ddp, or ddp_find_unused_parameters_true (for the reference variant)"
    )
    precision: Literal["32-true", "bf16-mixed", "auto"] = Field(
        default="32-true",
        description="Precision of the network; auto: bf16-mixed where the device multiplies bfloat16 in hardware",
    )
    workers: int = Field(default=2, ge=0, le=256, description="Processes that load samples; 0: in the main process")
    threads: int | None = Field(default=None, ge=1, le=1024, description="CPU threads of torch; all cores by default")


class TrainSettings(Model):
    """All settings of a run; its data set and its output folder are separate."""

    network: NetworkSettings = NetworkSettings()
    views: ViewSettings = ViewSettings()
    augment: AugmentSettings = AugmentSettings()
    losses: LossWeights = LossWeights()
    optimiser: OptimiserSettings = OptimiserSettings()
    machine: MachineSettings = MachineSettings()
    pretrained: UserPath | None = Field(
        default=None, description="Weights of the context network with torchvision's names, .safetensors or torch file"
    )
    also: tuple[UserPath, ...] = Field(
        default=(),
        description="Further data sets whose training scenes are mixed with those of the first, for mvtrans and simnet",
    )
    seed: int = Field(default=0, ge=0, le=2**32 - 1, description="Seed of the initial weights and of all samples")
    steps: int = Field(default=20_000, ge=1, description="Optimiser steps")
    batch: int = Field(default=4, ge=1, le=4096, description="Samples per step, over all devices")
    train_split: SplitName = Field(default="train", description="Scenes to train on")
    val_split: SplitName | Literal["none"] = Field(default="val", description="Scenes to validate on")
    save_every: int = Field(default=500, ge=1, description="Steps between checkpoints")
    validate_every: int = Field(default=1000, ge=1, description="Steps between validations")
    validate_samples: int = Field(default=64, ge=1, description="Greatest number of validation samples")
    log_every: int = Field(default=20, ge=1, description="Steps between lines of the log")
    pictures_every: int = Field(default=500, ge=1, description="Steps between images in the log")
