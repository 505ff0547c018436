"""Files of the user's folders that scenes draw from: listed once for all scenes, and read once to check them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from ...core.assets import asset
from ..materials.picture_files import check_pictures, picture_files
from ..optics.draw import NO_MEDIA
from ..optics.medium import Medium
from ..props.mesh_files import MeshFile, check_meshes, mesh_files
from ..surroundings.camera_poses import poses_of
from ..surroundings.hdri import hdri_files, read_hdri
from ..surroundings.pose_files import FilePose
from ..vessels.media import own_media
from .settings import SceneSettings
from .splits import Split, files_of

F = TypeVar("F")


@dataclass(frozen=True)
class AssetFiles:
    """The files in the folders of the settings, none for a folder that is None; and own media by name."""

    environments: tuple[Path, ...] = ()
    meshes: tuple[MeshFile, ...] = ()
    textures: tuple[Path, ...] = ()
    table_textures: tuple[Path, ...] = ()  #: those of the props, unless the table has a folder of its own
    poses: tuple[FilePose, ...] = ()
    media: Mapping[str, Medium] = field(default_factory=lambda: NO_MEDIA)


def asset_files(settings: SceneSettings) -> AssetFiles:
    """Return the files in the settings' folders; InputError where a folder or a file in it cannot be used."""
    hdri, meshes, textures = settings.environment.hdri_dir, settings.mesh_dir, settings.texture_dir
    tables = settings.table_texture_dir
    return AssetFiles(
        environments=() if hdri is None else hdri_files(hdri),
        meshes=() if meshes is None else mesh_files(meshes),
        textures=() if textures is None else picture_files(textures),
        table_textures=() if tables is None else picture_files(tables),
        poses=poses_of(settings.cameras),
        media=own_media(settings.vessels),
    )


def files_for(settings: SceneSettings, files: AssetFiles, seed: int, split: Split) -> AssetFiles:
    """Return the files that scenes of a split draw from."""

    def kept(some: Sequence[F], name: Callable[[F], str]) -> tuple[F, ...]:
        return files_of(settings.splits, seed, split, some, name)

    hdri, textures, tables = settings.environment.hdri_dir, settings.texture_dir, settings.table_texture_dir
    return replace(
        files,
        environments=kept(files.environments, lambda path: path.relative_to(hdri or path).as_posix()),
        meshes=kept(files.meshes, lambda file: file.name),
        textures=kept(files.textures, lambda path: path.relative_to(textures or path).as_posix()),
        table_textures=kept(files.table_textures, lambda path: path.relative_to(tables or path).as_posix()),
        poses=files.poses,
    )


def check_inputs(settings: SceneSettings) -> None:
    """Read every file that the settings name, and refuse invalid ones before any work begins.

    Parameters
    ----------
    settings : SceneSettings
        Folders that are None are skipped.

    Raises
    ------
    InputError
        Names the first folder or file that cannot be used.
    """
    own_media(settings.vessels)
    if settings.environment.hdri_dir is not None:
        for path in hdri_files(settings.environment.hdri_dir):
            read_hdri(asset(path))
    if settings.mesh_dir is not None:
        check_meshes(mesh_files(settings.mesh_dir))
    if settings.texture_dir is not None:
        check_pictures(picture_files(settings.texture_dir))
    if settings.table.texture_dir is not None:
        check_pictures(picture_files(settings.table.texture_dir))
    poses_of(settings.cameras)
