"""Scene after scene, one table of them all: what the commands that measure our own renderer share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from rich.console import Console
from table import Row, report

from glassware.core.errors import InputError


class Options(Protocol):
    """What such a command is asked for, besides its own."""

    @property
    def scenes(self) -> tuple[str, ...]:
        """Names of the scenes."""
        ...

    @property
    def width(self) -> int:
        """Width of the pictures [px]."""
        ...

    @property
    def height(self) -> int:
        """Height of the pictures [px]."""
        ...

    @property
    def reference_spp(self) -> int:
        """Samples per pixel of the reference."""
        ...

    @property
    def json_file(self) -> Path | None:
        """File to write the figures to."""
        ...


def report_scenes(title: str, options: Options, rows_of: Callable[[str], list[Row]]) -> int:
    """Print the rows of every scene as one table; return the exit code, 2 for a request that was wrong."""
    rows: list[Row] = []
    try:
        for name in options.scenes:
            rows += rows_of(name)
    except InputError as error:
        Console(stderr=True).print(str(error), markup=False, highlight=False, soft_wrap=True)
        return 2
    size = f"{options.width}x{options.height}"
    return report(f"{title}, {size}", rows, options.json_file, reference_spp=options.reference_spp)
