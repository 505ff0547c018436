"""What a data set has besides its scenes, made from those that are there: index, head, splits, gallery."""

from __future__ import annotations

from pathlib import Path

from ...core.atomic_io import whole_file
from ..format import layout
from ..format.pictures import write_png
from ..format.split_file import SplitsFile, write_splits
from ..preview.gallery import gallery
from ..writer import finish_dataset


def finish(root: Path, splits: SplitsFile) -> int:
    """Write index, head, splits and gallery; return the number of views."""
    views = finish_dataset(root)
    write_splits(root, splits)
    sheet = gallery(root)
    if sheet is not None:
        with whole_file(root / layout.PREVIEW) as partial:
            write_png(partial, sheet)
    return views
