"""The output folder of a build: locked by one build at a time, prepared for its scenes, and finalized."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from ...core.atomic_io import atomic_file, remove_folder, remove_leftovers
from ...core.folder_lock import locked_folder
from ..format import layout
from ..format.dataset_file import DatasetFile, read_head, write_head
from ..format.pictures import write_png
from ..format.split_file import SplitsFile, write_splits
from ..format.views_table import scene_views
from ..output_checks import check_folder, check_same_head
from ..preview.gallery import gallery
from ..settings.scene_ranges import format_scenes, parse_scenes
from ..writer import finish_dataset


@contextmanager
def lock_output(root: Path, say: Callable[[str], None]) -> Iterator[None]:
    """Create a folder where it is absent, and lock it for one build.

    Raises
    ------
    InputError
        Where the folder cannot be created or written to, holds anything but a data set, or is locked by another build.
    """
    if root.exists():
        check_folder(root)
    with locked_folder(root, "build", say):
        yield


def prepare_output(root: Path, head: DatasetFile, scenes: Collection[int], overwrite: bool) -> DatasetFile:
    """Prepare a locked folder for scenes: check what it holds, delete scenes to be overwritten, write the head.

    Returns
    -------
    DatasetFile
        The head as written: it lists the scenes on disk as well.

    Raises
    ------
    InputError
        Where scenes that stay were made from something else (all differences are listed), or where a scene outside the
        request has no record, or another scene's.
    """
    path = root / layout.DATASET
    old = read_head(root) if path.exists() else None
    existing = set(layout.scene_ids(root))
    to_delete = existing & set(scenes) if overwrite else set()
    replaces_all = overwrite and existing == to_delete
    if old is not None and not replaces_all:
        check_same_head(path, old, head)
    for scene in sorted(existing.difference(scenes)):  # they stay, and the index will list them
        scene_views(root, scene)
    for folder in (root, root / layout.SCENES, root / layout.ASSETS):
        remove_leftovers(folder)
    for scene in sorted(to_delete):
        remove_folder(layout.scene_folder(root, scene))
    listed = [] if old is None or replaces_all else parse_scenes(old.scenes, str(path))
    whole = {*listed, *scenes, *layout.scene_ids(root)}
    head = head.model_copy(update={"scenes": format_scenes(whole), "assets": () if old is None else old.assets})
    if head != old:
        write_head(root, head)  # before the first scene: without it the folder is not recognised as a data set
    (root / layout.SCENES).mkdir(exist_ok=True)
    return head


def finalize_output(root: Path, splits: SplitsFile) -> int:
    """Write index, head, splits and gallery from the scenes on disk; return the number of views."""
    views = finish_dataset(root)
    write_splits(root, splits)
    sheet = gallery(root)
    if sheet is None:  # one of scenes that are gone would show what is not there
        (root / layout.PREVIEW).unlink(missing_ok=True)
    else:
        with atomic_file(root / layout.PREVIEW) as partial:
            write_png(partial, sheet)
    return views
