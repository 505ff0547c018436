"""Files of the user's folders that scenes draw from: listed once for all scenes, and read once to check them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from ...core.passed_over import Finding, Progress, check_strict
from ..materials.surface_files import SurfaceFiles, usable_surfaces
from ..optics.draw import NO_MEDIA
from ..optics.medium import Medium
from ..own_vessels.files import VesselFile
from ..own_vessels.usable import usable_vessels
from ..props.mesh_files import MeshFile, usable_meshes
from ..surroundings.camera_poses import poses_of
from ..surroundings.hdri import usable_hdris
from ..surroundings.pose_files import FilePose
from ..surroundings.room_pictures import usable_room_pictures
from ..surroundings.shipped_light import shipped_maps
from ..vessels.media import own_media
from .asset_places import check_asset_places
from .settings import SceneSettings
from .splits import Split, files_of

F = TypeVar("F")


@dataclass(frozen=True)
class AssetFiles:
    """The files in the folders of the settings, none for a folder that is None; and own media by name."""

    environments: tuple[Path, ...] = ()
    meshes: tuple[MeshFile, ...] = ()
    textures: tuple[SurfaceFiles, ...] = ()
    table_textures: tuple[SurfaceFiles, ...] = ()  #: those of the props, unless the table has a folder of its own
    room_textures: tuple[SurfaceFiles, ...] = ()
    vessels: tuple[VesselFile, ...] = ()
    poses: tuple[FilePose, ...] = ()
    media: Mapping[str, Medium] = field(default_factory=lambda: NO_MEDIA)
    shipped: tuple[Path, ...] = ()  #: environment maps of the package
    findings: tuple[Finding, ...] = ()  #: what was passed over, and remarks


def asset_files(settings: SceneSettings, progress: Progress | None = None) -> AssetFiles:
    """Return the usable files in the settings' folders, each checked once, and what was found about the others.

    Parameters
    ----------
    settings : SceneSettings
        Folders that are None are skipped.
    progress : callable, optional
        Is told how far the check is.

    Raises
    ------
    InputError
        Where a folder cannot be used or no file in it can; with `settings.strict` where any file cannot.
    """
    check_asset_places(settings)
    environments, of_light = usable_hdris(settings.environment.hdri_dir, progress)
    meshes, of_meshes = usable_meshes(settings.mesh_dir, progress, choice=settings.props.choice)
    textures, of_textures = usable_surfaces(settings.texture_dir, settings.texture_size, progress)
    tables, of_tables = textures, ()
    if settings.table.texture_dir is not None:
        name = "table.texture_dir"
        tables, of_tables = usable_surfaces(settings.table.texture_dir, settings.texture_size, progress, name)
    rooms, of_rooms = usable_room_pictures(settings.environment.texture_dir, settings.texture_size, progress)
    vessels, of_vessels = usable_vessels(settings.vessel_dir, settings.vessels, progress)
    findings = (*of_light, *of_meshes, *of_vessels, *of_textures, *of_tables, *of_rooms)
    if settings.strict:
        check_strict(findings)
    return AssetFiles(
        environments=environments,
        meshes=meshes,
        textures=textures,
        table_textures=tables,
        room_textures=rooms,
        vessels=vessels,
        poses=poses_of(settings.cameras),
        media=own_media(settings.vessels),
        shipped=shipped_maps(),
        findings=findings,
    )


def files_for(settings: SceneSettings, files: AssetFiles, seed: int, split: Split) -> AssetFiles:
    """Return the files that scenes of a split draw from."""

    def kept(some: Sequence[F], name: Callable[[F], str]) -> tuple[F, ...]:
        return files_of(settings.splits, seed, split, some, name)

    hdri = settings.environment.hdri_dir
    return replace(
        files,
        environments=kept(files.environments, lambda path: path.relative_to(hdri or path).as_posix()),
        meshes=kept(files.meshes, lambda file: file.name),
        textures=kept(files.textures, lambda item: item.name),
        table_textures=kept(files.table_textures, lambda item: item.name),
        room_textures=kept(files.room_textures, lambda item: item.name),
        vessels=kept(files.vessels, lambda file: file.name),
        shipped=kept(files.shipped, lambda path: path.name),
    )
