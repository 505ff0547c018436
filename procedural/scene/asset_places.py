"""Whether the folders that settings name are there; an error names the setting."""

from __future__ import annotations

from pathlib import Path

from ...core.errors import InputError
from .settings import SceneSettings

#: What each setting names.
_FOLDERS = {
    "environment.hdri_dir": "a folder of environment maps",
    "mesh_dir": "a folder of meshes, or a mesh file",
    "texture_dir": "a folder of pictures and materials",
    "table.texture_dir": "a folder of pictures and materials",
    "environment.texture_dir": "a folder of pictures and materials",
    "vessel_dir": "a folder of vessels, or a mesh file",
}


def check_asset_places(settings: SceneSettings) -> None:
    """Raise InputError, with the setting, where a folder that settings name is not there."""
    for name, what in _FOLDERS.items():
        value = settings
        for part in name.split("."):
            value = getattr(value, part)
        if isinstance(value, Path) and not value.exists():
            raise InputError(name, what, f"none at {value}")
