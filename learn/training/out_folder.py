"""The folder that a command of `learn` writes to."""

from __future__ import annotations

import os
from pathlib import Path

from ...core.atomic_io import remove_leftovers
from ...core.errors import InputError, cause_of


def make_out_folder(out: Path) -> None:
    """Make a folder, and delete the unfinished files that killed processes left in it.

    Raises
    ------
    InputError
        Where it cannot be made or written to: before any work is done, not after it.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(out, "a folder that can be made and written to", cause_of(error)) from error
    if not os.access(out, os.W_OK):
        raise InputError(out, "a folder that can be written to", "one that cannot")
    remove_leftovers(out)
