"""``glassware merge``: merge the outputs of shards into one data set."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Annotated

import tyro
from pydantic import Field
from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.model import Model
from ...core.user_text import UserPath, counted
from ..builds.merge import merge
from ..builds.output_folder import lock_output
from ..format import layout
from ..settings.config import parse_request

_DESCRIPTION = """Merge data sets of one seed and one configuration, such as the shards of a build.

Files become hard links where both folders are on one file system, else copies. The sources do not change."""


class Merge(Model):
    """The request: the data sets to merge, and the target."""

    sources: Annotated[tuple[UserPath, ...], tyro.conf.Positional] = Field(description="Folders of data sets")
    out: UserPath = Field(description="Target folder: absent, empty, or the target of an earlier merge")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _merge(given))


def _merge(arguments: Sequence[str]) -> None:
    request = parse_request(Merge, arguments, "glassware merge", _DESCRIPTION)
    console = Console()

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    if not request.sources:
        raise InputError("glassware merge", "folders of data sets", "none")
    for source in request.sources:
        if not (source / layout.DATASET).is_file():
            raise InputError(source, f"the folder of a data set, with {layout.DATASET}", "none")
        if source.resolve() == request.out.resolve():
            raise InputError("--out", "another folder than the sources", source)
    with lock_output(request.out, say):
        views = merge(request.sources, request.out)
    say(f"{request.out}: {counted(len(layout.scene_ids(request.out)), 'scene')}, {counted(views, 'view')}")


if __name__ == "__main__":
    sys.exit(main())
