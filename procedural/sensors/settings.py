"""Settings of sensors beside the colour cameras."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, field_validator

from ...core.errors import InputError
from ...core.model import Model
from ...core.user_text import UserPath
from .depth_cameras import depth_camera

#: The setting, as errors of `depth_camera` name it.
_WHERE = "sensors.depth: "


class SensorSettings(Model):
    """What measures a scene beside the colour cameras."""

    depth: Literal["none", "d415", "d435", "l515"] | UserPath = Field(
        default="none",
        description="Depth camera beside the left colour camera: none, d415, d435, l515, or a YAML file of a device "
        "of your own (docs/sensors.md)",
    )

    @field_validator("depth")
    @classmethod
    def _is_known(cls, depth: object) -> object:
        try:
            depth_camera(str(depth))
        except InputError as error:
            if str(error).startswith(_WHERE):  # the field is named by whoever reports it
                raise ValueError(str(error).removeprefix(_WHERE)) from error
            raise
        return depth
