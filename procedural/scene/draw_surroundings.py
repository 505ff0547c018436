"""Draw what is around the table of a scene: surroundings, lamps, and cameras exposed for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.randomness import stream
from ..description.camera import Camera
from ..description.scene import SceneObject
from ..description.surroundings import AreaLight, Environment, Table
from ..surroundings.camera_poses import draw_cameras, reach
from ..surroundings.environments import bake_environment, draw_environment
from ..surroundings.furnished_rooms import room_in_place, with_loose_things
from ..surroundings.lights import draw_lights
from ..surroundings.photographer import camera_exposure, toned_cameras
from ..surroundings.room_pictures import with_pictures
from ..surroundings.shipped_light import with_shipped_light
from .asset_files import AssetFiles
from .settings import SceneSettings
from .solids import workspace


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What is around a table."""

    environment: Environment
    lights: tuple[AreaLight, ...]
    cameras: tuple[Camera, ...]


def draw_surroundings(
    settings: SceneSettings,
    seed: int,
    scene_id: int,
    files: AssetFiles,
    table: Table,
    objects: Sequence[SceneObject],
    cameras: tuple[Camera, ...] | None = None,
    prefix: str = "",
) -> Surroundings:
    """Draw surroundings, lamps and cameras.

    Parameters
    ----------
    settings, seed, scene_id, files : SceneSettings, int, int, AssetFiles
        As `draw.draw_scene` has them.
    table : Table
        The table.
    objects : sequence of SceneObject
        What stands on it.
    cameras : tuple of Camera, optional
        Cameras that keep their places and are exposed anew; they are drawn without it.
    prefix : str
        Start of the names of the random streams.
    """

    def rng_of(name: str) -> np.random.Generator:
        return stream(seed, scene_id, prefix + name)

    space = workspace(objects, table)
    environment = draw_environment(rng_of("environment"), settings.environment, files.environments)
    environment = with_shipped_light(rng_of("environment/shipped"), settings.environment, environment, files.shipped)
    far = reach(settings.cameras, space, files.poses)
    rng = rng_of("environment/room")
    environment = room_in_place(rng, settings.environment, environment, table, far)
    environment = with_pictures(rng_of("environment/textures"), environment, files.room_textures)
    pixels = bake_environment(environment)
    lights = draw_lights(rng_of("lights"), settings.lights, far, environment, pixels)
    exposed, light = camera_exposure(table, environment, pixels, lights)
    if cameras is None:
        cameras = draw_cameras(rng_of("cameras"), settings.cameras, space, exposed, files.poses)
    else:
        cameras = tuple(camera.model_copy(update={"exposure": exposed}) for camera in cameras)
    cameras = toned_cameras(settings.cameras, cameras, light)
    environment = with_loose_things(rng, environment, table, lights, cameras, space)
    return Surroundings(environment, lights, cameras)
