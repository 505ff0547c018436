"""``glassware export-weights``: from a checkpoint to a small file of weights to use."""

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
from ...core.user_text import UserPath, sized
from ...dataset.settings.config import parse_request
from .extra import check_extra

_DESCRIPTION = """Write the weights of a checkpoint alone, without the state of its run: a sixth of the size.

  glassware export-weights out-train/best.safetensors --name mine --data data --out weights
  glassware predict weights/mine.safetensors left.png right.png --camera d435

OUT gets NAME.safetensors with the averaged weights, their kernels in half precision, and NAME.json with what a model
card says: settings, data set, and the figures of reports that glassware evaluate wrote (--reports val=report.json)."""


class ExportWeights(Model):
    """Arguments of the command."""

    checkpoint: tyro.conf.Positional[UserPath | None] = Field(default=None, description="Checkpoint of glassware train")
    name: str = Field(default="mine", pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$", description="Name of the weights")
    data: UserPath | None = Field(
        default=None, description="Data set that they were trained on: its cameras' focal length goes with the weights"
    )
    reports: tuple[str, ...] = Field(
        default=(),
        description="Reports of glassware evaluate for the model card, such as test=out/report.json",
    )
    notes: UserPath | None = Field(
        default=None, description="YAML file with texts for the model card by their headings, such as machine"
    )
    interpolate_with: UserPath | None = Field(
        default=None,
        description="Checkpoint, or weights by name, such as those that the run began with: weights between them and "
        "the checkpoint's are written, which keep more of what the run forgot",
    )
    alpha: float | None = Field(
        default=None,
        ge=0.0,
        le=1.0,
        description="With --interpolate-with, the part of the checkpoint's weights; 0.5 by default",
    )
    out: UserPath = Field(default=Path("out-weights"), description="Output folder")
    config: UserPath | None = Field(default=None, description="YAML file of these settings")


#: For the completion of shells.
REQUEST = ExportWeights


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _export(given))


def _export(arguments: Sequence[str]) -> None:
    request = parse_request(ExportWeights, arguments, "glassware export-weights", _DESCRIPTION)
    if request.checkpoint is None:
        raise InputError("glassware export-weights", "a checkpoint of glassware train", "none")
    check_extra("glassware export-weights")
    # Loaded here: torch is an extra, and takes longer to load than help should take.
    from ..training.export_weights import ALPHA, export_weights
    from ..training.out_folder import make_out_folder

    if request.alpha is not None and request.interpolate_with is None:
        raise InputError("--alpha", "--interpolate-with beside it, as it has no effect otherwise", request.alpha)
    reports = {}
    for text in request.reports:
        words, equals, path = text.partition("=")
        if not words or not equals or not path:
            raise InputError("--reports", "words and a file, such as test=out-evaluate/report.json", text)
        reports[words] = Path(path)
    make_out_folder(request.out)
    path = export_weights(
        request.checkpoint,
        request.out,
        request.name,
        request.data,
        reports,
        request.notes,
        request.interpolate_with,
        ALPHA if request.alpha is None else request.alpha,
    )
    line = f"{path}: {sized(path.stat().st_size)}"
    Console().print(line, markup=False, highlight=False, soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
