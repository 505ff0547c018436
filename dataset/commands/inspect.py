"""``glassware inspect``: what a folder with another project's data set holds, and what is wrong in it."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated

import tyro
from pydantic import Field
from rich.console import Console

from ...core.exit_codes import run_command
from ...core.model import Model
from ...core.picture_size import PNG_SIGNATURE
from ...core.user_text import UserPath, counted
from ..conversion.inspection import inspect, lines_of
from ..conversion.source_sheet import source_sheet
from ..format.pictures import write_png
from ..readers.recognition import LAYOUTS, open_source
from ..readers.source_view import Entry
from ..settings.config import parse_request
from .page_file import check_page_file, check_replaceable
from .progress import tracked

_DESCRIPTION = (
    "Say what a folder with another project's data set holds: layout, licence, number of views, what they are\n"
    "labelled with, what is missing or damaged; with a contact sheet.\n\n"
    "  glassware inspect keypose\n\nKnown: " + ", ".join(layout.title for layout in LAYOUTS.values()) + "."
)


class Inspect(Model):
    """The request: a folder, how much of it is read, and the contact sheet."""

    directory: Annotated[UserPath, tyro.conf.Positional] = Field(description="Folder of the data set, or a part of it")
    most: int = Field(default=24, ge=0, description="Most views that are read, evenly spaced; 0: all")
    sheet: UserPath = Field(
        default=Path("inspect.png"), description="PNG file of the contact sheet, in the current folder"
    )
    rows: int = Field(default=5, ge=0, le=40, description="Most views on the contact sheet; 0 makes none")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _inspect(given))


def _inspect(arguments: Sequence[str]) -> None:
    request = parse_request(Inspect, arguments, "glassware inspect", _DESCRIPTION)
    console = Console()

    def track(entries: Iterable[Entry], total: int) -> Iterator[Entry]:
        return tracked(entries, "reading views", total, console)

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    if request.rows:
        check_page_file("sheet", request.sheet, request.directory, (".png",))
        check_replaceable("sheet", request.sheet, PNG_SIGNATURE)
    layout, collection = open_source(request.directory)
    seen = inspect(collection, request.most, request.rows, track)
    for line in lines_of(request.directory, layout, collection, seen):
        say(line)
    if seen.shown:
        write_png(request.sheet, source_sheet(f"{layout.title}: {request.directory.resolve().name}", seen.shown))
        say(f"{request.sheet}: {counted(len(seen.shown), 'view')}")


if __name__ == "__main__":
    sys.exit(main())
