"""The files of the user's folders that scenes draw from: found once, then handed to every scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from ..materials.picture_files import picture_files
from ..props.mesh_files import MeshFile, mesh_files
from ..surroundings.hdri import hdri_files
from .settings import SceneSettings
from .splits import Split, files_of

F = TypeVar("F")


@dataclass(frozen=True)
class AssetFiles:
    """What is in the folders of the settings; nothing for a folder that is None."""

    environments: tuple[Path, ...] = ()
    meshes: tuple[MeshFile, ...] = ()
    textures: tuple[Path, ...] = ()


def asset_files(settings: SceneSettings) -> AssetFiles:
    """Return the files in the settings' folders; InputError where a folder or a file in it cannot be used."""
    hdri, meshes, textures = settings.environment.hdri_dir, settings.mesh_dir, settings.texture_dir
    return AssetFiles(
        environments=() if hdri is None else hdri_files(hdri),
        meshes=() if meshes is None else mesh_files(meshes),
        textures=() if textures is None else picture_files(textures),
    )


def files_for(settings: SceneSettings, files: AssetFiles, seed: int, split: Split) -> AssetFiles:
    """Return the files that scenes of a split draw from."""

    def kept(some: Sequence[F], name: Callable[[F], str]) -> tuple[F, ...]:
        return files_of(settings.splits, seed, split, some, name)

    hdri, textures = settings.environment.hdri_dir, settings.texture_dir
    return AssetFiles(
        environments=kept(files.environments, lambda path: path.relative_to(hdri or path).as_posix()),
        meshes=kept(files.meshes, lambda file: file.name),
        textures=kept(files.textures, lambda path: path.relative_to(textures or path).as_posix()),
    )
