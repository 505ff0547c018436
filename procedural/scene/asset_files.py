"""Files of the user's folders that scenes draw from: listed once for all scenes, and read once to check them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from ...core.assets import asset
from ...core.passed_over import Finding, Progress, check_strict
from ..materials.picture_files import check_pictures, picture_files
from ..props.mesh_files import MeshFile, usable_meshes
from ..surroundings.hdri import hdri_files, read_hdri
from .settings import SceneSettings
from .splits import Split, files_of

F = TypeVar("F")


@dataclass(frozen=True)
class AssetFiles:
    """The files in the folders of the settings; none for a folder that is None."""

    environments: tuple[Path, ...] = ()
    meshes: tuple[MeshFile, ...] = ()
    textures: tuple[Path, ...] = ()
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
    hdri, textures = settings.environment.hdri_dir, settings.texture_dir
    meshes, findings = usable_meshes(settings.mesh_dir, progress)
    if settings.strict:
        check_strict(findings)
    return AssetFiles(
        environments=() if hdri is None else hdri_files(hdri),
        meshes=meshes,
        textures=() if textures is None else picture_files(textures),
        findings=findings,
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
        findings=files.findings,
    )


def check_inputs(settings: SceneSettings) -> None:
    """Read every file of the folders in the settings, and refuse invalid ones before any work begins.

    Parameters
    ----------
    settings : SceneSettings
        Folders that are None are skipped.

    Raises
    ------
    InputError
        Names the first folder or file that cannot be used.
    """
    if settings.environment.hdri_dir is not None:
        for path in hdri_files(settings.environment.hdri_dir):
            read_hdri(asset(path))
    if settings.texture_dir is not None:
        check_pictures(picture_files(settings.texture_dir))
