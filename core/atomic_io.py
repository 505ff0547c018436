"""Atomic writes: files and folders appear complete or not at all, and survive a power cut."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_PARTIAL = re.compile(r"\.(?P<name>.+)\.(?P<kind>partial|old)-(?P<process>[0-9]+)")


def write_atomically(path: Path, data: bytes) -> None:
    """Write a file under a temporary name, sync it, and rename it."""
    with whole_file(path) as partial:
        partial.write_bytes(data)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield the path of a hidden file to write; rename it to ``path`` at the end, or remove it after an error."""
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
def whole_folder(path: Path) -> Iterator[Path]:
    """Yield a hidden folder to fill; rename it to ``path`` at the end, or remove it after an error.

    An existing folder at ``path`` is renamed just before and removed just after. If the process is killed between the
    two renames, `remove_leftovers` restores it.
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
        # Also for Ctrl-C: no incomplete folder may remain.
        if old.exists() and not path.exists():
            old.rename(path)
        shutil.rmtree(partial, ignore_errors=True)
        raise
    _sync(path.parent)
    shutil.rmtree(old, ignore_errors=True)


def discard(folder: Path) -> None:
    """Remove a folder, atomically for readers. A process killed during the removal leaves a hidden folder."""
    hidden = _hidden(folder, "partial")
    folder.rename(hidden)
    shutil.rmtree(hidden)


def remove_leftovers(folder: Path) -> None:
    """Remove the incomplete files and folders of killed processes, and restore what they had renamed.

    Files of other running processes are kept.
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


def another_writes(folder: Path) -> bool:
    """Return whether another running process is writing into a folder."""
    matches = [_PARTIAL.fullmatch(entry.name) for entry in folder.iterdir()] if folder.is_dir() else []
    return any(_is_another_alive(int(match["process"])) for match in matches if match)


def is_leftover(name: str) -> bool:
    """Return whether a name is one of the temporary names of this module."""
    return _PARTIAL.fullmatch(name) is not None


def _hidden(path: Path, kind: str) -> Path:
    return path.with_name(f".{path.name}.{kind}-{os.getpid()}")


def _is_another_alive(process: int) -> bool:
    if process == os.getpid():
        return False
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):  # a number too large to be a process id
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
