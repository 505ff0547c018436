"""From settings, a seed and a number to the description of a scene."""

from __future__ import annotations

from ...core.randomness import stream
from ..description.scene import FIRST_OBJECT_ID, GlassBody, Prop, Scene
from ..props.draw import PropSettings
from ..sensors.depth_cameras import depth_camera
from ..sensors.polarisation_cameras import polarisation_camera
from ..sensors.sensitivities import sensitivities
from ..surroundings.table import draw_table
from ..things.draw import draw_prop_of_kind
from .arrange import arranged
from .asset_files import AssetFiles, asset_files, files_for
from .draw_near_infrared import with_near_infrared
from .draw_surroundings import draw_surroundings
from .draw_vessels import draw_vessels
from .settings import SceneSettings
from .splits import families_of, split_of
from .twins import twin_of


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
    kind, prints = (stream(seed, scene_id, f"table/{name}") for name in ("kind", "prints"))
    table = draw_table(stream(seed, scene_id, "table"), settings.table, files.table_textures, kind, prints)
    objects, rest, placed_again = arranged([*vessels, *props], parts, table, settings, seed, scene_id)

    around = draw_surroundings(settings, seed, scene_id, files, table, objects)
    scene = Scene(
        seed=seed,
        scene_id=scene_id,
        table=table,
        vessels=tuple(item for item in objects if isinstance(item, GlassBody)),
        props=tuple(item for item in objects if isinstance(item, Prop)),
        environment=around.environment,
        lights=around.lights,
        cameras=around.cameras,
        picture=settings.picture,
        rest=rest,
        placed_again=placed_again,
        depth_camera=depth_camera(settings.sensors.depth),
        polarisation_camera=polarisation_camera(settings.sensors.polarisation),
        sensitivities=sensitivities(settings.sensors.sensitivities),
    )
    if scene.depth_camera is not None:
        scene = with_near_infrared(scene, settings.sensors.carbon_black)
    return scene if settings.twin == "none" else twin_of(scene, settings.twin, settings, files)


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
