"""Trans10K: photographs with classes of pixels, without cameras.

::

    train/images/1.jpg  train/masks/1_mask.png                      version 1; validation and test split easy, hard
    train/images/1.jpg  train/masks_12/1_mask.png                   version 2 (Trans10K_cls12)

Version 1 has three grey levels, and colours in some files: 0 background, 85 (the mean of pure red) things, 255 stuff.
Version 2 has palette indices, which a conversion to colours loses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ...core.errors import InputError
from .layout import Layout, names_in
from .picture_files import read_bytes, read_colour, read_indices
from .source_view import Collection, Entry, LeftOut, SourceView, check_view

CLASSES_1 = ("background", "things", "stuff")
#: By the indices of the released palette (xieenze/Trans2Seg). Other projects number the same classes otherwise.
CLASSES_2 = (
    "background",
    "shelf",
    "jar or tank",
    "freezer",
    "window",
    "glass door",
    "eyeglass",
    "cup",
    "floor glass",
    "glass bowl",
    "water bottle",
    "storage box",
)
#: Mean over red, green and blue of version 1's classes, and how far a pixel may be from it: its masks were resized.
_LEVELS, _LEVEL_ERROR = (0, 85, 255), 42
_MASKS = ("masks_12", "masks")
_PICTURES = (".jpg", ".jpeg", ".png")


def _is_unit(names: frozenset[str]) -> bool:
    return "images" in names and bool(names & set(_MASKS))


def _open(root: Path, units: Sequence[Path]) -> Collection:
    kinds = {kind for unit in units for kind in _MASKS if kind in names_in(unit)}
    if len(kinds) > 1:
        raise InputError(root, "one version of Trans10K", "masks and masks_12: both versions")
    masks = kinds.pop()
    entries: list[Entry] = []
    left_out: list[LeftOut] = []
    for unit in units:
        have = names_in(unit / masks)
        base = unit.relative_to(root).as_posix()
        for picture in sorted(names_in(unit / "images")):
            stem, dot, end = picture.rpartition(".")
            if dot + end.lower() not in _PICTURES:
                continue
            name = f"{base}/{stem}" if base != "." else f"{unit.name}/{stem}"
            mask = next((file for file in (f"{stem}_mask.png", f"{stem}.png") if file in have), None)
            if mask is None:
                left_out.append(LeftOut(name, f"expected {masks}/{stem}_mask.png, found none"))
            else:
                read = _reader(unit / "images" / picture, unit / masks / mask, masks == "masks_12")
                entries.append(Entry(name, name, read, _split(unit, root)))
    notes = (
        "photographs without cameras: there are no depths, poses or boxes",
        "other projects give the twelve classes other numbers; these are those of the data set's own palette",
    )
    return Collection(tuple(entries), tuple(left_out), CLASSES_2 if masks == "masks_12" else CLASSES_1, notes)


LAYOUT = Layout(
    name="trans10k",
    title="Trans10K",
    licence="unknown (its authors ask to be asked about commercial use)",
    is_unit=_is_unit,
    expected="images/NAME.jpg with masks/NAME_mask.png or masks_12/NAME_mask.png",
    open=_open,
)


def _split(unit: Path, root: Path) -> str | None:
    words = {"train": "train", "validation": "val", "val": "val", "test": "test"}
    names = [root.name, *unit.relative_to(root).parts]
    return next((words[name] for name in names if name in words), None)


def _reader(picture: Path, mask: Path, indexed: bool) -> Callable[[], SourceView]:
    def read() -> SourceView:
        classes = read_indices(mask, len(CLASSES_2)) if indexed else _by_level(mask)
        if indexed and int(classes.max(initial=0)) >= len(CLASSES_2):
            raise InputError(mask, f"classes 0 to {len(CLASSES_2) - 1}", int(classes.max()))
        return check_view(SourceView(picture=read_colour(picture), classes=classes), mask)

    return read


def _by_level(path: Path) -> np.ndarray:
    read_bytes(path)
    level = read_colour(path).astype(np.int32).mean(axis=-1)
    away = np.stack([np.abs(level - value) for value in _LEVELS])
    if away.min(axis=0).max() > _LEVEL_ERROR * 2:
        raise InputError(path, f"grey levels near {', '.join(map(str, _LEVELS))}", f"{level.max():g}")
    return away.argmin(axis=0).astype(np.uint16)
