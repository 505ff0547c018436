"""Which scenes of a data set are for what."""

from __future__ import annotations

from ...dataset.reader import Dataset, StoredScene
from ...procedural.errors import InputError
from ...procedural.scene_file import check_schema, read_json

SPLITS, SPLITS_SCHEMA = "splits.json", "glassware/splits/1"
#: Every scene, for data sets that have no splits.
ALL = "all"


def scenes_of(data: Dataset, split: str) -> tuple[StoredScene, ...]:
    """Return the scenes of a split (``train``, ``val``, ``test``, as ``splits.json`` has them) or all of them.

    Raises
    ------
    InputError
        Where the data set has no such split, or no scene of it.
    """
    if split == ALL:
        return data.scenes
    path = data.root / SPLITS
    if not path.is_file():
        raise InputError(path, f"the scenes of split {split} (or ask for split {ALL})", "no such file")
    record = read_json(path)
    check_schema(path, record, SPLITS_SCHEMA)
    numbers = record.get(split)
    if not isinstance(numbers, list) or not all(isinstance(number, int) for number in numbers):
        raise InputError(f"{path}: {split}", "the numbers of its scenes", numbers)
    there = {scene.scene_id: scene for scene in data.scenes}
    found = tuple(there[number] for number in numbers if number in there)
    if not found:
        raise InputError(f"{path}: {split}", "scenes that are there", "none")
    return found
