"""``splits.json``: the scenes of each split, and the vessel families and asset files that only test scenes have."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Literal, get_args

from pydantic import Field

from ...core.atomic_io import write_atomically
from ...core.json_file import check_schema, json_text, parsed, read_json
from ...core.model import Model
from ...core.weighted import weights_of
from ...procedural.scene.asset_files import AssetFiles, files_for
from ...procedural.scene.settings import SceneSettings
from ...procedural.scene.splits import Split, families_of, split_of
from . import layout

SPLITS_SCHEMA = "glassware/splits/1"


class SplitsFile(Model):
    """The scenes for training, validation and test; a function of the seed, the settings and the scenes' numbers."""

    schema_version: Literal["glassware/splits/1"] = SPLITS_SCHEMA
    train: tuple[int, ...]
    val: tuple[int, ...]
    test: tuple[int, ...]
    unseen_families: tuple[str, ...] = Field(description="Vessel families that only test scenes have")
    unseen_assets: dict[str, tuple[str, ...]] = Field(description="Asset files that only test scenes use, by folder")


def splits_file(settings: SceneSettings, files: AssetFiles, seed: int, scenes: Iterable[int]) -> SplitsFile:
    """Return the record of the given scenes."""
    by_split: dict[Split, list[int]] = {"train": [], "val": [], "test": []}
    for scene in sorted(scenes):
        by_split[split_of(settings.splits, seed, scene)].append(scene)
    families = settings.vessels.categories
    held_families = families_of(settings.splits, seed, "test", families) if settings.splits.unseen_families else ()
    return SplitsFile(
        train=tuple(by_split["train"]),
        val=tuple(by_split["val"]),
        test=tuple(by_split["test"]),
        unseen_families=tuple(weights_of(held_families)),
        unseen_assets=_unseen(settings, files, seed) if settings.splits.unseen_assets else {},
    )


def _unseen(settings: SceneSettings, files: AssetFiles, seed: int) -> dict[str, tuple[str, ...]]:
    held = files_for(settings, files, seed, "test")
    hdri = settings.environment.hdri_dir or Path()
    names = {
        "hdri_dir": tuple(path.relative_to(hdri).as_posix() for path in held.environments),
        "mesh_dir": tuple(file.name for file in held.meshes),
        "vessel_dir": tuple(file.name for file in held.vessels),
        "shipped": tuple(path.name for path in held.shipped),
        "texture_dir": tuple(item.name for item in held.textures),
    }
    if settings.table.texture_dir is not None:
        names["table.texture_dir"] = tuple(item.name for item in held.table_textures)
    if settings.environment.texture_dir is not None:
        names["environment.texture_dir"] = tuple(item.name for item in held.room_textures)
    return {folder: found for folder, found in names.items() if found}


def write_splits(root: Path, record: SplitsFile) -> None:
    """Write ``splits.json``."""
    write_atomically(root / layout.SPLITS, json_text(record.model_dump(mode="json")).encode())


def read_splits(root: Path) -> SplitsFile:
    """Read ``splits.json``; InputError where it is missing or damaged."""
    path = root / layout.SPLITS
    data = read_json(path)
    check_schema(path, data, SPLITS_SCHEMA)
    return parsed(SplitsFile, data, path)


def merged_splits(first: SplitsFile, second: SplitsFile) -> SplitsFile:
    """Return the record of the scenes of two data sets with the same seed and settings."""
    scenes = {name: tuple(sorted({*getattr(first, name), *getattr(second, name)})) for name in get_args(Split)}
    return first.model_copy(update=scenes)
