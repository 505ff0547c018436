"""The settings that a scene is drawn from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from ...core.model import Model, Ordered
from ...core.user_text import UserPath
from ..description.picture import Picture
from ..placement.placement import PlacementSettings
from ..props.draw import PropSettings
from ..surroundings.camera_settings import CameraSettings
from ..surroundings.settings import EnvironmentSettings, LightSettings
from ..surroundings.table import TableSettings
from ..vessels.settings import VesselSettings
from ..vessels.sizes import check_volumes
from .splits import SplitSettings

_Vessels = Annotated[int, Field(ge=0, le=24)]
_Props = Annotated[int, Field(ge=0, le=24)]


class SceneSettings(Model):
    """Everything that a scene is drawn from, besides its seed and number."""

    vessel_count: Annotated[tuple[_Vessels, _Vessels], Ordered] = Field(
        default=(1, 7), description="Fewest and most vessels in a scene, within 0 and 24 (Syn-TODD: up to 7)"
    )
    prop_count: Annotated[tuple[_Props, _Props], Ordered] = Field(
        default=(0, 8), description="Fewest and most opaque props, within 0 and 24 (Syn-TODD: up to 8)"
    )
    mesh_dir: UserPath | None = Field(default=None, description="Folder of meshes for props (OBJ, PLY, GLB, STL)")
    texture_dir: UserPath | None = Field(
        default=None, description="Folder of pictures for plain props, and for the table without `table.texture_dir`"
    )
    vessels: VesselSettings = VesselSettings()
    props: PropSettings = PropSettings()
    table: TableSettings = TableSettings()
    environment: EnvironmentSettings = EnvironmentSettings()
    lights: LightSettings = LightSettings()
    cameras: CameraSettings = CameraSettings()
    placement: PlacementSettings = PlacementSettings()
    splits: SplitSettings = SplitSettings()
    picture: Picture = Picture()

    @property
    def table_texture_dir(self) -> Path | None:
        """Folder of pictures for the table's top: its own, or that of the props."""
        return self.texture_dir if self.table.texture_dir is None else self.table.texture_dir

    @model_validator(mode="after")
    def _volumes_fit(self) -> SceneSettings:
        check_volumes(self.vessels)
        return self
