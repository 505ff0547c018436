"""How a network is trained."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...core.model import Model
from ...core.user_text import UserPath
from ..data.settings import AugmentSettings, ViewSettings
from ..networks.settings import NetworkSettings
from .losses import LossWeights

_Beta = Annotated[float, Field(ge=0.0, lt=1.0)]


class OptimiserSettings(Model):
    """The optimiser and its rate; the default is the paper's (section IV-B)."""

    name: Literal["adam", "adamw"] = Field(default="adam", description="Adam, or with decoupled weight decay")
    rate: float = Field(default=6e-4, gt=0.0, le=1.0, description="Greatest learning rate")
    betas: tuple[_Beta, _Beta] = Field(default=(0.9, 0.99), description="Decay of the means of gradient and its square")
    weight_decay: float = Field(default=1e-4, ge=0.0, le=1.0, description="Weight decay")
    clip: float = Field(default=10.0, gt=0.0, description="Greatest norm of the gradient of all weights together")
    warmup: int = Field(default=100, ge=0, description="Steps in which the rate rises from 0")
    schedule: Literal["constant", "polynomial", "cosine"] = Field(
        default="polynomial", description="How the rate falls to 0 over the run: (1 - t)^0.9, or half a cosine"
    )
    ema: float = Field(
        default=0.0, ge=0.0, lt=1.0, description="Decay of the mean of the weights that is kept and evaluated; 0: none"
    )


class MachineSettings(Model):
    """Where it runs: Lightning's own settings."""

    accelerator: str = Field(default="auto", description="cpu, cuda, mps or auto")
    devices: str = Field(default="auto", description="Number of devices of each machine, a list such as 0,2, or auto")
    nodes: int = Field(default=1, ge=1, description="Machines")
    strategy: str = Field(default="auto", description="auto, ddp, ddp_find_unused_parameters_true (for the reference)")
    precision: Literal["32-true", "bf16-mixed"] = Field(default="32-true", description="Of the network's arithmetic")
    workers: int = Field(default=2, ge=0, le=256, description="Processes that load samples; 0: none but this one")
    threads: int | None = Field(default=None, ge=1, le=1024, description="Threads of torch; all cores unless given")


class TrainSettings(Model):
    """A whole run but for its data and where it is written."""

    network: NetworkSettings = NetworkSettings()
    views: ViewSettings = ViewSettings()
    augment: AugmentSettings = AugmentSettings()
    losses: LossWeights = LossWeights()
    optimiser: OptimiserSettings = OptimiserSettings()
    machine: MachineSettings = MachineSettings()
    pretrained: UserPath | None = Field(
        default=None, description="State dict of the context network with torchvision's names"
    )
    seed: int = Field(default=0, ge=0, le=2**32 - 1, description="Of the first weights and of all draws")
    steps: int = Field(default=20_000, ge=1, description="Steps of the optimiser in all")
    batch: int = Field(default=4, ge=1, le=4096, description="Samples of a step, over all devices")
    train_split: str = Field(default="train", description="Scenes to learn from; all: every one")
    val_split: str = Field(default="val", description="Scenes to choose the best weights by; none: none")
    save_every: int = Field(default=500, ge=1, description="Steps between two checkpoints")
    validate_every: int = Field(default=1000, ge=1, description="Steps between two looks at the validation scenes")
    validate_samples: int = Field(default=64, ge=1, description="Samples of such a look, at most")
    log_every: int = Field(default=20, ge=1, description="Steps between two lines of the log")
    pictures_every: int = Field(default=500, ge=1, description="Steps between two pictures in the log")
