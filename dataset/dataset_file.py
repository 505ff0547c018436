"""``dataset.json``: what a data set is, and how it was made."""

from __future__ import annotations

from importlib import metadata
from typing import Any, Literal

from pydantic import Field

from ..procedural.assets import Asset
from ..procedural.model import Model
from ..render.frame import LightCheck
from .layout import DATASET_SCHEMA

#: Packages whose version can change what is in a data set.
_PACKAGES = (
    "glassware",
    "mitsuba",
    "drjit",
    "pyoidn",
    "numpy",
    "scipy",
    "trimesh",
    "OpenEXR",
    "opencv-python-headless",
)


class DatasetFile(Model):
    """The head of a data set."""

    schema_version: Literal["glassware/dataset/1"] = DATASET_SCHEMA
    name: str = Field(description="Name of the data set")
    seed: int = Field(ge=0, description="Seed of all its scenes")
    config: dict[str, Any] = Field(description="The resolved settings that shape its scenes, as JSON data")
    versions: dict[str, str] = Field(description="Version of each package that can change its content")
    backend: str = Field(description="Variant of the renderer, such as llvm_ad_rgb")
    light: tuple[LightCheck, ...] = Field(
        default=(), description="How the pictures from stored light compare with path-traced ones, scene by scene"
    )
    assets: tuple[Asset, ...] = Field(default=(), description="Files of others in it, with their licences")


def installed_versions() -> dict[str, str]:
    """Return the versions of the packages that can change what is in a data set."""
    found = {}
    for package in _PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found
