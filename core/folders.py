"""The files in a user's folder."""

from __future__ import annotations

import stat
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from .errors import InputError, cause_of
from .user_text import counted, usable_text

#: Most kinds of files that a message names [1].
_MOST_KINDS = 4


def files_in(folder: Path, content: str, suffixes: Sequence[str], below: bool) -> tuple[Path, ...]:
    """Return the files with these suffixes in a folder, ordered by their relative paths.

    Hidden files and folders, whose names begin with a dot, are left out. Links are followed; a folder that links lead
    to more than once is searched once. A link to nothing counts as a file: whoever reads it says what is missing.

    Parameters
    ----------
    folder : Path
        The folder.
    content : str
        What the folder holds, for the message.
    suffixes : sequence of str
        In lower case; compared without case.
    below : bool
        Whether to search subfolders too.

    Raises
    ------
    InputError
        Where it is not a folder, cannot be read, has no such file, or has one whose name is not UTF-8, which a JSON
        file cannot hold.
    """
    try:
        if folder.is_file() and folder.suffix.lower() not in suffixes:
            raise InputError(folder, f"a folder of {content} ({' '.join(suffixes)})", "a file of another format")
        if not folder.is_dir():
            raise InputError(folder, f"a folder of {content}", "a file" if folder.exists() else "no such folder")
        found = [path for path in _entries(folder, below) if path.suffix.lower() in suffixes and _is_file(path)]
    except OSError as error:
        raise InputError(folder, f"a readable folder of {content}", cause_of(error)) from error
    if not found:
        raise InputError(folder, f"{content} ({' '.join(suffixes)})", _others(folder, below))
    for path in found:
        try:
            usable_text(str(path))
        except ValueError as error:
            raise InputError(path, "a file name in UTF-8", "other bytes") from error
    return tuple(sorted(found, key=lambda path: path.relative_to(folder).as_posix()))


def listed_in(folder: Path, suffixes: Sequence[str]) -> tuple[Path, ...]:
    """Return the files below a folder that `files_in` finds, ordered alike; none where it finds none."""
    if not folder.is_dir():
        return ()
    found = [path for path in _entries(folder, True) if path.suffix.lower() in suffixes and path.is_file()]
    return tuple(sorted(found, key=lambda path: path.relative_to(folder).as_posix()))


def _others(folder: Path, below: bool) -> str:
    """Return what is in a folder in place of what was expected, by the ends of the names, the most frequent first."""
    kinds = Counter(path.suffix.lower() or "no suffix" for path in _entries(folder, below) if path.is_file())
    if not kinds:
        return "none"
    shown = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common(_MOST_KINDS))
    return f"none in {counted(kinds.total(), 'file')} ({shown})"


def _is_file(path: Path) -> bool:
    """Return whether an entry is a file, or a link to nothing, which is named later; a pipe would never end."""
    return path.is_file() or not path.exists()


def _entries(folder: Path, below: bool) -> Iterator[Path]:
    """Yield what is in a folder, and in its subfolders where asked for."""
    waiting, seen = [folder], {folder.resolve()}
    while waiting:
        here = waiting.pop()
        for path in sorted(here.iterdir()):
            if path.name.startswith("."):
                continue
            if not path.is_dir():
                yield path
            elif below and path.resolve() not in seen:
                seen.add(path.resolve())
                waiting.append(path)


def regular_content(path: Path, content: str, most: int, size: str) -> bytes:
    """Return the bytes of a file that a user named, without opening what is no file or is too large.

    Parameters
    ----------
    path : Path
        The file.
    content : str
        What it holds, for the message, such as ``"YAML"``.
    most : int
        Largest size [bytes].
    size : str
        What is expected of a smaller one, for the message.

    Raises
    ------
    InputError
        Where it is a folder, a device or a pipe, is too large, or cannot be read.
    """
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            kind = "a folder" if stat.S_ISDIR(status.st_mode) else "a device or a pipe"
            raise InputError(path, f"a regular file {content}", kind)
        if status.st_size > most:
            raise InputError(path, size, f"{status.st_size} bytes")
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, f"a readable file {content}", cause_of(error)) from error
