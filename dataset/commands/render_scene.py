"""``render-scene``: one labelled scene from a seed, with its preview."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rich.console import Console

from ...core.exit_codes import run_command
from ...core.user_text import counted
from ..settings.config import parse_request
from .progress import SceneProgress
from .scene_request import RenderScene

_DESCRIPTION = """Render one labelled scene of glass on a table: pictures, depth, masks, poses, and a contact sheet.

  render-scene --seed 7 --out out
  render-scene --preset standard --seed 8 --out out-8 --views 3 --hdri-dir hdri

Settings come from a preset (fast, keypose, standard, syn-todd, train), then a YAML file (--config), then these
options."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit code says how it went."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _render_scene(given))


def _render_scene(arguments: Sequence[str]) -> None:
    request = parse_request(RenderScene, arguments, "render-scene", _DESCRIPTION)
    cameras = request.settings.cameras
    size = cameras.intrinsics()
    progress = SceneProgress(Console())
    with progress.display():
        views = counted(cameras.views, "stereo view")
        progress.step(f"scene {request.scene} of seed {request.seed}: {views} of {size.width}x{size.height} px")
        # Loaded here: it takes longer than the user should wait for the first line.
        from .scene_work import made_scene

        made = made_scene(request, progress)
    if request.verbose:
        progress.table(f"{request.out}: scene {request.scene} of seed {request.seed}", cameras.views)
    progress.say(made)


if __name__ == "__main__":
    sys.exit(main())
