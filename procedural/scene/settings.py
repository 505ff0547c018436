"""The settings that a scene is drawn from."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...core.errors import InputError
from ...core.model import Model, Ordered
from ...core.units import Length
from ...core.user_text import UserPath
from ..description.picture import Picture
from ..description.twin import TwinKind
from ..materials.surface_files import PICTURE_SIDE
from ..physics.settings import PhysicsSettings
from ..placement.placement import PlacementSettings
from ..props.draw import PropSettings
from ..sensors.settings import SensorSettings
from ..surroundings.camera_settings import CameraSettings
from ..surroundings.settings import EnvironmentSettings, LightSettings
from ..surroundings.table import TableSettings
from ..vessels.settings import VesselSettings
from ..vessels.sizes import check_volumes
from .splits import SplitSettings

_Vessels = Annotated[int, Field(ge=0, le=24)]
_Side = Annotated[Length, Field(ge=0.01, le=100.0)]
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
    vessel_dir: UserPath | None = Field(
        default=None,
        description="Folder of vessels, or one file: closed meshes that are taken as glass (OBJ, PLY, GLB, STL)",
    )
    texture_dir: UserPath | None = Field(
        default=None,
        description="Folder of pictures and of materials with maps for plain props, and for the table without "
        "`table.texture_dir`",
    )
    texture_size: Annotated[tuple[_Side, _Side], Ordered] = Field(
        default=PICTURE_SIDE,
        description="Range of the width of what a picture or a material shows [m], where no file beside it states it; "
        "the same number twice states it",
    )
    strict: bool = Field(default=False, description="End where a file of the folders cannot be used, not pass over it")
    twin: Literal["none"] | TwinKind = Field(
        default="none",
        description="Make a counterfactual twin of each scene: painted glass (opaque), vessels without liquid and ice "
        "(empty), no vessels (clean-plate), other light, or other glasses and liquids (media); all else is the same",
    )
    vessels: VesselSettings = VesselSettings()
    props: PropSettings = PropSettings()
    table: TableSettings = TableSettings()
    environment: EnvironmentSettings = EnvironmentSettings()
    lights: LightSettings = LightSettings()
    cameras: CameraSettings = CameraSettings()
    placement: PlacementSettings = PlacementSettings()
    physics: PhysicsSettings = PhysicsSettings()
    sensors: SensorSettings = SensorSettings()
    splits: SplitSettings = SplitSettings()
    picture: Picture = Picture()

    @model_validator(mode="after")
    def _volumes_fit(self) -> SceneSettings:
        if self.vessel_dir is None or self.vessels.file_probability < 1.0:  # files have the sizes that they have
            check_volumes(self.vessels)
        return self

    @model_validator(mode="after")
    def _sensitivities_have_wavelengths(self) -> SceneSettings:
        if self.sensors.sensitivities != "none" and not self.picture.spectral:
            found = f"sensors.sensitivities {self.sensors.sensitivities} with it off"
            raise InputError("picture.spectral", "on, as sensitivities belong to wavelengths", found)
        return self

    @model_validator(mode="after")
    def _cameras_see_true_optics(self) -> SceneSettings:
        """Refuse depth and polarisation cameras beside simplified optics, which they would follow in part alone."""
        cameras = {"depth": self.sensors.depth, "polarisation": self.sensors.polarisation}
        with_camera = next((name for name, device in cameras.items() if device != "none"), None)
        simplified = self.picture.simplified
        if simplified and with_camera is not None:
            name, (true, found) = next(iter(simplified.items()))
            raise InputError(f"picture.{name}", f"{true} with sensors.{with_camera}", found)
        return self
