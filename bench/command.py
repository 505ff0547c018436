"""What the commands share: their common options, and how they start."""

from __future__ import annotations

import resource
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

import tyro
from rich.console import Console
from scenes import NAMES

from glassware.core.errors import InputError

O = TypeVar("O")  # noqa: E741


@dataclass(frozen=True, kw_only=True)
class Output:
    """Where the figures go."""

    json_file: Annotated[Path | None, tyro.conf.arg(name="json")] = None
    """File to write the figures to."""


@dataclass(frozen=True, kw_only=True)
class PictureOptions(Output):
    """What pictures to measure, and against which references."""

    scenes: tuple[str, ...] = NAMES
    """Names of the scenes."""
    width: int = 320
    """Width of the picture [px]."""
    height: int = 180
    """Height of the picture [px]."""
    repeats: int = 2
    """Pictures with different seeds that each figure is the mean of."""
    reference_spp: int = 4096
    """Samples per pixel of the references."""
    cache: Path = Path(".scratch/references")
    """Folder of the references."""
    pictures: Path | None = None
    """Folder for PNG files of what was measured."""


def run(options: type[O], description: str | None, measure: Callable[[O], int]) -> int:
    """Parse the command line, measure, and return the exit code: 2 with one line for a user's mistake."""
    given = tyro.cli(options, description=description)
    try:
        return measure(given)
    except InputError as error:
        Console(stderr=True).print(str(error), markup=False, highlight=False, soft_wrap=True)
        return 2


def seconds_of(command: Sequence[Any], log: Path, allowed: tuple[int, ...] = (0,)) -> float:
    """Run a program of this environment and return the processor time that it took [s].

    Parameters
    ----------
    command : sequence
        The program's name, and its arguments.
    log : Path
        Where what it prints goes.
    allowed : tuple of int
        Exit codes that are no failure.

    Raises
    ------
    subprocess.CalledProcessError
        Where the program ends with another exit code.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    arguments = [Path(sys.executable).with_name(command[0]), *map(str, command[1:])]
    with log.open("w") as printed:
        code = subprocess.run(arguments, stdout=printed, stderr=subprocess.STDOUT, check=False).returncode
    if code not in allowed:
        raise subprocess.CalledProcessError(code, arguments)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
