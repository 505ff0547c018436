"""What ``render-scene`` may be asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from ...core.model import Model
from ...core.user_text import UserPath, UserText
from ...procedural.description.depth_camera import DepthCamera
from ...procedural.scene.settings import SceneSettings
from ...procedural.sensors.depth_cameras import depth_camera
from ..format.file_kinds import ALL, KINDS, NONE, FileKinds, costs
from ..settings.options import FLAT, Words


def check_infrared(files: FileKinds, settings: SceneSettings) -> None:
    """Raise ValueError where infrared pictures are asked for by name, and no camera takes any."""
    device = settings.sensors.depth
    if "infrared" not in files or files == KINDS or isinstance(depth_camera(device), DepthCamera):
        return
    expected = "infrared with a stereo depth camera alone, such as sensors.depth d435"
    raise ValueError(f"write: expected {expected}, found sensors.depth {device}")


class RenderScene(Model):
    """The request: settings, seed, scene number and output folder."""

    settings: Annotated[SceneSettings, FLAT] = SceneSettings()
    seed: int = Field(default=0, ge=0, le=2**63 - 1, description="Seed of the data set, 0 to 2^63 - 1")
    scene: int = Field(default=0, ge=0, le=999_999, description="Number of the scene in the data set, 0 to 999999")
    out: UserPath = Field(default=Path("out"), description="Folder of the data set: absent, empty, or one made before")
    name: UserText = Field(default="glassware", description="Name of the data set")
    preset: str = Field(
        default="fast", description="Settings to start from: fast, keypose, standard, syn-todd or train"
    )
    config: UserPath | None = Field(default=None, description="YAML file of settings on top of the preset")
    write: Annotated[FileKinds, Words(*KINDS, ALL, NONE)] = Field(default=(), description=costs())
    verbose: bool = Field(default=False, description="Print the time of each stage, and the check of the light")

    @model_validator(mode="after")
    def _infrared_has_cameras(self) -> RenderScene:
        check_infrared(self.write, self.settings)
        return self
