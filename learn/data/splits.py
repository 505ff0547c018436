"""Which scenes of a data set are for what."""

from __future__ import annotations

from typing import get_args

from ...core.errors import InputError
from ...dataset.reader import Dataset, StoredScene
from ...procedural.scene.splits import Split

#: Every scene, for data sets that have no splits.
ALL = "all"


def scenes_of(data: Dataset, split: str) -> tuple[StoredScene, ...]:
    """Return the scenes of a split (``train``, ``val``, ``test``, as the build made them) or all of them.

    Raises
    ------
    InputError
        Where the data set has no such split, or no scene of it.
    """
    if split == ALL:
        return data.scenes
    names = get_args(Split)
    if split not in names:
        raise InputError("split", f"one of {', '.join((*names, ALL))}", split)
    found = data.split(split)  # pyright: ignore[reportArgumentType]  # it is one of them
    numbers = [scene.scene_id for scene in found]
    if len(set(numbers)) < len(numbers):
        raise InputError(f"{data.root}: split {split}", "each scene once", numbers)
    if not found:
        raise InputError(f"{data.root}: split {split}", "scenes that are there", "none")
    return found
