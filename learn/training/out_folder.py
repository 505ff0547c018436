"""The folder that a command of `learn` writes to."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

from lightning_fabric.utilities.rank_zero import rank_zero_only

from ...core.atomic_io import remove_leftovers
from ...core.errors import InputError, cause_of
from ...core.folder_lock import locked_folder
from ...dataset.format import layout


@contextmanager
def locked_out_folder(out: Path, say: Callable[[str], None]) -> Iterator[None]:
    """Make a folder, as `make_out_folder` does, and lock it for one run; InputError where another one works in it.

    Of the processes of a run the first one locks it: they share the folder.
    """
    make_out_folder(out)
    with nullcontext() if getattr(rank_zero_only, "rank", 0) else locked_folder(out, "run", say):
        yield


def make_out_folder(out: Path) -> None:
    """Make a folder, and delete the unfinished files that killed processes left in it.

    Raises
    ------
    InputError
        Where it cannot be made or written to, or is a data set: before any work is done, not after it.
    """
    if (out / layout.DATASET).is_file():
        raise InputError("out", "a folder of its own", f"the data set {out}")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(out, "a folder that can be made and written to", cause_of(error)) from error
    if not os.access(out, os.W_OK):
        raise InputError(out, "a folder that can be written to", "one that cannot")
    remove_leftovers(out)
