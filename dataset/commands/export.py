"""``glassware export``: a data set in the layout of another project."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Annotated

import tyro
from pydantic import Field
from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.user_text import UserPath, counted
from ..exports.formats import FORMATS
from ..exports.job import ExportOptions
from ..exports.run import export
from ..format import layout
from ..settings.config import parse_request
from .progress import tracked

_WIDTH = max(map(len, FORMATS))
_DESCRIPTION = (
    "Write a data set in the layout of another project, so that its tools read it.\n\n"
    "  glassware export data --format coco --out data-coco\n\n"
    + "\n".join(f"  {name:{_WIDTH}}  {exporter.purpose}" for name, exporter in FORMATS.items())
    + "\n\nAn export that was stopped goes on: scenes that are complete are kept."
)


class Export(ExportOptions):
    """The request: a data set, the format and the target."""

    directory: Annotated[UserPath, tyro.conf.Positional] = Field(description="Folder of the data set")
    format: str = Field(description=f"One of {', '.join(FORMATS)}")
    out: UserPath = Field(description="Folder of the export: absent, empty, or an earlier export that goes on")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _export(given))


def _export(arguments: Sequence[str]) -> None:
    request = parse_request(Export, arguments, "glassware export", _DESCRIPTION)
    if not (request.directory / layout.DATASET).is_file():
        raise InputError(request.directory, f"the folder of a data set, with {layout.DATASET}", "none")
    console = Console()
    options = {name: getattr(request, name) for name in ExportOptions.model_fields}
    done = export(
        request.directory,
        request.format,
        request.out,
        lambda scenes, total: tracked(scenes, f"exporting to {request.format}", total, console),
        **options,
    )
    kept = f", {done.scenes - done.written} of them kept" if done.written < done.scenes else ""
    line = f"{request.out}: {request.format}, {counted(done.scenes, 'scene')}{kept}"
    console.print(line, markup=False, highlight=False, soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
