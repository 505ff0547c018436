"""Settings of sensors beside the colour cameras."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, field_validator

from ...core.model import Model
from ...core.user_text import UserPath
from .depth_cameras import depth_camera


class SensorSettings(Model):
    """What measures a scene beside the colour cameras."""

    depth: Literal["none", "d415", "d435"] | UserPath = Field(
        default="none",
        description="Depth camera beside the left colour camera: none, d415, d435, or a YAML file of a device of your "
        "own (docs/sensors.md)",
    )

    @field_validator("depth")
    @classmethod
    def _is_known(cls, depth: object) -> object:
        depth_camera(str(depth))
        return depth
