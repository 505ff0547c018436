"""Files that a data set of twins has in common with the one that it is a twin of: each is stored once."""

from __future__ import annotations

import errno
import filecmp
import os
from pathlib import Path

from ...core.atomic_io import atomic_file
from ...core.errors import InputError
from ..format import layout
from ..format.checksums import read_checksums
from ..format.dataset_file import read_head


def check_original(original: Path, root: Path, seed: int, twin: str) -> None:
    """Raise InputError where a data set is none that twins of a seed can share files with."""
    where = "--twin-of"
    if twin == "none":
        raise InputError(where, "it with --twin opaque, empty, clean-plate, light or media", "no --twin")
    if original.absolute() == root.absolute():
        raise InputError(where, "another folder than --out", str(original))
    found = read_head(original).seed
    if found != seed:
        raise InputError(where, f"a data set of seed {seed}", f"{original}, of seed {found}")


def share_equal_files(root: Path, original: Path) -> tuple[int, int]:
    """Replace files of scenes that are equal in another data set by hard links to those; return how many, and bytes.

    What is equal is found by the digests in ``checksums.json`` and then by content, so nothing that a reader sees
    changes. Files that are links already count as well. Readers of both are not disturbed: every link takes a file's
    place at once.

    Parameters
    ----------
    root : Path
        The data set whose files become links.
    original : Path
        The data set that keeps its files.

    Raises
    ------
    InputError
        Where the two are on different file systems, or the file system has no links.
    """
    count = size = 0
    for scene in sorted(set(layout.scene_ids(root)) & set(layout.scene_ids(original))):
        here, there = (layout.scene_folder(folder, scene) for folder in (root, original))
        ours, theirs = (read_checksums(folder).files for folder in (here, there))
        for name in sorted(name for name in ours if ours[name] == theirs.get(name)):
            if _same_file(there / name, here / name):
                count, size = count + 1, size + ours[name].size
    return count, size


def _same_file(source: Path, target: Path) -> bool:
    """Make a file a link to another one where both have the same content; return whether it is one."""
    if source.samefile(target):
        return True
    if not filecmp.cmp(source, target, shallow=False):  # one was changed since: `verify` says which
        return False
    try:
        with atomic_file(target) as partial:
            os.link(source, partial)
    except OSError as error:
        if error.errno not in (errno.EXDEV, errno.EPERM, errno.ENOTSUP, errno.EMLINK):
            raise
        where, expected = "--twin-of", "a data set on the same file system, which has hard links"
        raise InputError(where, expected, f"{source}: {os.strerror(error.errno)}") from error
    return True
