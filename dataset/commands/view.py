"""``glassware view``: a data set in a browser, as one page that holds everything, or in Rerun."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import tyro
from pydantic import Field
from rich.console import Console

from ...core.atomic_io import atomic_file
from ...core.errors import InputError, cause_of
from ...core.exit_codes import run_command
from ...core.model import Model
from ...core.user_text import UserPath, counted, sized
from ..format import layout
from ..reader import Dataset
from ..settings.config import parse_request
from ..settings.scene_ranges import parse_scenes
from ..viewer.choice import chosen
from ..viewer.page import page_parts
from ..viewer.recording import rerun_library, write_recording
from .page_file import check_page_file
from .progress import tracked
from .show import open_file

_DESCRIPTION = """Look at a data set: pictures, every label over them, cameras, boxes, meshes and points in 3D.

  glassware view out
  glassware view out --save out.html --scenes 0:4 --most-views 8
  glassware view out --rerun
  glassware view out --save out.rrd

Without --save the page is view.html in the folder of the data set, and is opened where there is a display. It is one
file that loads nothing: it can be sent to others."""
#: Ends of names, and what is written for each.
_HTML, _RERUN = (".html", ".htm"), (".rrd",)


class View(Model):
    """The request: a data set, what of it, and where it is shown."""

    directory: Annotated[UserPath, tyro.conf.Positional] = Field(
        default=Path("out"), description="Folder of the data set; out by default"
    )
    save: UserPath | None = Field(
        default=None, description="File to write instead of opening one: .html, or .rrd for Rerun"
    )
    rerun: bool = Field(default=False, description="Open Rerun instead of a browser (needs the extra `view`)")
    scenes: str | None = Field(default=None, description="Scenes such as 0:4 or 3,7; evenly spaced ones by default")
    most_views: int = Field(default=8, ge=1, le=500, description="Views at most; each takes 1 to 3 MB at 640x480 px")
    most_columns: int = Field(
        default=640, ge=16, le=4096, description="Columns of pictures at most [px]; larger ones are reduced"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _view(given))


def _view(arguments: Sequence[str]) -> None:
    request = parse_request(View, arguments, "glassware view", _DESCRIPTION)
    root, console = request.directory, Console()
    if not (root / layout.DATASET).is_file():
        raise InputError(root, f"the folder of a data set, with {layout.DATASET}", "none")
    rerun = request.rerun or (request.save is not None and request.save.suffix.lower() in _RERUN)
    out = request.save or root / (layout.RECORDING if rerun else layout.PAGE)
    check_page_file("--save", out, root, _RERUN if rerun else _HTML)
    dataset = Dataset.open(root)
    if rerun:
        rerun_library()
        if dataset.head.converted is not None:
            found = f"a conversion of {dataset.head.converted.title}"
            raise InputError(root, "a rendered data set for Rerun; a page shows converted ones (no --rerun)", found)
    views = _write(request, dataset, out, rerun, console)
    line = f"{out}: {counted(views, 'view')}, {sized(out.stat().st_size)}"
    console.print(line, markup=False, highlight=False, soft_wrap=True)
    if request.save is None and rerun:
        subprocess.run([sys.executable, "-m", "rerun", str(out.absolute())], check=False)
    elif request.save is None:
        open_file(out)


def _write(request: View, dataset: Dataset, out: Path, rerun: bool, console: Console) -> int:
    """Write the file, whole or not at all; return the number of views."""
    choices = chosen(dataset, parse_scenes(request.scenes) if request.scenes else (), request.most_views)
    try:
        with atomic_file(out) as partial:
            if rerun:
                write_recording(
                    partial,
                    dataset.head,
                    choices,
                    request.most_columns,
                    lambda all: tracked(all, "scenes", len(choices), console),
                )
            else:
                with partial.open("w", encoding="utf-8") as file:
                    parts = page_parts(dataset.head, choices, request.most_columns)
                    total = 2 + sum(1 + len(choice.views) for choice in choices)
                    file.writelines(tracked(parts, "views", total, console))
    except OSError as error:
        raise InputError(out, "a file that can be written", cause_of(error)) from error
    return sum(len(choice.views) for choice in choices)


if __name__ == "__main__":
    sys.exit(main())
