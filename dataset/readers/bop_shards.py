"""Data sets in BOP's web format: shards of images in tar files.

::

    shard-000000.tar        000001_000000.rgb.jpg  .depth.png  .camera.json  .gt.json  .gt_info.json  .mask_visib.json
    key_to_shard.json

A key is the scene's and the image's number. Masks are COCO's uncompressed run lengths, by the number of the object.
(bop_toolkit, docs/bop_datasets_format.md.) Models are looked for beside the shards.
"""

from __future__ import annotations

import json
import re
import tarfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...core.errors import InputError, cause_of
from .bop import LICENCE, NOTES, RENDERED, split_of
from .bop_records import BopImage, BopModel, bop_view, places, read_models
from .bop_scenes import scene_names
from .layout import Layout, names_in
from .picture_files import colour_of, levels_of
from .source_view import Collection, Entry, LeftOut, SourceView

_SHARD = re.compile(r"shard-\d{6}\.tar")
_PICTURES = ("rgb.jpg", "rgb.png", "gray.tiff", "gray.png")
#: Largest member that is read [bytes]: a depth map of 100 megapixels.
_LARGEST = 200_000_000


class _Place(NamedTuple):
    """Where a member's bytes are in its shard."""

    shard: Path
    offset: int
    size: int


def _is_unit(names: frozenset[str]) -> bool:
    return any(_SHARD.fullmatch(name) for name in names)


def _open(root: Path, units: Sequence[Path]) -> Collection:
    entries: list[Entry] = []
    left_out: list[LeftOut] = []
    found_models = True
    for unit in units:
        models = read_models((unit, unit.parent, root))
        found_models = found_models and bool(models)
        images: dict[str, dict[str, _Place]] = {}
        for name in sorted(filter(_SHARD.fullmatch, names_in(unit))):
            for key, kind, place in _members(unit / name):
                images.setdefault(key, {})[kind] = place
        more, less = _entries(unit, images, models)
        entries += more
        left_out += less
    missing = () if found_models else ("no models_info.json: sizes and symmetries of objects are unknown",)
    return Collection(tuple(entries), tuple(left_out), notes=(*NOTES, *missing))


LAYOUT = Layout(
    name="bop-webdataset",
    title="BOP webdataset",
    licence=LICENCE,
    is_unit=_is_unit,
    expected="shard-000000.tar with KEY.camera.json and KEY.rgb.jpg",
    open=_open,
)


def _members(shard: Path) -> list[tuple[str, str, _Place]]:
    """Return key, kind and place of each member of a shard."""
    try:
        with tarfile.open(shard, "r:") as file:
            members = [(m.name, m.offset_data, m.size) for m in file if m.isreg()]
    except (tarfile.TarError, EOFError) as error:
        raise InputError(shard, "a whole tar file without compression", str(error) or "a part of one") from error
    except OSError as error:
        raise InputError(shard, "a readable file", cause_of(error)) from error
    whole = shard.stat().st_size
    found = []
    for name, offset, size in members:
        key, _, kind = name.rpartition("/")[2].partition(".")
        if offset + size > whole:
            raise InputError(shard, f"a whole tar file with {name}", "a part of one")
        found.append((key, kind, _Place(shard, offset, size)))
    return found


def _entries(
    unit: Path, images: Mapping[str, dict[str, _Place]], models: dict[int, BopModel]
) -> tuple[list[Entry], list[LeftOut]]:
    entries, left_out, usable = [], [], []
    for key in sorted(images):
        missing = [] if any(kind in images[key] for kind in _PICTURES) else ["rgb or gray picture"]
        missing += [] if "camera.json" in images[key] else ["camera.json"]
        if missing or not re.fullmatch(r"\d+_\d+", key):
            why = f"expected {' and '.join(missing)}, found none" if missing else "expected a key SCENE_IMAGE"
            left_out.append(LeftOut(f"{unit.name}/{key}", why))
        else:
            usable.append(key)
    for folder in dict.fromkeys(key.partition("_")[0] for key in usable):
        keys = [key for key in usable if key.partition("_")[0] == folder]
        at = [_places(images[key], f"{unit}: {key}") for key in keys]
        names = scene_names(f"{unit.name}/{folder}", [int(key.partition("_")[2]) for key in keys], at)
        for key, scene in zip(keys, names, strict=True):
            read = _reader(unit, key, images[key], models)
            entries.append(Entry(f"{unit.name}/{key}", scene, read, split_of(unit.name)))
    return entries, left_out


def _places(kinds: Mapping[str, _Place], where: str) -> np.ndarray | None:
    gt = _record(kinds, "gt.json", where)
    return places(_record(kinds, "camera.json", where), gt, where)


def _reader(unit: Path, key: str, kinds: Mapping[str, _Place], models: dict[int, BopModel]) -> Callable[[], SourceView]:
    def read() -> SourceView:
        where = f"{unit}: {key}"
        picture = next(kind for kind in _PICTURES if kind in kinds)
        gt = _record(kinds, "gt.json", where)
        masks = _record(kinds, "mask_visib.json", where)
        image = BopImage(
            camera=_record(kinds, "camera.json", where),
            gt=gt,
            info=_record(kinds, "gt_info.json", where),
            picture=colour_of(_bytes(kinds[picture]), f"{where}.{picture}"),
            depth=levels_of(_bytes(kinds["depth.png"]), f"{where}.depth.png") if "depth.png" in kinds else None,
            masks=None if masks is None else {int(n): _run_lengths(m, where) for n, m in masks.items()},
            depth_is_true=any(word in unit.name for word in RENDERED),
        )
        return bop_view(image, models, where)

    return read


def _record(kinds: Mapping[str, _Place], kind: str, where: str) -> Any:
    """Return a JSON member; None where there is none."""
    if kind not in kinds:
        return None
    try:
        return json.loads(_bytes(kinds[kind]))
    except ValueError as error:
        raise InputError(f"{where}.{kind}", "JSON", str(error)) from error


def _bytes(place: _Place) -> bytes:
    if place.size > _LARGEST:
        raise InputError(place.shard, f"members of at most {_LARGEST} bytes", place.size)
    try:
        with place.shard.open("rb") as file:
            file.seek(place.offset)
            return file.read(place.size)
    except OSError as error:
        raise InputError(place.shard, "a readable file", cause_of(error)) from error


def _run_lengths(code: Any, where: str) -> np.ndarray:
    """Return a mask of COCO's uncompressed run lengths, column by column, zeros first, (H, W) bool."""
    try:
        height, width = (int(side) for side in code["size"])
        counts = np.array(code["counts"], np.int64)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{where}.mask_visib.json", "size and counts of run lengths", "something else") from error
    if counts.ndim != 1 or (counts < 0).any() or int(counts.sum()) != height * width:
        raise InputError(f"{where}.mask_visib.json", f"run lengths of {height * width} pixels", int(counts.sum()))
    return np.repeat(np.arange(len(counts)) % 2 == 1, counts).reshape(width, height).T
