"""``dataset.json``, the head of a data set: its seed, settings, versions, scenes and assets."""

from __future__ import annotations

import hashlib
from importlib import metadata
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from ...core.assets import Asset
from ...core.atomic_io import write_atomically
from ...core.json_file import check_schema, json_text, parsed, read_json
from ...core.model import Model
from ...core.passed_over import Finding
from ...procedural.description.rest import Rest
from ...procedural.scene.asset_files import AssetFiles
from ...render.backend.llvm import compiler_version
from ..cameras.model import ColourCamera
from .conversion import Conversion
from .file_kinds import EARLIER_KINDS, KINDS, FileKinds
from .layout import DATASET, DATASET_SCHEMA

#: Packages whose version can change what is in a data set.
_PACKAGES = (
    "glassware",
    "mitsuba",
    "drjit",
    "pyoidn",
    "mujoco-core",
    "coacd",
    "numpy",
    "scipy",
    "trimesh",
    "OpenEXR",
    "opencv-python-headless",
)


class MeshRecord(Model):
    """A mesh of the user's folders that scenes draw from."""

    file: str = Field(description="Below the folder, with forward slashes")
    layout: str = Field(description="Layout of the folder, such as shapenet, gso, ycb, bop or plain")
    category: str = Field(description="As labels have it")
    licence: str = Field(description="As the file or its folder states it, or unknown")


class PileCounts(Model):
    """What was drawn again in the scenes of a data set so that their piles came to rest."""

    scenes: int = Field(default=0, description="Scenes with a pile")
    drawn_again: int = Field(default=0, description="Piles that did not come to rest, and were drawn again")
    given_up: int = Field(
        default=0, description="Scenes in which no pile came to rest, so that all objects stand apart"
    )
    fell_again: int = Field(
        default=0, description="Objects that fell again, as they left the table or did not come to rest"
    )


def counted_in(counts: PileCounts, rest: Rest | None) -> PileCounts:
    """Return the counts with one more scene."""
    if rest is None:
        return counts
    return PileCounts(
        scenes=counts.scenes + (not rest.given_up),
        drawn_again=counts.drawn_again + rest.attempt - 1,
        given_up=counts.given_up + rest.given_up,
        fell_again=counts.fell_again + rest.fell_again,
    )


class Development(Model):
    """By which camera the pictures of a data set were developed from their radiance."""

    camera: ColourCamera = Field(description="All its figures")
    seed: int = Field(ge=0, description="Of its errors and its noise")


class DatasetFile(Model):
    """Describes a data set, and everything that its content depends on."""

    schema_version: Literal["glassware/dataset/1"] = DATASET_SCHEMA
    name: str = Field(description="Name of the data set")
    seed: int = Field(ge=0, description="Seed of all its scenes")
    config: dict[str, Any] = Field(description="The resolved settings of its scenes, as JSON data")
    versions: dict[str, str] = Field(description="Version of each package that can change its content")
    backend: str = Field(description="Variant of the renderer, such as llvm_ad_rgb")
    scenes: str = Field(default="", description="The scenes that it is meant to hold, such as 0:2000 (without the end)")
    hashes: dict[str, str] = Field(
        default={}, description="SHA-256 of what a scene depends on besides seed and number: config, backend, assets"
    )
    files: FileKinds = Field(
        default=EARLIER_KINDS,
        description="Files of each view beside those that every view has; in data sets of earlier versions, four",
    )
    assets: tuple[Asset, ...] = Field(default=(), description="Asset files in it, with their licences")
    meshes: tuple[MeshRecord, ...] = Field(
        default=(), description="Meshes that its scenes draw from, as props and as vessels"
    )
    findings: tuple[Finding, ...] = Field(
        default=(), description="Files of the asset folders that were passed over, or of which something is not used"
    )
    piles: PileCounts | None = Field(
        default=None, description="Counts of its piles; null in data sets of earlier versions and in unfinished ones"
    )
    developed: Development | None = Field(
        default=None,
        exclude_if=lambda record: record is None,
        description="Camera of `glassware develop`; absent where the pictures are as they were built",
    )
    converted: Conversion | None = Field(
        default=None,
        exclude_if=lambda record: record is None,
        description="Of which data set of another project it was made; absent where it was rendered",
    )


def installed_versions() -> dict[str, str]:
    """Return the versions of the packages and of the compiler that can change the content of a data set."""
    found = {"llvm": compiler_version()}
    for package in _PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found


def new_head(
    name: str,
    seed: int,
    config: dict[str, Any],
    versions: dict[str, str],
    backend: str,
    scenes: str = "",
    files: FileKinds = KINDS,
) -> DatasetFile:
    """Return the head of a new data set, with the hashes of its settings and of the software."""
    hashes = {"config": digest_of(config), "backend": digest_of({"backend": backend, "versions": versions})}
    return DatasetFile(
        name=name,
        seed=seed,
        config=config,
        versions=versions,
        backend=backend,
        scenes=scenes,
        hashes=hashes,
        files=files,
    )


def with_files(head: DatasetFile, files: AssetFiles) -> DatasetFile:
    """Return the head of a data set with the meshes that scenes draw from, and what was found about the files."""
    meshes = tuple(
        MeshRecord(file=file.name, layout=file.place.layout, category=file.category, licence=file.place.licence)
        for file in (*files.meshes, *files.vessels)
    )
    return head.model_copy(update={"meshes": meshes, "findings": files.findings})


def digest_of(data: object) -> str:
    """Return the SHA-256 of JSON data, as `core.json_file.json_text` writes it."""
    return hashlib.sha256(json_text(data).encode()).hexdigest()


def read_head(root: Path) -> DatasetFile:
    """Read ``dataset.json``; InputError where it is missing, damaged, or of an unknown schema."""
    path = root / DATASET
    data = read_json(path)
    check_schema(path, data, DATASET_SCHEMA)
    return parsed(DatasetFile, data, path)


def write_head(root: Path, head: DatasetFile) -> None:
    """Write ``dataset.json`` atomically."""
    write_atomically(root / DATASET, json_text(head.model_dump(mode="json")).encode())
