"""Data sets in BOP's layout of one folder for each scene.

::

    models/models_info.json
    test/000001/
        scene_camera.json  scene_gt.json  scene_gt_info.json
        rgb/000000.png (or gray/, .jpg, .tif)  depth/000000.png  mask_visib/000000_000000.png

Sets with several cameras have a suffix on all of these: ``scene_camera_realsense.json``, ``rgb_realsense``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...core.errors import InputError
from ...core.json_file import read_json
from .bop_records import BopImage, BopModel, bop_view, places, read_models
from .bop_scenes import scene_names
from .layout import Layout, names_in
from .picture_files import read_colour, read_levels
from .source_view import Collection, Entry, LeftOut, SourceView

_CAMERA = re.compile(r"scene_camera(?P<suffix>(?:_\w+)?)\.json")
#: Folders of pictures, and ends of their files, in the order in which they are looked for.
_PICTURES, _ENDS = ("rgb", "gray"), (".png", ".jpg", ".jpeg", ".tif", ".tiff")
#: Words in the name of a split whose depth was rendered.
RENDERED = ("pbr", "synt", "render")
#: What a reader of the labels should know.
NOTES = (
    "which objects are transparent is not stated (--transparent)",
    "depth of rendered splits (pbr) is true, that of the others a sensor's",
)
LICENCE = "unknown (each BOP data set has its own)"


def _is_unit(names: frozenset[str]) -> bool:
    return any(_CAMERA.fullmatch(name) for name in names)


def _open(root: Path, units: Sequence[Path]) -> Collection:
    entries: list[Entry] = []
    left_out: list[LeftOut] = []
    models: dict[Path, dict[int, BopModel]] = {}
    for unit in units:
        base = unit.parent.parent
        if base not in models:
            models[base] = read_models((base, root, unit.parent))
        for match in filter(None, map(_CAMERA.fullmatch, sorted(names_in(unit)))):
            more, less = _scene(unit, match["suffix"], models[base])
            entries += more
            left_out += less
    missing = () if all(models.values()) else ("no models_info.json: sizes and symmetries of objects are unknown",)
    return Collection(tuple(entries), tuple(left_out), notes=(*NOTES, *missing))


LAYOUT = Layout(
    name="bop",
    title="BOP",
    licence=LICENCE,
    is_unit=_is_unit,
    expected="scene_camera.json with rgb/ or gray/",
    open=_open,
)


def split_of(name: str) -> str | None:
    """Return the split that a folder's name such as ``train_pbr`` means."""
    return next((split for split in ("train", "val", "test") if name.startswith(split)), None)


def _scene(unit: Path, suffix: str, models: dict[int, BopModel]) -> tuple[list[Entry], list[LeftOut]]:
    path = unit / f"scene_camera{suffix}.json"
    cameras = by_number(read_json(path), path)
    gt, info = (_optional(unit / f"scene_gt{kind}{suffix}.json") for kind in ("", "_info"))
    have = {kind: names_in(unit / f"{kind}{suffix}") for kind in (*_PICTURES, "depth", "mask_visib")}
    base = f"{unit.parent.name}/{unit.name}{suffix}"
    numbers = sorted(cameras)
    at = [places(cameras[n], None if gt is None else gt.get(n), f"{path}: {n}") for n in numbers]
    entries, left_out = [], []
    for number, scene in zip(numbers, scene_names(base, numbers, at), strict=True):
        picture = _picture(unit, suffix, number, have)
        if picture is None:
            expected = f"rgb{suffix}/{number:06d} or gray{suffix}/{number:06d}"
            left_out.append(LeftOut(f"{base}/{number:06d}", f"expected a picture {expected}, found none"))
            continue
        records = (cameras[number], None if gt is None else gt.get(number), None if info is None else info.get(number))
        read = _reader(unit, suffix, number, picture, records, models, have)
        entries.append(Entry(f"{base}/{number:06d}", scene, read, split_of(unit.parent.name)))
    return entries, left_out


def by_number(data: Any, path: Path) -> dict[int, Any]:
    """Return a mapping of JSON data by the numbers of images; InputError where it is none."""
    if not isinstance(data, dict) or not all(key.isdigit() for key in data):
        raise InputError(path, "records by the numbers of images", "something else")
    return {int(key): value for key, value in data.items()}


def _optional(path: Path) -> dict[int, Any] | None:
    return by_number(read_json(path), path) if path.is_file() else None


def _picture(unit: Path, suffix: str, number: int, have: dict[str, frozenset[str]]) -> Path | None:
    for kind in _PICTURES:
        for end in _ENDS:
            if f"{number:06d}{end}" in have[kind]:
                return unit / f"{kind}{suffix}" / f"{number:06d}{end}"
    return None


def _reader(
    unit: Path,
    suffix: str,
    number: int,
    picture: Path,
    records: tuple[Any, Any, Any],
    models: dict[int, BopModel],
    have: dict[str, frozenset[str]],
) -> Callable[[], SourceView]:
    def read() -> SourceView:
        camera, gt, info = records
        depth = f"{number:06d}.png"
        image = BopImage(
            camera=camera,
            gt=gt,
            info=info,
            picture=read_colour(picture),
            depth=read_levels(unit / f"depth{suffix}" / depth) if depth in have["depth"] else None,
            masks=_masks(unit / f"mask_visib{suffix}", number, len(gt or ()), have["mask_visib"]),
            depth_is_true=any(word in unit.parent.name for word in RENDERED),
        )
        return bop_view(image, models, unit / f"{number:06d}{suffix}")

    return read


def _masks(folder: Path, number: int, count: int, have: frozenset[str]) -> dict[int, np.ndarray] | None:
    names = [f"{number:06d}_{index:06d}.png" for index in range(count)]
    if not count or any(name not in have for name in names):
        return None
    return {index: read_levels(folder / name) > 0 for index, name in enumerate(names)}
