"""Files of the user's folders that scenes draw from: listed once for all scenes, and read once to check them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from ...core.passed_over import Finding, Progress, check_strict
from ..materials.surface_files import SurfaceFiles, usable_surfaces
from ..props.mesh_files import MeshFile, usable_meshes
from ..surroundings.hdri import usable_hdris
from ..surroundings.shipped_light import shipped_maps
from .settings import SceneSettings
from .splits import Split, files_of

F = TypeVar("F")


@dataclass(frozen=True)
class AssetFiles:
    """The files in the folders of the settings; none for a folder that is None."""

    environments: tuple[Path, ...] = ()
    meshes: tuple[MeshFile, ...] = ()
    textures: tuple[SurfaceFiles, ...] = ()
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
    environments, of_light = usable_hdris(settings.environment.hdri_dir, progress)
    meshes, of_meshes = usable_meshes(settings.mesh_dir, progress, choice=settings.props.choice)
    textures, of_textures = usable_surfaces(settings.texture_dir, settings.texture_side, progress)
    findings = (*of_light, *of_meshes, *of_textures)
    if settings.strict:
        check_strict(findings)
    return AssetFiles(environments, meshes, textures, shipped_maps(), findings)


def files_for(settings: SceneSettings, files: AssetFiles, seed: int, split: Split) -> AssetFiles:
    """Return the files that scenes of a split draw from."""

    def kept(some: Sequence[F], name: Callable[[F], str]) -> tuple[F, ...]:
        return files_of(settings.splits, seed, split, some, name)

    hdri = settings.environment.hdri_dir
    return AssetFiles(
        environments=kept(files.environments, lambda path: path.relative_to(hdri or path).as_posix()),
        meshes=kept(files.meshes, lambda file: file.name),
        textures=kept(files.textures, lambda item: item.name),
        shipped=kept(files.shipped, lambda path: path.name),
        findings=files.findings,
    )
