"""CPU time of whole scenes with the irradiance cache over that of path tracing, side by side.

    python bench/cache_speed.py
    python bench/cache_speed.py --seeds 7 101 104

The first takes under three minutes of CPU time, the second about nine. Each seed is drawn with the preset `fast`. Its
views are rendered as the scene says, with light stored first, and path traced with the samples that the preset had
before it stored light. The two take turns, view by view, so that whatever else the machine does meets both. Both have
rendered one view before, which compiles. Files and labels are left out.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from time import process_time

from command import Output, run
from table import Row, report

from glassware.dataset.settings.draw import draw
from glassware.procedural.description.scene import Scene
from glassware.render.renderer import Renderer


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """What to measure."""

    seeds: tuple[int, ...] = (7,)
    """Seeds that are drawn."""
    views: int | None = None
    """Views of each instead of the preset's; light is stored for five or more."""
    path_spp: int = 32
    """Samples per pixel of path tracing."""


def main(options: Options) -> int:
    """Measure and print."""
    rows = [row for seed in options.seeds for row in _rows(seed, options)]
    return report("Scenes with stored light over path tracing", rows, options.json_file, path_spp=options.path_spp)


def _rows(seed: int, options: Options) -> list[Row]:
    cameras = {} if options.views is None else {"views": options.views}
    stored = draw(seed, preset="fast", cameras=cameras)
    traced = draw(seed, preset="fast", cameras=cameras, picture={"light": "path", "spp": options.path_spp})
    (cached, light), (paths, _) = (_loaded(scene) for scene in (stored, traced))
    for renderer in (cached, paths):
        renderer.frame(0)
    times = {cached: 0.0, paths: 0.0}
    for view in range(len(stored.cameras)):
        for renderer in (cached, paths) if view % 2 else (paths, cached):
            start = process_time()
            renderer.frame(view)
            times[renderer] += process_time() - start
    mode = "path" if cached.light_check is None else cached.light_check.mode
    return [
        Row(f"{seed}: CPU time of the light", light, "s", note=f"mode {mode}"),
        Row(f"{seed}: CPU time of {len(stored.cameras)} views with it", times[cached], "s"),
        Row(f"{seed}: by path tracing", times[paths], "s"),
        Row(f"{seed}: ratio, light included", (light + times[cached]) / times[paths]),
    ]


def _loaded(scene: Scene) -> tuple[Renderer, float]:
    """Return the renderer of a scene, and the CPU time that its light took, loading left out [s]."""
    started: dict[str, float] = {}

    def note(stage: str) -> None:
        started[stage] = process_time()

    renderer = Renderer(scene, on_stage=note)
    return renderer, process_time() - started.get("light", process_time())


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
