"""Data sets of one seed and one configuration become one: the scenes of shards, scene by scene, whole or absent."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Sequence
from pathlib import Path

from ...core.atomic_io import remove_leftovers, whole_file, whole_folder
from ...core.errors import InputError
from ..format import layout
from ..format.checksums import read_checksums
from ..format.dataset_file import DatasetFile
from ..format.split_file import SplitsFile, joined, read_splits
from ..format.views_table import scene_views
from ..settings.scene_ranges import format_scenes, parse_scenes
from ..writer import read_head, write_head
from .finalize import finish
from .manifest import read_manifest, write_manifest
from .output_folder import check_same


def merge(sources: Sequence[Path], root: Path) -> int:
    """Put the scenes of all sources into one data set; return the number of views.

    Files become hard links where both lie on one file system, else copies; sources stay as they are. A scene that is
    there already stays, so a merge that was stopped goes on.

    Parameters
    ----------
    sources : sequence of Path
        Data sets.
    root : Path
        Where to: a folder held for this (`folder.taken`), empty or with a data set of the same kind.

    Raises
    ------
    InputError
        Where sources differ in seed, settings, assets or versions, or have the same scene with other bytes.
    """
    heads = [read_head(source) for source in sources]
    there = [root] if (root / layout.DATASET).exists() else []
    for source, head in zip([*sources[1:], *there], [*heads[1:], *map(read_head, there)], strict=True):
        check_same(source / layout.DATASET, head, heads[0], f"what {sources[0]} was made from", f"in {sources[0]}")
    _check_scenes([*there, *sources])
    manifest, splits = read_manifest(sources[0]), _splits(sources)
    head = _whole_head(heads + [read_head(folder) for folder in there])
    for folder in (root, root / layout.SCENES, root / layout.ASSETS):
        remove_leftovers(folder)
    write_head(root, head)
    (root / layout.SCENES).mkdir(exist_ok=True)
    if manifest is not None:
        write_manifest(root, manifest)
    for source in sources:
        _take(source, root)
    return finish(root, splits)


def _check_scenes(folders: Sequence[Path]) -> None:
    """Raise InputError where a scene is in two data sets with other bytes, or a folder holds another scene."""
    owner: dict[int, Path] = {}
    for folder in folders:
        for scene in layout.scene_ids(folder):
            scene_views(folder, scene)  # of that scene, and not of another whose folder was renamed
            first = owner.setdefault(scene, folder)
            if first != folder and _sums(first, scene) != _sums(folder, scene):
                where = layout.scene_folder(folder, scene)
                raise InputError(where, f"the same bytes as in {first}", f"others of the same scene {scene}")


def _sums(folder: Path, scene: int) -> object:
    return read_checksums(layout.scene_folder(folder, scene)).files


def _splits(sources: Sequence[Path]) -> SplitsFile:
    records = [read_splits(source) for source in sources]
    whole = records[0]
    for record in records[1:]:
        whole = joined(whole, record)
    return whole


def _whole_head(heads: Sequence[DatasetFile]) -> DatasetFile:
    scenes = {scene for head in heads for scene in parse_scenes(head.scenes, layout.DATASET)}
    return heads[0].model_copy(update={"scenes": format_scenes(scenes)})


def _take(source: Path, root: Path) -> None:
    for path in sorted((source / layout.ASSETS).glob("*")) if (source / layout.ASSETS).is_dir() else ():
        (root / layout.ASSETS).mkdir(exist_ok=True)
        if not (root / layout.ASSETS / path.name).exists():
            with whole_file(root / layout.ASSETS / path.name) as partial:
                _linked(path, partial)
    for scene in layout.scene_ids(source):
        place = layout.scene_folder(root, scene)
        if not place.exists():
            with whole_folder(place) as partial:
                _copied(layout.scene_folder(source, scene), partial)
    _add_log(source, root)


def _copied(source: Path, folder: Path) -> None:
    for parent, _, names in os.walk(source):
        here = folder / Path(parent).relative_to(source)
        here.mkdir(exist_ok=True)
        for name in names:
            _linked(Path(parent, name), here / name)


def _linked(source: Path, target: Path) -> None:
    try:
        os.link(source, target)
    except OSError as error:
        if error.errno not in (errno.EXDEV, errno.EPERM, errno.ENOTSUP, errno.EMLINK):
            raise
        shutil.copyfile(source, target)  # another file system, or one without links


def _add_log(source: Path, root: Path) -> None:
    """Add the lines of a source's log that are not there yet: a merge may be repeated."""
    log = source / layout.LOG
    if not log.exists():
        return
    target = root / layout.LOG
    known = set(target.read_bytes().splitlines()) if target.exists() else set()
    with target.open("ab") as file:
        file.writelines(line + b"\n" for line in log.read_bytes().splitlines() if line not in known)
