"""``build-dataset``: many labelled scenes from one seed, by worker processes or a cluster; it can be resumed."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from ...core.exit_codes import run_command
from ..settings.config import parse_request
from .build_request import BuildDataset

_DESCRIPTION = """Build a data set of many labelled scenes. The same command again resumes a build that was stopped.

  build-dataset --scenes 0:20 --seed 1 --workers 2 --out data
  build-dataset --scenes 0:2000 --seed 1 --preset standard --config mine.yaml --shard 1/4 --out part-1

Settings are those of render-scene: a preset, then a YAML file (--config), then these options."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _build_dataset(given))


def _build_dataset(arguments: Sequence[str]) -> None:
    request = parse_request(BuildDataset, arguments, "build-dataset", _DESCRIPTION)
    # Loaded here: it takes longer than the user should wait for the first line.
    from .build_work import build

    build(request, arguments)


if __name__ == "__main__":
    sys.exit(main())
