"""``glassware convert``: another project's data set in our format."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from typing import Annotated

import tyro
from pydantic import Field
from rich.console import Console

from ...core.exit_codes import run_command
from ...core.model import Model
from ...core.user_text import UserPath, counted
from ..conversion.convert import WrittenScene, convert
from ..conversion.inspection import MOST_LINES, inspect
from ..conversion.source_sheet import source_sheet
from ..format import layout as ours
from ..format.pictures import write_png
from ..readers.recognition import LAYOUTS, open_source
from ..readers.statements import chosen, stated
from ..settings.config import parse_request
from .progress import tracked

_DESCRIPTION = (
    "Write another project's data set in our format, so that verify, show, export, train and evaluate take what it\n"
    "has.\n\n"
    "  glassware convert keypose --out keypose-ours\n\n"
    "Nothing is invented: what a data set does not state is null or has no file. Views that cannot be read are left\n"
    "out, counted and named in dataset.json. Known: " + ", ".join(layout.title for layout in LAYOUTS.values()) + "."
)


class Convert(Model):
    """The request: a folder, where its conversion goes, and what its files do not state."""

    directory: Annotated[UserPath, tyro.conf.Positional] = Field(description="Folder of the data set, or a part of it")
    out: UserPath = Field(description="Output folder: absent, empty, or an earlier conversion of the same folder")
    transparent: str | None = Field(
        default=None,
        description="For data sets that do not say which objects are transparent: all, none, or categories with commas",
    )
    only: str | None = Field(
        default=None, description="Only views whose names match one of these patterns, such as mug_*/*,bottle_0/*"
    )
    rows: int = Field(default=5, ge=0, le=40, description="Most views on the contact sheet (preview.png)")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _convert(given))


def _convert(arguments: Sequence[str]) -> None:
    request = parse_request(Convert, arguments, "glassware convert", _DESCRIPTION)
    console = Console()

    def track(scenes: Iterable[WrittenScene], total: int) -> Iterator[WrittenScene]:
        return tracked(scenes, "converting scenes", total, console)

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    layout, found = open_source(request.directory)
    collection = stated(chosen(found, request.only), request.transparent)
    head = convert(request.directory, layout, collection, request.out, track)
    shown = inspect(collection, request.rows, request.rows).shown if request.rows else ()
    if shown:
        write_png(request.out / ours.PREVIEW, source_sheet(f"{layout.title}: {head.name}", shown))
    record = head.converted
    assert record is not None
    say(f"{request.out}: {layout.title}, {counted(record.views, 'view')}: {', '.join(record.has)}")
    if record.left_out:
        say(f"left out: {counted(record.left_out, 'view')}, named in dataset.json")
        for item in head.findings[:MOST_LINES]:
            say(f"  {item.path}: {item.reason}")


if __name__ == "__main__":
    sys.exit(main())
