"""The table of data sets: what is in the files of those that are given, beside what authors say of theirs."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from ...dataset.format import layout
from ...dataset.format.conversion import Conversion
from ...dataset.reader import Dataset, StoredView
from .cells import Cell, TableData
from .published import DATASETS

#: Annotations, and the files of a view that hold them.
_FILES = {
    "right pictures": "right.png",
    "depth, normals": layout.GEOMETRY,
    "instances": layout.INSTANCES,
    "masks, boxes, poses, keypoints": layout.LABELS,
    "surfaces behind": layout.LAYERS,
    "refraction": layout.REFRACTION,
}
_HEADS = ("data set", "samples", "objects", "scenes", "annotations", "source")


def comparison_table(folders: tuple[Path, ...]) -> TableData:
    """Return the table of data sets: the given ones, counted from their files, then the published ones.

    Raises
    ------
    InputError
        Where a folder is no data set.
    """
    rows = [_counted(folder) for folder in folders]
    rows += [
        tuple(map(Cell, (one.name, one.samples, one.objects, one.scenes, one.annotations, one.source)))
        for one in DATASETS
    ]
    notes = (
        "Objects of data sets that are given: instances over all scenes; every vessel of ours is drawn for its scene.",
        "Annotations of data sets that are given: files that every view has; of converted ones, labels that every view "
        "has, and their categories as objects.",
    )
    return TableData("Data sets", _HEADS, tuple(rows), notes)


def _counted(folder: Path) -> tuple[Cell, ...]:
    data = Dataset.open(folder)
    if data.head.converted is not None:
        return _converted(data, data.head.converted)
    kinds: Counter[str] = Counter()
    files: Counter[str] = Counter()
    views = 0
    for scene in data.scenes:
        kinds.update("transparent" if one.material.kind == "glass" else "opaque" for one in scene.objects().objects)
        for view in scene.views:
            views += 1
            files.update(_present(view))
    common = ", ".join(name for name in _FILES if files[name] == views and views)
    objects = ", ".join(f"{kinds[kind]:,} {kind}" for kind in ("transparent", "opaque"))
    values = (data.head.name, f"{views:,}", objects, f"{len(data.scenes):,}", common, f"files of {folder.name}")
    return tuple(map(Cell, values))


def _converted(data: Dataset, record: Conversion) -> tuple[Cell, ...]:
    """Return the row of another project's data set that was converted: what every one of its views has."""
    categories = {
        item.category for scene in data.scenes for view in scene.views for item in view.partial_labels().objects or ()
    }
    common = ", ".join(kind for kind, count in record.has.items() if count == record.views)
    source = f"files of {record.folder}"
    values = (record.title, f"{record.views:,}", f"{len(categories):,}", f"{len(data.scenes):,}", common, source)
    return tuple(map(Cell, values))


def _present(view: StoredView) -> list[str]:
    return [name for name, file in _FILES.items() if (view.folder / file).is_file()]
