"""Merge data sets of one seed and one configuration, such as the shards of a build."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...core.atomic_io import atomic_folder, remove_leftovers
from ...core.errors import InputError
from ..format import layout
from ..format.checksums import read_checksums
from ..format.dataset_file import DatasetFile, read_head, write_head
from ..format.split_file import SplitsFile, merged_splits, read_splits
from ..format.views_table import scene_views
from ..output_checks import check_same_head
from ..settings.scene_ranges import format_scenes, parse_scenes
from .links import link_assets, link_tree
from .manifest import read_manifest, write_manifest
from .output_folder import finalize_output


def merge(sources: Sequence[Path], root: Path) -> int:
    """Merge the scenes of all sources into one data set; return the number of views.

    Files become hard links where both folders are on one file system, else copies; the sources do not change. Scenes
    that the target already has are kept, so a merge that was stopped can be repeated.

    Parameters
    ----------
    sources : sequence of Path
        Data sets.
    root : Path
        The target, locked (`output_folder.lock_output`): empty, or a data set of the same kind.

    Raises
    ------
    InputError
        Where sources differ in seed, settings, assets or versions, or have different files for the same scene.
    """
    heads = [read_head(source) for source in sources]
    target = [root] if (root / layout.DATASET).exists() else []
    for source, head in zip([*sources[1:], *target], [*heads[1:], *map(read_head, target)], strict=True):
        check_same_head(source / layout.DATASET, head, heads[0], f"what {sources[0]} was made from", f"in {sources[0]}")
    _check_scenes([*target, *sources])
    manifest, splits = read_manifest(sources[0]), _merged_splits(sources)
    head = _merged_head(heads + [read_head(folder) for folder in target])
    for folder in (root, root / layout.SCENES, root / layout.ASSETS):
        remove_leftovers(folder)
    write_head(root, head)
    (root / layout.SCENES).mkdir(exist_ok=True)
    if manifest is not None:
        write_manifest(root, manifest)
    for source in sources:
        _link_scenes(source, root)
    return finalize_output(root, splits)


def _check_scenes(folders: Sequence[Path]) -> None:
    """Raise InputError where two data sets have different files for a scene, or a folder holds another scene."""
    owner: dict[int, Path] = {}
    for folder in folders:
        for scene in layout.scene_ids(folder):
            scene_views(folder, scene)  # raises where the folder of another scene was renamed
            first = owner.setdefault(scene, folder)
            if first != folder and _sums(first, scene) != _sums(folder, scene):
                where = layout.scene_folder(folder, scene)
                raise InputError(where, f"the same bytes as in {first}", f"other bytes for the same scene {scene}")


def _sums(folder: Path, scene: int) -> object:
    return read_checksums(layout.scene_folder(folder, scene)).files


def _merged_splits(sources: Sequence[Path]) -> SplitsFile:
    records = [read_splits(source) for source in sources]
    whole = records[0]
    for record in records[1:]:
        whole = merged_splits(whole, record)
    return whole


def _merged_head(heads: Sequence[DatasetFile]) -> DatasetFile:
    scenes = {scene for head in heads for scene in parse_scenes(head.scenes, layout.DATASET)}
    return heads[0].model_copy(update={"scenes": format_scenes(scenes)})


def _link_scenes(source: Path, root: Path) -> None:
    link_assets(source, root)
    for scene in layout.scene_ids(source):
        place = layout.scene_folder(root, scene)
        if not place.exists():
            with atomic_folder(place) as partial:
                link_tree(layout.scene_folder(source, scene), partial)
    _append_log(source, root)


def _append_log(source: Path, root: Path) -> None:
    """Append the lines of a source's log that the target does not have yet: a merge may be repeated."""
    log = source / layout.LOG
    if not log.exists():
        return
    target = root / layout.LOG
    known = set(target.read_bytes().splitlines()) if target.exists() else set()
    with target.open("ab") as file:
        file.writelines(line + b"\n" for line in log.read_bytes().splitlines() if line not in known)
