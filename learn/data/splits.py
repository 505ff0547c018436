"""The scenes of a split of a data set."""

from __future__ import annotations

from typing import Literal, get_args

from ...core.errors import InputError
from ...dataset.format import layout
from ...dataset.reader import Dataset, StoredScene
from ...procedural.scene.splits import Split

#: ``all``: every scene, for data sets without splits.
SplitName = Split | Literal["all"]
_NAMES = (*get_args(Split), "all")


def scenes_of(data: Dataset, split: SplitName) -> tuple[StoredScene, ...]:
    """Return the scenes of a split, as the build made it, or all scenes.

    Raises
    ------
    InputError
        Where the data set has no such split, or no scene of it.
    """
    if split not in _NAMES:
        raise InputError("split", f"one of {', '.join(_NAMES)}", split)
    if split == "all":
        return data.scenes
    every = "--train-split all takes every scene, with --val-split none; of evaluate, --split all"
    if not (data.root / layout.SPLITS).is_file():
        raise InputError(data.root, f"a data set that is split, as build-dataset writes it ({every})", "none")
    found = data.split(split)
    numbers = [scene.scene_id for scene in found]
    if len(set(numbers)) < len(numbers):
        raise InputError(f"{data.root}: split {split}", "each scene once", numbers)
    if not found:
        raise InputError(f"{data.root}: split {split}", "scenes that exist", f"none of {len(data.scenes)} ({every})")
    return found
