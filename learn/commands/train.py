"""``glassware train``: train a network on a data set."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import tyro
from pydantic import Field
from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.user_text import UserPath
from ...dataset.settings.config import parse_request, typed_names
from ..training.settings import TrainSettings
from .extra import check_extra

_DESCRIPTION = """Train a network that finds glass in pictures: its boxes, masks, poses and depth.

  glassware train data --config network.yaml --out out-train
  glassware train data --config network.yaml --out out-train --resume out-train/last.safetensors
  glassware train other --init out-train/best.safetensors --out out-tuned

DATA is a data set of several scenes (build-dataset), split into train, val and test. OUT gets the last weights, those
of the least validation loss (best.safetensors), and a log. Settings come from the YAML file, then from these options.
A run that was stopped goes on with --resume and ends with the weights of a run without a stop. --init begins a new
run with the network of another one: on other data, with other settings, or for longer."""


class Train(TrainSettings):
    """Arguments of the command."""

    data: tyro.conf.Positional[UserPath | None] = Field(default=None, description="Folder of the data set")
    out: UserPath = Field(default=Path("out-train"), description="Output folder")
    resume: UserPath | None = Field(default=None, description="Checkpoint to resume from")
    init: UserPath | None = Field(
        default=None,
        description="Checkpoint, or weights by name (base), with whose network a new run begins, such as on other data",
    )
    config: UserPath | None = Field(default=None, description="YAML file of settings")


#: For the completion of shells.
REQUEST = Train


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _train(given))


def _train(arguments: Sequence[str]) -> None:
    request = parse_request(Train, arguments, "glassware train", _DESCRIPTION)
    if request.data is None:
        raise InputError("glassware train", "the folder of a data set", "none")
    check_extra("glassware train")
    # Loaded here: torch is an extra, and takes longer to load than help should take.
    from ..training.run import train

    settings = TrainSettings.model_validate({name: getattr(request, name) for name in TrainSettings.model_fields})
    console = Console()

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    typed = typed_names(TrainSettings, arguments)
    train(settings, request.data, request.out, request.resume, say, request.init, typed)


if __name__ == "__main__":
    sys.exit(main())
