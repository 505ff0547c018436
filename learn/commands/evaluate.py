"""``glassware evaluate``: metrics of a network on a data set."""

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
from ..data.settings import Convergence
from ..data.splits import SplitName
from .extra import check_extra

_DESCRIPTION = """Measure how well a network finds glass: its predictions against the labels of a data set.

  glassware evaluate out-train/best.safetensors data --split val
  glassware evaluate base data --split test

CHECKPOINT is a file of weights that train wrote, or the name of weights that come with glassware, DATA a data set with
that split. Depth error, precision of boxes, masks and poses are printed as tables and written to OUT/report.json,
beside images of the samples with the greatest depth error (predictions above, ground truth below). The network does not
change. --convergence gives networks that learnt from whole pairs the same pixels as those that learnt from cut ones."""

#: Columns of output that goes to a file or a pipe.
_WIDTH = 160


class Evaluate(Model):
    """Arguments of the command."""

    checkpoint: tyro.conf.Positional[UserPath | None] = Field(
        default=None, description="Checkpoint of a network, or weights by name"
    )
    data: tyro.conf.Positional[UserPath | None] = Field(default=None, description="Folder of a data set")
    split: SplitName = Field(default="val", description="Scenes to evaluate on")
    out: UserPath = Field(default=Path("out-evaluate"), description="Output folder")
    detector: UserPath | None = Field(
        default=None,
        description="Checkpoint of a network that says where objects are, for networks that have to be told (keypose, "
        "densefusion)",
    )
    convergence: Convergence | None = Field(
        default=None,
        description="For stereo pairs, the depth at which both pictures are cut to show the same [m] "
        "(views.convergence); by default as in training",
    )
    worst: int = Field(default=8, ge=0, le=1000, description="Number of worst samples drawn as images")
    workers: int = Field(default=2, ge=0, le=256, description="Processes that load samples; 0: in the main process")
    device: str = Field(default="auto", description="Torch's name of a device, such as cpu or cuda:0; or auto")
    threads: int | None = Field(default=None, ge=1, le=1024, description="CPU threads of torch; all cores by default")
    config: UserPath | None = Field(default=None, description="YAML file of these settings")


#: For the completion of shells.
REQUEST = Evaluate


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _evaluate(given))


def _evaluate(arguments: Sequence[str]) -> None:
    request = parse_request(Evaluate, arguments, "glassware evaluate", _DESCRIPTION)
    if request.checkpoint is None or request.data is None:
        raise InputError("glassware evaluate", "a checkpoint and the folder of a data set", "fewer")
    check_extra("glassware evaluate")
    # Loaded here: torch is an extra, and takes longer to load than help should take.
    from ..evaluation.report import tables
    from ..evaluation.run import evaluate
    from ..networks.build import select_device

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
        device=select_device(request.device, request.threads),
        detector=request.detector,
        convergence=request.convergence,
    )
    for table in tables(found):
        console.print(table)
    say(f"written to {request.out}/report.json")


def _console() -> Console:
    """Return a console that is wide enough for the tables in a file or a pipe."""
    console = Console()
    return console if console.is_terminal else Console(width=_WIDTH)


if __name__ == "__main__":
    sys.exit(main())
