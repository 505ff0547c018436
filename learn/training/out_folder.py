"""The folder that a command of `learn` writes to."""

from __future__ import annotations

import os
from pathlib import Path

from ...core.atomic_io import remove_leftovers
from ...core.errors import InputError, cause_of
from ...dataset.format import layout


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
