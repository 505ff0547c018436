"""What ``build-dataset`` may be asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...core.model import Model
from ...core.user_text import UserPath, UserText
from ...procedural.scene.settings import SceneSettings
from ..format.file_kinds import ALL, KINDS, NONE, FileKinds, costs
from ..settings.options import FLAT, Words
from ..settings.scene_ranges import LARGEST_SCENE
from .scene_request import check_infrared

#: As in CUDA_VISIBLE_DEVICES: a number, or the UUID of a GPU or of a MIG instance.
Device = Annotated[str, Field(pattern="^([0-9]+|(GPU|MIG)-[0-9A-Za-z/-]+)$")]


class BuildDataset(Model):
    """The request: settings, scenes, seed, output folder, and how the work is distributed."""

    settings: Annotated[SceneSettings, FLAT] = SceneSettings()
    scenes: str = Field(default="", description="Scenes, such as 0:2000 (without the end) or 3,7,10:20")
    count: int | None = Field(
        default=None, ge=1, le=LARGEST_SCENE + 1, description="Number of scenes, from scene 0 on: 20 is --scenes 0:20"
    )
    seed: int = Field(default=0, ge=0, le=2**63 - 1, description="Seed of the data set, 0 to 2^63 - 1")
    out: UserPath = Field(default=Path("data"), description="Output folder: absent, empty, or a data set to continue")
    name: UserText = Field(default="glassware", description="Name of the data set")
    preset: str = Field(
        default="fast", description="Settings to start from: fast, keypose, standard, syn-todd or train"
    )
    config: UserPath | None = Field(default=None, description="YAML file of settings on top of the preset")
    twin_of: UserPath | None = Field(
        default=None,
        description="With --twin: the data set of the same seed without it; files that are equal in both are stored "
        "once, as hard links",
    )
    write: Annotated[FileKinds, Words(*KINDS, ALL, NONE)] = Field(default=(), description=costs())
    yes: bool = Field(default=False, description="Build even where the disk is likely to fill up, without asking")
    workers: int = Field(default=1, ge=1, le=1024, description="Worker processes on this machine")
    threads: int | None = Field(
        default=None, ge=1, le=1024, description="Threads of each worker; by default the cores divided by the workers"
    )
    max_tasks_per_child: int = Field(
        default=50, ge=1, description="Scenes after which a worker process is replaced by a new one"
    )
    memory: float | None = Field(default=None, gt=0.0, description="Limit on the memory of each worker [GiB]")
    timeout: float = Field(
        default=3600.0, gt=0.0, description="Longest time without a message from a worker before it is killed [s]"
    )
    devices: tuple[Device, ...] = Field(
        default=(), description="CUDA devices, assigned to the workers in turn, such as 0 1 2"
    )
    shard: str | None = Field(default=None, description="i/n: render the i-th of n equal parts of the scenes")
    overwrite: bool = Field(default=False, description="Render existing scenes again")
    retry_failed: bool = Field(default=False, description="Render only the scenes whose last attempt failed")
    check: Literal["contents", "sizes"] = Field(
        default="contents", description="How the files of existing scenes are checked before they are kept"
    )
    executor: Literal["local", "ray"] = Field(
        default="local", description="Processes on this machine, or a Ray cluster"
    )
    address: str | None = Field(default=None, description="Address of the Ray cluster; by default one is started here")
    gpus: float = Field(default=0.0, ge=0.0, le=1.0, description="GPUs that a Ray task requests")

    @model_validator(mode="after")
    def _infrared_has_cameras(self) -> BuildDataset:
        check_infrared(self.write, self.settings)
        return self
