"""``glassware show``: the contact sheet of a data set."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import tyro
from pydantic import Field
from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.model import Model
from ...core.user_text import UserPath
from ..format import layout
from ..settings.config import parse_request

_DESCRIPTION = """Show the contact sheet of a data set: up to five views of a scene, or the scenes of a build.

  glassware show out

Where there is a display it is opened with the desktop's own viewer (xdg-open); its path is printed in any case."""
#: Variables that a graphical session sets (X11, Wayland).
_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")


class Show(Model):
    """The request: a data set."""

    directory: Annotated[UserPath, tyro.conf.Positional] = Field(
        default=Path("out"), description="Folder of the data set; out by default"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _show(given))


def _show(arguments: Sequence[str]) -> None:
    root = parse_request(Show, arguments, "glassware show", _DESCRIPTION).directory
    if not (root / layout.DATASET).is_file():
        raise InputError(root, f"the folder of a data set, with {layout.DATASET}", "none")
    sheet = root / layout.PREVIEW
    if not sheet.is_file():
        raise InputError(sheet, "a contact sheet, which render-scene and a finished build write", "none")
    open_file(sheet)
    Console().print(str(sheet.absolute()), markup=False, highlight=False, soft_wrap=True)


def open_file(path: Path) -> None:
    """Open a file with the desktop's own viewer; nothing happens where there is no display."""
    viewer = _viewer(os.environ)
    if viewer is not None:
        subprocess.run([viewer, path.absolute()], check=False)


def _viewer(environment: Mapping[str, str]) -> str | None:
    """Return the program that opens a file on this desktop; None where there is no display or no such program."""
    return shutil.which("xdg-open") if any(environment.get(name) for name in _DISPLAYS) else None


if __name__ == "__main__":
    sys.exit(main())
