"""A layout of files, and the folders of a data set that have it."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ...core.errors import InputError, cause_of
from .source_view import Collection

#: Deepest level below the given folder at which data is looked for: cleargrasp/synthetic-val/object is the second,
#: set1/scene1 of ClearPose as well.
DEEPEST = 4


@dataclass(frozen=True)
class Layout:
    """How one project lays out its files."""

    name: str  #: as it is typed, such as ``keypose``
    title: str  #: as its authors write it
    licence: str  #: of the data, as its authors state it
    is_unit: Callable[[frozenset[str]], bool]  #: whether a folder with these entries holds views of it
    expected: str  #: what such a folder holds, for errors
    open: Callable[[Path, Sequence[Path]], Collection]  #: (given folder, folders with views) -> its views


def folders_with_names(root: Path) -> Generator[tuple[Path, frozenset[str]], bool | None, None]:
    """Yield a folder and those below it, each with the names in it, level by level in the order of their names.

    A caller that sends a true value does not want the folders below the one that it was given. Links to folders are
    not followed, and hidden folders left out.
    """
    level = [root]
    for _ in range(DEEPEST + 1):
        below: list[Path] = []
        for folder in level:
            try:
                with os.scandir(folder) as entries:
                    found = [(entry.name, entry.is_dir(follow_symlinks=False)) for entry in entries]
            except OSError as error:
                raise InputError(folder, "a readable folder", cause_of(error)) from error
            stop = yield folder, frozenset(name for name, _ in found)
            if not stop:
                below += [folder / name for name, is_dir in sorted(found) if is_dir and not name.startswith(".")]
        level = below


def names_in(folder: Path) -> frozenset[str]:
    """Return the names in a folder; empty where there is none."""
    try:
        return frozenset(path.name for path in folder.iterdir())
    except OSError:
        return frozenset()
