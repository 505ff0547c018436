"""The folder of a build: taken by one build at a time, refused where it holds something else or other settings."""

from __future__ import annotations

import errno
import fcntl
import os
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from ...core.atomic_io import discard, remove_leftovers
from ...core.errors import InputError
from ...core.setting_errors import shortened
from ..format import layout
from ..format.dataset_file import DatasetFile
from ..format.views_table import scene_views
from ..settings.scene_ranges import format_scenes, parse_scenes
from ..writer import check_folder, differences, read_head, write_head

#: What a file system says that has no locks.
_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.EINVAL, errno.ENOSYS)
#: What one can do about scenes that were made from something else.
_WAY_OUT = "what is asked for, or --overwrite of all its scenes, or another --out"
#: Most differences that are told of in one line.
_MOST_TOLD = 6


@contextmanager
def taken(root: Path, say: Callable[[str], None]) -> Iterator[None]:
    """Hold a folder, made where it is absent, for one build. The system lets go of it when the process dies.

    Raises
    ------
    InputError
        Where it cannot be made or written to, holds anything but a data set, or another build works there.
    """
    new = not root.exists()
    if not new:
        check_folder(root)
    try:
        root.mkdir(parents=True, exist_ok=True)
        handle = _locked(root / layout.LOCK, root, say)
    except OSError as error:
        raise InputError(root, "a folder that can be made and written to", error.strerror) from error
    try:
        yield
    finally:
        (root / layout.LOCK).unlink(missing_ok=True)
        os.close(handle)
        if new and not any(root.iterdir()):  # what was asked for could not be begun
            root.rmdir()


def _locked(path: Path, root: Path, say: Callable[[str], None]) -> int:
    while True:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in _NO_LOCKS:
                say(f"{root}: this file system has no locks; see to it that no other build writes here")
                return handle
            os.close(handle)
            if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
                raise InputError(root, "a folder that no other build works in", "a build that runs") from error
            raise
        # The one before may have removed the file between our opening and locking it.
        if path.exists() and path.stat().st_ino == os.fstat(handle).st_ino:
            return handle
        os.close(handle)


def opened(root: Path, head: DatasetFile, scenes: Collection[int], overwrite: bool) -> DatasetFile:
    """Make a held folder ready for scenes, and return the head that it has now.

    A data set that is there grows. Its scenes stay, but those to be overwritten, which are removed.

    Raises
    ------
    InputError
        Where scenes that stay were made from something else: all that differs is told. Where a scene that was not
        asked for has no record, or another scene's.
    """
    path = root / layout.DATASET
    kept = read_head(root) if path.exists() else None
    there = set(layout.scene_ids(root))
    doomed = there & set(scenes) if overwrite else set()
    if kept is not None and not (overwrite and there == doomed):
        check_same(path, kept, head, _WAY_OUT)
    for scene in sorted(there.difference(scenes)):  # they stay, and are in the index in the end
        scene_views(root, scene)
    for folder in (root, root / layout.SCENES, root / layout.ASSETS):
        remove_leftovers(folder)
    for scene in sorted(doomed):
        discard(layout.scene_folder(root, scene))
    before = parse_scenes(kept.scenes, str(path)) if kept is not None and not (overwrite and there == doomed) else []
    whole = {*before, *scenes, *layout.scene_ids(root)}
    head = head.model_copy(update={"scenes": format_scenes(whole), "assets": () if kept is None else kept.assets})
    if head != kept:
        write_head(root, head)  # before the first folder: without it the data set is nobody's
    (root / layout.SCENES).mkdir(exist_ok=True)
    return head


def check_request(root: Path, seed: int, config: dict) -> None:
    """Raise InputError where a folder's data set has another seed or other settings, before any worker is started."""
    path = root / layout.DATASET
    if path.exists():
        kept = read_head(root)
        check_same(path, kept, kept.model_copy(update={"seed": seed, "config": config}), _WAY_OUT)


def check_same(where: Path, kept: DatasetFile, head: DatasetFile, expected: str, other: str = "asked") -> None:
    """Raise InputError that shows in what a data set's head differs from another, which is called `other`."""
    told = [f"{name} {shortened(found)} ({other}: {shortened(wanted)})" for name, wanted, found in _changes(kept, head)]
    if told:
        rest = f" and {len(told) - _MOST_TOLD} more" if len(told) > _MOST_TOLD else ""
        raise InputError(where, expected, ", ".join(told[:_MOST_TOLD]) + rest)


def _changes(kept: DatasetFile, head: DatasetFile) -> Iterator[tuple[str, object, object]]:
    for field in ("name", "seed", "config", "backend", "versions"):
        asked, found = getattr(head, field), getattr(kept, field)
        yield from differences(asked, found, "" if field == "config" else field)
    if "assets" in kept.hashes and kept.hashes.get("assets") != head.hashes.get("assets"):
        yield "hash of the assets", head.hashes.get("assets"), kept.hashes["assets"]
