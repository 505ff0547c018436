"""``dataset.json``: what a data set is, and how it was made."""

from __future__ import annotations

import hashlib
from importlib import metadata
from typing import Any, Literal

from pydantic import Field

from ...core.assets import Asset
from ...core.json_file import json_text
from ...core.model import Model
from ...render.backend.llvm import compiler_version
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
    scenes: str = Field(default="", description="The scenes that it is to hold, such as 0:2000 (the end is not in it)")
    hashes: dict[str, str] = Field(
        default={}, description="SHA-256 of all that decides a scene besides seed and number: config, backend, assets"
    )
    assets: tuple[Asset, ...] = Field(default=(), description="Files of others in it, with their licences")


def installed_versions() -> dict[str, str]:
    """Return the versions of the packages, and of the compiler, that can change what is in a data set."""
    found = {"llvm": compiler_version()}
    for package in _PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found


def new_head(
    name: str, seed: int, config: dict[str, Any], versions: dict[str, str], backend: str, scenes: str = ""
) -> DatasetFile:
    """Return the head of a data set that is made here and now, with the hashes of what decides its scenes."""
    hashes = {"config": digest_of(config), "backend": digest_of({"backend": backend, "versions": versions})}
    return DatasetFile(
        name=name, seed=seed, config=config, versions=versions, backend=backend, scenes=scenes, hashes=hashes
    )


def digest_of(data: object) -> str:
    """Return the SHA-256 of JSON data in the one way that our files write it."""
    return hashlib.sha256(json_text(data).encode()).hexdigest()
