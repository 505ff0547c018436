"""Files and folders that appear whole or not at all, and stay after a power cut."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_PARTIAL = re.compile(r"\.(?P<name>.+)\.(?P<kind>partial|old)-(?P<process>[0-9]+)")


def write_atomically(path: Path, data: bytes) -> None:
    """Write a file beside its place, sync it, and rename it there."""
    with whole_file(path) as partial:
        partial.write_bytes(data)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give the name of a hidden file to write; put it at ``path`` in the end, or remove it where it went wrong."""
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
    """Give a hidden folder to fill; put it at ``path`` in the end, or remove it where anything went wrong.

    A folder that is at ``path`` already is moved aside just before and removed just after. Where the process is killed
    between the two moves, `remove_leftovers` puts it back.
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
        # Ctrl-C as well: it is an exception like any other, and nothing half-made may stay.
        if old.exists() and not path.exists():
            old.rename(path)
        shutil.rmtree(partial, ignore_errors=True)
        raise
    _sync(path.parent)
    shutil.rmtree(old, ignore_errors=True)


def discard(folder: Path) -> None:
    """Remove a folder: gone in one step for readers. A process that is killed meanwhile leaves a hidden leftover."""
    hidden = _hidden(folder, "partial")
    folder.rename(hidden)
    shutil.rmtree(hidden)


def remove_leftovers(folder: Path) -> None:
    """Remove what killed processes left half-made in a folder, and put back what they had moved aside.

    What belongs to another process that is alive is left alone.
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
    """Say whether another process that is alive is writing something into a folder."""
    matches = [_PARTIAL.fullmatch(entry.name) for entry in folder.iterdir()] if folder.is_dir() else []
    return any(_is_another_alive(int(match["process"])) for match in matches if match)


def is_leftover(name: str) -> bool:
    """Say whether a name is one of the hidden names that this module makes."""
    return _PARTIAL.fullmatch(name) is not None


def _hidden(path: Path, kind: str) -> Path:
    return path.with_name(f".{path.name}.{kind}-{os.getpid()}")


def _is_another_alive(process: int) -> bool:
    if process == os.getpid():
        return False
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):  # no process has a number that the system cannot count to
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
