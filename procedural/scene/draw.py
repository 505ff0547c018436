"""From settings, a seed and a number to the description of a scene."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.mesh import Mesh
from ...core.randomness import stream
from ..description.scene import FIRST_OBJECT_ID, GlassBody, MeshVessel, Prop, Scene, SceneObject, Vessel
from ..placement.placement import CONTACT_GAP, draw_positions, footprint
from ..placement.resting import lowered, resting_pose, turn_about_z
from ..props.draw import PropSettings
from ..surroundings.camera_poses import draw_cameras, reach
from ..surroundings.environments import bake_environment, draw_environment
from ..surroundings.lights import draw_lights
from ..surroundings.metering import exposure, irradiance
from ..surroundings.shipped_light import with_shipped_light
from ..surroundings.table import draw_table, outline
from ..things.draw import draw_prop_of_kind, prop_pose
from .asset_files import AssetFiles, asset_files, files_for
from .draw_vessels import Parts, draw_vessels, group_mesh, lies
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
        Where a folder of the settings or a file in it cannot be used, or the objects do not fit on the table.
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
    objects = _placed([*vessels, *props], parts, outline(table), settings, seed, scene_id)

    space = workspace(objects, table)
    environment = draw_environment(stream(seed, scene_id, "environment"), settings.environment, files.environments)
    environment = with_shipped_light(
        stream(seed, scene_id, "environment/shipped"), settings.environment, environment, files.shipped
    )
    pixels = bake_environment(environment)
    far = reach(settings.cameras, space, files.poses)
    lights = draw_lights(stream(seed, scene_id, "lights"), settings.lights, far, environment, pixels)
    exposed = exposure(irradiance(pixels, environment.strength, lights))
    cameras = draw_cameras(stream(seed, scene_id, "cameras"), settings.cameras, space, exposed, files.poses)
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


def _placed(
    objects: list[SceneObject], parts: Parts, board: np.ndarray, settings: SceneSettings, seed: int, scene_id: int
) -> list[SceneObject]:
    """Return the objects in their places: vessels upright, props in a stable pose; each with its parts behind them."""
    groups = [parts.get(item.name, ()) for item in objects]
    solids = [group_mesh(item, own) for item, own in zip(objects, groups, strict=True)]
    poses = [
        _pose(item, solid, own, stream(seed, scene_id, f"pose/{item.name}"))
        for item, solid, own in zip(objects, solids, groups, strict=True)
    ]
    outlines = [footprint(solid, pose) for solid, pose in zip(solids, poses, strict=True)]
    shifts = draw_positions(outlines, board, settings.placement, stream(seed, scene_id, "placement"))
    placed, behind = [], []
    for item, own, pose, shift in zip(objects, groups, poses, shifts, strict=True):
        world_T_object = pose.copy()
        world_T_object[:3, 3] += [*shift, CONTACT_GAP]
        placed.append(item.model_copy(update={"world_T_object": world_T_object}))
        behind += [part.model_copy(update={"world_T_object": world_T_object @ part.world_T_object}) for part in own]
    first = FIRST_OBJECT_ID + len(placed)
    return placed + [part.model_copy(update={"id": first + number}) for number, part in enumerate(behind)]


def _pose(item: SceneObject, solid: Mesh, parts: Sequence[SceneObject], rng: np.random.Generator) -> np.ndarray:
    if isinstance(item, Prop):
        return prop_pose(item, rng)
    if not isinstance(item, Vessel | MeshVessel) or lies(item, parts):
        return resting_pose(solid, rng)
    return lowered(turn_about_z(rng.uniform(0.0, 2.0 * np.pi)), solid)
