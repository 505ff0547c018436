"""The files in a user's folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from .errors import InputError, cause_of
from .user_text import usable_text


def files_in(folder: Path, content: str, suffixes: Sequence[str], below: bool) -> tuple[Path, ...]:
    """Return the files with these suffixes in a folder, ordered by their relative paths.

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
        if not folder.is_dir():
            raise InputError(folder, f"a folder of {content}", "a file" if folder.exists() else "no such folder")
        entries = folder.rglob("*") if below else folder.iterdir()
        found = [path for path in entries if path.suffix.lower() in suffixes and path.is_file()]
    except OSError as error:
        raise InputError(folder, f"a readable folder of {content}", cause_of(error)) from error
    if not found:
        raise InputError(folder, f"{content} ({' '.join(suffixes)})", "none")
    for path in found:
        try:
            usable_text(str(path))
        except ValueError as error:
            raise InputError(path, "a file name in UTF-8", "other bytes") from error
    return tuple(sorted(found, key=lambda path: path.relative_to(folder).as_posix()))
