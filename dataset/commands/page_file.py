"""The file that a command writes about a data set: a page or a recording, beside it or elsewhere."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from ...core.errors import InputError
from ..format import layout


def check_page_file(option: str, out: Path, root: Path, ends: Sequence[str]) -> None:
    """Refuse a file that could not be written after minutes of reading, or that would replace another kind of file.

    Parameters
    ----------
    option : str
        Name of the option that gives it.
    out : Path
        The file.
    root : Path
        The data set; its scenes hold only their own files.
    ends : sequence of str
        Ends of its name: a slip must not replace a file of the data set.
    """
    if out.suffix.lower() not in ends:
        raise InputError(option, f"a file that ends in {' or '.join(ends)}", out)
    if out.is_dir():
        raise InputError(option, "a file", f"the folder {out}")
    if not out.parent.is_dir():
        raise InputError(option, f"a file in a folder that is there, {out.parent}", "none")
    if out.resolve().is_relative_to((root / layout.SCENES).resolve()):
        raise InputError(option, "a file outside the folders of scenes, which hold only their own files", out)


def check_replaceable(option: str, out: Path, begins: bytes) -> None:
    """Refuse a file that is there and is of another kind, by its first bytes, and a folder that takes no new file."""
    if out.is_file():
        with out.open("rb") as file:
            if file.read(len(begins)) != begins:
                raise InputError(option, f"a new file, or a {out.suffix} file that is replaced", f"another file, {out}")
    if not os.access(out.parent, os.W_OK):
        raise InputError(option, f"a folder that can be written to, {out.parent}", "none")
