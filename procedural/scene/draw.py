"""From settings, a seed and a number to the description of a scene."""

from __future__ import annotations

import numpy as np

from ...core.randomness import stream
from ..description.scene import FIRST_OBJECT_ID, GlassBody, MeshVessel, Prop, Scene, SceneObject, Vessel
from ..own_vessels.draw import draw_own_vessel
from ..placement.placement import CONTACT_GAP, draw_positions, footprint
from ..placement.resting import lowered, resting_pose, turn_about_z
from ..props.draw import PropSettings, draw_prop
from ..surroundings.camera_poses import draw_cameras, reach
from ..surroundings.environments import bake_environment, draw_environment
from ..surroundings.furnished_rooms import room_in_place, with_loose_things
from ..surroundings.lights import draw_lights
from ..surroundings.photographer import camera_exposure, toned_cameras
from ..surroundings.shipped_light import with_shipped_light
from ..surroundings.table import draw_table, outline
from ..vessels.draw import draw_vessel
from ..vessels.media import draw_media
from ..vessels.settings import VesselSettings
from ..vessels.sizes import draw_size
from .asset_files import AssetFiles, asset_files, files_for
from .settings import SceneSettings
from .solids import body_mesh, workspace
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
        Where a folder of the settings or a file in it cannot be used, or the objects do not fit on the table.
    """
    split = split_of(settings.splits, seed, scene_id)
    files = files_for(settings, files or asset_files(settings), seed, split)
    counts = stream(seed, scene_id, "counts")
    vessel_count = int(counts.integers(settings.vessel_count[0], settings.vessel_count[1] + 1))
    prop_count = int(counts.integers(settings.prop_count[0], settings.prop_count[1] + 1))
    families = families_of(settings.splits, seed, split, settings.vessels.categories)
    kinds = settings.vessels.model_copy(update={"categories": families})
    vessels = _vessels(kinds, seed, scene_id, vessel_count, files)
    props = _props(settings.props, seed, scene_id, prop_count, FIRST_OBJECT_ID + vessel_count, files)
    table = draw_table(stream(seed, scene_id, "table"), settings.table, files.table_textures)
    objects = _placed([*vessels, *props], outline(table), settings, seed, scene_id)

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
    )


def _vessels(settings: VesselSettings, seed: int, scene_id: int, count: int, files: AssetFiles) -> list[GlassBody]:
    return [_vessel(settings, seed, scene_id, i, files) for i in range(count)]


def _vessel(settings: VesselSettings, seed: int, scene_id: int, number: int, files: AssetFiles) -> GlassBody:
    place, media = f"vessels/{number}", stream(seed, scene_id, f"media/{number}")
    id, name = FIRST_OBJECT_ID + number, f"vessel-{number:02d}"
    if files.vessels:
        choice = stream(seed, scene_id, f"vessel-file/{number}")
        file = files.vessels[int(choice.integers(len(files.vessels)))]
        if choice.random() < settings.file_probability:
            rng = stream(seed, scene_id, place)
            return draw_own_vessel(rng, media, settings, file, id=id, name=name, own=files.media)
    # The family is the first that a vessel's stream gives; the wall's material follows it.
    category, *_ = draw_size(stream(seed, scene_id, place), settings)
    glass, liquid = draw_media(media, settings, category, files.media)
    return draw_vessel(stream(seed, scene_id, place), settings, id=id, name=name, glass=glass, liquid_medium=liquid)


def _props(
    settings: PropSettings, seed: int, scene_id: int, count: int, first_id: int, files: AssetFiles
) -> list[Prop | GlassBody]:
    return [
        draw_prop(
            stream(seed, scene_id, f"props/{i}"),
            settings,
            id=first_id + i,
            name=f"prop-{i:02d}",
            mesh_files=files.meshes,
            texture_files=files.textures,
        )
        for i in range(count)
    ]


def _placed(
    objects: list[SceneObject], board: np.ndarray, settings: SceneSettings, seed: int, scene_id: int
) -> list[SceneObject]:
    """Return the objects in their places: vessels upright, props in a stable pose."""
    poses = [_pose(item, stream(seed, scene_id, f"pose/{item.name}")) for item in objects]
    outlines = [footprint(body_mesh(item), pose) for item, pose in zip(objects, poses, strict=True)]
    shifts = draw_positions(outlines, board, settings.placement, stream(seed, scene_id, "placement"))
    placed = []
    for item, pose, shift in zip(objects, poses, shifts, strict=True):
        world_T_object = pose.copy()
        world_T_object[:3, 3] += [*shift, CONTACT_GAP]
        placed.append(item.model_copy(update={"world_T_object": world_T_object}))
    return placed


def _pose(item: SceneObject, rng: np.random.Generator) -> np.ndarray:
    if not isinstance(item, Vessel | MeshVessel):
        return resting_pose(body_mesh(item), rng)
    return lowered(turn_about_z(rng.uniform(0.0, 2.0 * np.pi)), body_mesh(item))
