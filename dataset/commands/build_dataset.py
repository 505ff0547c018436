"""``build-dataset``: many labelled scenes from one seed, by worker processes or a cluster; it can be resumed."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.user_text import counted
from ..settings.config import parse_request
from ..settings.scene_ranges import requested_scenes, shard
from .build_request import BuildDataset

_DESCRIPTION = """Build a data set of many labelled scenes. The same command again resumes a build that was stopped.

  build-dataset --scenes 0:20 --seed 1 --workers 2 --out data
  build-dataset --scenes 0:2000 --seed 1 --config mine.yaml --shard 1/4 --out part-1

Settings are those of render-scene: a preset, then a YAML file (--config), then these options."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _build_dataset(given))


def _build_dataset(arguments: Sequence[str]) -> None:
    request = parse_request(BuildDataset, arguments, "build-dataset", _DESCRIPTION)
    scenes, cameras = _requested_scenes(request), request.settings.cameras
    size = cameras.intrinsics()
    console = Console()
    each = f"{counted(cameras.views, 'stereo view')} of {size.width}x{size.height} px each"
    line = f"{request.out}: {counted(len(scenes), 'scene')} of seed {request.seed}, {each}"
    console.print(line, markup=False, highlight=False, soft_wrap=True)
    # Loaded here: it takes longer than the user should wait for the first line.
    from .build_work import build

    build(request, scenes, console, arguments)


def _requested_scenes(request: BuildDataset) -> list[int]:
    if request.overwrite and request.retry_failed:
        raise InputError(
            "--retry-failed", "it without --overwrite, which deletes scenes that would not be rendered again", "both"
        )
    scenes = requested_scenes(request.scenes, request.count)
    return scenes if request.shard is None else shard(scenes, request.shard)


if __name__ == "__main__":
    sys.exit(main())
