"""``glassware report``: a page about a data set, as one HTML file."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Annotated

import tyro
from pydantic import Field
from rich.console import Console

from ...core.atomic_io import write_atomically
from ...core.errors import InputError, cause_of
from ...core.exit_codes import WorkFailed, run_command
from ...core.model import Model
from ...core.user_text import UserPath, counted, sized
from ..format import layout
from ..reader import Dataset
from ..report.page import page
from ..report.summary import summarise
from ..settings.config import parse_request
from .page_file import check_page_file
from .progress import tracked

_DESCRIPTION = """Write a page about a data set, one HTML file that loads nothing: pictures of scenes, distributions of
what was drawn, time and size, failures, files and licences, splits.

  glassware report data

Everything on it is read from the files of the data set; nothing is rendered."""
#: Ends of the page's name: a slip must not replace a file of the data set.
_HTML = (".html", ".htm")


class Report(Model):
    """The request: a data set, and where the page goes."""

    directory: Annotated[UserPath, tyro.conf.Positional] = Field(description="Folder of the data set")
    out: UserPath | None = Field(
        default=None, description="HTML file to write; report.html in the folder of the data set by default"
    )
    pictures: int = Field(default=48, ge=0, le=1000, description="Most pictures of scenes on it; about 10 kB each")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _report(given))


def _report(arguments: Sequence[str]) -> None:
    request = parse_request(Report, arguments, "glassware report", _DESCRIPTION)
    root, console = request.directory, Console()
    if not (root / layout.DATASET).is_file():
        raise InputError(root, f"the folder of a data set, with {layout.DATASET}", "none")
    out = request.out or root / layout.REPORT
    check_page_file("--out", out, root, _HTML)
    dataset = Dataset.open(root)
    if dataset.head.converted is not None:
        found = f"one that was converted from {dataset.head.converted.title}, which glassware inspect describes"
        raise InputError(root, "a rendered data set", found)
    summary = summarise(dataset, request.pictures, lambda ids: tracked(ids, "reading scenes", len(ids), console))
    data = page(summary).encode()
    try:
        write_atomically(out, data)
    except OSError as error:
        raise InputError(out, "a file that can be written", cause_of(error)) from error
    line = f"{out}: {counted(summary.scenes, 'scene')}, {sized(len(data))}"
    console.print(line, markup=False, highlight=False, soft_wrap=True)
    if summary.left_out:
        lines = [f"scene {scene_id}: {reason}" for scene_id, reason in summary.left_out.items()]
        raise WorkFailed("\n".join([f"{counted(len(lines), 'scene')} left out", *lines]))


if __name__ == "__main__":
    sys.exit(main())
