"""Atomic writing: files and folders that appear complete or not at all, and survive a power cut."""

from __future__ import annotations

import errno
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

#: Errors of a link to another file system, or on one without links.
_NO_LINKS = (errno.EXDEV, errno.EPERM, errno.ENOTSUP, errno.EMLINK)
_PARTIAL = re.compile(r"\.(?P<name>.+)\.(?P<kind>partial|old)-(?P<process>[0-9]+)")


def write_atomically(path: Path, data: bytes) -> None:
    """Write a file under a temporary name, sync it, and rename it."""
    with atomic_file(path) as partial:
        partial.write_bytes(data)


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yield the name of a hidden file to write; rename it to ``path`` at the end, or delete it on any exception."""
    partial = _hidden(path, "partial")
    try:
        yield partial
        _sync(partial)
        partial.replace(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
    _sync(path.parent)


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """Yield a hidden folder to fill; rename it to ``path`` at the end, or delete it on any exception.

    An existing folder at ``path`` is moved aside just before and deleted just after. Where the process is killed
    between the two renames, `remove_leftovers` restores it.
    """
    partial, old = _hidden(path, "partial"), _hidden(path, "old")
    try:
        partial.mkdir(parents=True)
        yield partial
        _sync_tree(partial)
        if path.exists():
            path.rename(old)
        partial.rename(path)
    except BaseException:
        # Ctrl-C as well: nothing incomplete may stay.
        if old.exists() and not path.exists():
            old.rename(path)
        shutil.rmtree(partial, ignore_errors=True)
        raise
    _sync(path.parent)
    shutil.rmtree(old, ignore_errors=True)


def link_or_copy(source: Path, target: Path) -> None:
    """Make a file appear under a second name: a hard link, or a copy where the file system has none."""
    try:
        os.link(source, target)
    except OSError as error:
        if error.errno not in _NO_LINKS:
            raise
        shutil.copyfile(source, target)


def remove_folder(folder: Path) -> None:
    """Delete a folder; for readers it disappears in one step. A process killed meanwhile leaves a hidden leftover."""
    hidden = _hidden(folder, "partial")
    folder.rename(hidden)
    shutil.rmtree(hidden)


def remove_leftovers(folder: Path) -> None:
    """Delete the incomplete files and folders of killed processes, and restore what they had moved aside.

    Those of other processes that are alive are left alone.
    """
    for entry in sorted(folder.iterdir()) if folder.is_dir() else []:
        match = _PARTIAL.fullmatch(entry.name)
        if not match or _is_another_alive(int(match["process"])):
            continue
        place = folder / match["name"]
        if match["kind"] == "old" and not place.exists():
            entry.rename(place)
        elif entry.is_dir() and not entry.is_symlink():
            shutil.rmtree(entry)
        else:
            entry.unlink()


def is_written_by_another(folder: Path) -> bool:
    """Return whether another process that is alive is writing into a folder."""
    matches = [_PARTIAL.fullmatch(entry.name) for entry in folder.iterdir()] if folder.is_dir() else []
    return any(_is_another_alive(int(match["process"])) for match in matches if match)


def is_leftover(name: str) -> bool:
    """Return whether a name is one of the hidden names that this module uses."""
    return _PARTIAL.fullmatch(name) is not None


def _hidden(path: Path, kind: str) -> Path:
    return path.with_name(f".{path.name}.{kind}-{os.getpid()}")


def _is_another_alive(process: int) -> bool:
    if process == os.getpid():
        return False
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):  # OverflowError: beyond the system's range of process numbers
        return False
    except PermissionError:
        return True
    return True


def _sync_tree(folder: Path) -> None:
    for parent, _, files in os.walk(folder):
        for name in files:
            _sync(Path(parent, name))
        _sync(Path(parent))


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
