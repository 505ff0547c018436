"""Everything that a request takes from the user's folders, read once before any work begins."""

from __future__ import annotations

from ...core.assets import asset
from ..materials.picture_files import check_pictures, picture_files
from ..props.mesh_files import check_meshes, mesh_files
from ..surroundings.hdri import hdri_files, read_hdri
from .settings import SceneSettings


def check_inputs(settings: SceneSettings) -> None:
    """Read every file of the folders in the settings: a bad one is refused, whether a scene would draw it or not.

    Parameters
    ----------
    settings : SceneSettings
        Folders that are None are not looked at.

    Raises
    ------
    InputError
        Names the first folder or file that cannot be used.
    """
    if settings.environment.hdri_dir is not None:
        for path in hdri_files(settings.environment.hdri_dir):
            read_hdri(asset(path))
    if settings.mesh_dir is not None:
        check_meshes(mesh_files(settings.mesh_dir))
    if settings.texture_dir is not None:
        check_pictures(picture_files(settings.texture_dir))
