"""From settings, a seed and a number to the description of a scene."""

from __future__ import annotations

from ...core.randomness import stream
from ..description.scene import FIRST_OBJECT_ID, GlassBody, Prop, Scene
from ..props.draw import PropSettings
from ..sensors.depth_cameras import depth_camera
from ..surroundings.camera_poses import draw_cameras, reach
from ..surroundings.environments import bake_environment, draw_environment
from ..surroundings.furnished_rooms import room_in_place, with_loose_things
from ..surroundings.lights import draw_lights
from ..surroundings.photographer import camera_exposure, toned_cameras
from ..surroundings.shipped_light import with_shipped_light
from ..surroundings.table import draw_table
from ..things.draw import draw_prop_of_kind
from .arrange import arranged
from .asset_files import AssetFiles, asset_files, files_for
from .draw_vessels import draw_vessels
from .settings import SceneSettings
from .solids import workspace
from .splits import families_of, split_of


def draw_scene(settings: SceneSettings, seed: int, scene_id: int, files: AssetFiles | None = None) -> Scene:
    """Draw a scene.

    Parameters
    ----------
    settings : SceneSettings
        The settings.
    seed : int
        Seed of the data set.
    scene_id : int
        Number of the scene. The scene depends on these three and the files in the settings' folders only.
    files : AssetFiles, optional
        What `asset_files` found in the settings' folders, for many scenes; they are searched without it.

    Raises
    ------
    InputError
        Where a folder of the settings or a file in it cannot be used, the objects do not fit on the table, or no pile
        of them comes to rest.
    """
    split = split_of(settings.splits, seed, scene_id)
    files = files_for(settings, files or asset_files(settings), seed, split)
    counts = stream(seed, scene_id, "counts")
    vessel_count = int(counts.integers(settings.vessel_count[0], settings.vessel_count[1] + 1))
    prop_count = int(counts.integers(settings.prop_count[0], settings.prop_count[1] + 1))
    families = families_of(settings.splits, seed, split, settings.vessels.categories)
    kinds = settings.vessels.model_copy(update={"categories": families})
    vessels, parts = draw_vessels(kinds, seed, scene_id, vessel_count, files)
    props = _props(settings.props, seed, scene_id, prop_count, FIRST_OBJECT_ID + vessel_count, files)
    kind = stream(seed, scene_id, "table/kind")
    table = draw_table(stream(seed, scene_id, "table"), settings.table, files.table_textures, kind)
    objects, rest = arranged([*vessels, *props], parts, table, settings, seed, scene_id)

    space = workspace(objects, table)
    environment = draw_environment(stream(seed, scene_id, "environment"), settings.environment, files.environments)
    environment = with_shipped_light(
        stream(seed, scene_id, "environment/shipped"), settings.environment, environment, files.shipped
    )
    far = reach(settings.cameras, space, files.poses)
    rng = stream(seed, scene_id, "environment/room")
    environment = room_in_place(rng, settings.environment, environment, table, far)
    pixels = bake_environment(environment)
    lights = draw_lights(stream(seed, scene_id, "lights"), settings.lights, far, environment, pixels)
    exposed, light = camera_exposure(table, environment, pixels, lights)
    cameras = draw_cameras(stream(seed, scene_id, "cameras"), settings.cameras, space, exposed, files.poses)
    cameras = toned_cameras(settings.cameras, cameras, light)
    environment = with_loose_things(rng, environment, table, lights, cameras, space)
    return Scene(
        seed=seed,
        scene_id=scene_id,
        table=table,
        vessels=tuple(item for item in objects if isinstance(item, GlassBody)),
        props=tuple(item for item in objects if isinstance(item, Prop)),
        environment=environment,
        lights=lights,
        cameras=cameras,
        picture=settings.picture,
        rest=rest,
        depth_camera=depth_camera(settings.sensors.depth),
    )


def _props(
    settings: PropSettings, seed: int, scene_id: int, count: int, first_id: int, files: AssetFiles
) -> list[Prop | GlassBody]:
    return [
        draw_prop_of_kind(
            stream(seed, scene_id, f"props/{i}"),
            stream(seed, scene_id, f"prop-kind/{i}"),
            settings,
            id=first_id + i,
            name=f"prop-{i:02d}",
            mesh_files=files.meshes,
            texture_files=files.textures,
        )
        for i in range(count)
    ]
