"""``glassware evaluate``: what a network is worth on a data set."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import tyro
from pydantic import Field
from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.model import Model
from ...core.user_text import UserPath
from ...dataset.settings.config import parse_request
from ..evaluation.report import tables
from ..evaluation.run import evaluate
from ..networks.device import use

_DESCRIPTION = """Evaluate a network: glassware evaluate CKPT DATA --split val

No weight of the network changes. Figures are printed as tables and written to OUT/report.json; the samples with the
greatest error of depth are drawn beside it: what was found above, what is there below."""

#: Columns of what is printed to a file or a pipe.
_WIDTH = 160


class Evaluate(Model):
    """The request."""

    checkpoint: tyro.conf.Positional[UserPath | None] = Field(default=None, description="Checkpoint of a network")
    data: tyro.conf.Positional[UserPath | None] = Field(default=None, description="Folder of a data set")
    split: str = Field(default="val", description="Scenes: train, val, test, or all")
    out: UserPath = Field(default=Path("out-evaluate"), description="Folder of the report")
    worst: int = Field(default=8, ge=0, le=1000, description="Worst samples that are drawn")
    workers: int = Field(default=2, ge=0, le=256, description="Processes that load samples; 0: none but this one")
    device: str = Field(default="auto", description="Torch's name of a device, such as cpu or cuda:0; or auto")
    threads: int | None = Field(default=None, ge=1, le=1024, description="Threads of torch; all cores unless given")
    config: UserPath | None = Field(default=None, description="YAML file of these settings")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit code says how it went."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _evaluate(given))


def _evaluate(arguments: Sequence[str]) -> None:
    request = parse_request(Evaluate, arguments, "glassware evaluate", _DESCRIPTION)
    if request.checkpoint is None or request.data is None:
        raise InputError("glassware evaluate", "a checkpoint and the folder of a data set", "fewer")
    console = _console()

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    found = evaluate(
        request.checkpoint,
        request.data,
        request.split,
        request.out,
        say,
        worst=request.worst,
        workers=request.workers,
        device=use(request.device, request.threads),
    )
    for table in tables(found):
        console.print(table)
    say(f"written to {request.out}/report.json")


def _console() -> Console:
    """Return a console that is wide enough for the tables, in a file or a pipe as well."""
    console = Console()
    return console if console.is_terminal else Console(width=_WIDTH)


if __name__ == "__main__":
    sys.exit(main())
