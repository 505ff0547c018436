"""Where the time of ``render-scene`` goes: each stage per view and as a share, and what labels cost.

    python bench/render_scene.py --seed 7 --preset fast

The first view compiles kernels, which the command pays for once: it is left out of the figures per view and told apart.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Annotated

import tyro
from rich.console import Console
from table import Row, report

from glassware.annotate.keypoints import SceneKeypoints, scene_keypoints
from glassware.annotate.labels import annotate
from glassware.core.errors import InputError
from glassware.dataset.format.dataset_file import DatasetFile, installed_versions
from glassware.dataset.settings.config import preset, validated
from glassware.dataset.writer import View, finish_dataset, start_dataset, write_scene
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.render.backend.variant import activate

#: Most that labels may cost of the time of the picture.
LABEL_SHARE = 0.15
#: Most that a scene of the fast preset may take on two cores [s].
FAST_SECONDS = 180.0
#: What makes labels: geometry, and what is computed from it.
_LABELS = ("geometry", "refraction", "labels")


@dataclass(frozen=True)
class Options:
    """What to measure."""

    seed: int = 7
    """Seed of the scene."""
    preset: str = "fast"
    """Preset of the settings."""
    views: int | None = None
    """Number of views; the preset's unless given. At least two."""
    spp: int | None = None
    """Samples per pixel; the preset's unless given."""
    json_file: Annotated[Path | None, tyro.conf.arg(name="json")] = None
    """File to write the figures to."""


def main() -> int:
    """Measure and print."""
    options = tyro.cli(Options, description=__doc__)
    try:
        settings = _settings(options)
        once, first, later = _measured(settings, options.seed)
    except InputError as error:
        Console(stderr=True).print(str(error), markup=False, highlight=False, soft_wrap=True)
        return 2
    rows = _rows(once, first, later, settings.cameras.views, fast=options.preset == "fast")
    size = f"{settings.cameras.width}x{settings.cameras.height}"
    title = f"render-scene, {size}, {settings.picture.spp} spp, {settings.cameras.views} stereo views"
    return report(title, rows, options.json_file, seed=options.seed, preset=options.preset)


def _settings(options: Options) -> SceneSettings:
    settings = validated(SceneSettings, preset(options.preset), "preset")
    if options.views is not None and options.views < 2:
        raise InputError("--views", "at least 2: the first compiles kernels", options.views)
    cameras = settings.cameras if options.views is None else _with(settings.cameras, views=options.views)
    picture = settings.picture if options.spp is None else _with(settings.picture, spp=options.spp)
    return settings.model_copy(update={"cameras": cameras, "picture": picture})


def _with(model, **changed):
    return validated(type(model), model.model_dump() | changed, "options")


def _measured(settings: SceneSettings, seed: int) -> tuple[dict, dict, dict]:
    """Return the seconds of what is done once, of the first view, and of all later ones together, by stage."""
    start = perf_counter()
    backend = activate()
    once = {"backend": perf_counter() - start}
    start = perf_counter()
    scene = draw_scene(settings, seed, 0)
    once["description"] = perf_counter() - start
    # Only here: these bring Mitsuba, whose variant must be set first.
    from glassware.render.labels.geometry import line_of_sight
    from glassware.render.scene.loaded_scene import load
    from glassware.render.view import render_view

    start = perf_counter()
    kernel = load(scene)
    once["loading"] = perf_counter() - start
    points: SceneKeypoints = scene_keypoints(scene)
    views: list[dict[str, float]] = []

    def rendered():
        for number, camera in enumerate(scene.cameras):
            frame = render_view(kernel, number)
            labelled = perf_counter()
            sight = line_of_sight(kernel, camera.world_T_camera[:3, 3], points.world.reshape(-1, 3))
            labels = annotate(scene, camera, frame.geometry, points, sight)
            given = perf_counter()
            views.append({**frame.seconds, "labels": given - labelled})
            yield View(number, frame, labels)
            views[-1]["writing"] = perf_counter() - given

    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder, "data")
        config = settings.model_dump(mode="json")
        head = DatasetFile(name="bench", seed=seed, config=config, versions=installed_versions(), backend=backend)
        start_dataset(root, head, [0])
        write_scene(root, scene, points, rendered())
        start = perf_counter()
        finish_dataset(root)
        once["index"] = perf_counter() - start
    later = {stage: sum(view[stage] for view in views[1:]) for stage in views[0]}
    return once, views[0], later


def _rows(once: dict, first: dict, later: dict, views: int, fast: bool) -> list[Row]:
    total = sum(once.values()) + sum(first.values()) + sum(later.values())
    rows = [Row(f"{stage}, once", seconds, "s", note=f"{seconds / total:.1%}") for stage, seconds in once.items()]
    rows += [
        Row(f"{stage}, a view", seconds / (views - 1), "s", note=f"{(seconds + first[stage]) / total:.1%} of all views")
        for stage, seconds in later.items()
    ]
    compiling = sum(first.values()) - sum(later.values()) / (views - 1)
    rows.append(Row("first view, beyond a later one", compiling, "s", note="compiling kernels"))
    share = sum(later[stage] for stage in _LABELS) / later["picture"]
    rows.append(_judged("labels over picture", share, "", LABEL_SHARE, "geometry, refraction, labels"))
    rows.append(_judged("all", total, "s", FAST_SECONDS, "") if fast else Row("all", total, "s"))
    return rows


def _judged(name: str, measured: float, unit: str, bound: float, note: str) -> Row:
    return Row(name, measured, unit, bound=bound, ratio=measured / bound, ok=measured <= bound, note=note)


if __name__ == "__main__":
    sys.exit(main())
