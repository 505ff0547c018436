"""Size of each file of a stereo view with its labels, and the time for making, writing, checking and reading them.

    python bench/labels.py
    python bench/labels.py --preset standard --views 3 --json labels.json

A scene is drawn and rendered once with every file. Labels are what is traced and computed beside the two pictures:
geometry, layers, refracted rays, the right camera's, and the maps. The first view compiles, so it is left out.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, median
from time import process_time

from command import Output, run
from table import Row, report

from glassware.core.stopwatch import Stopwatch
from glassware.dataset.format.dataset_file import installed_versions, new_head
from glassware.dataset.format.file_kinds import KINDS
from glassware.dataset.pipeline import write_scene
from glassware.dataset.reader import Dataset
from glassware.dataset.settings.draw import draw
from glassware.dataset.stored_view import StoredView
from glassware.dataset.writer import finish_dataset, start_dataset
from glassware.learn.data.ground_truth import read_ground_truth
from glassware.render.frame import EYES
from glassware.render.renderer import Renderer

#: Files that every view has.
ALWAYS = ("camera.json", "labels.json", "geometry.exr", "instances.png", "left.png", "right.png")
#: Bounds: a view of 640x480 px by default [MB], labels and files of the picture's time, checks of the view's, and
#: reading a sample [ms].
MOST_BYTES, MOST_LABELS, MOST_CHECKS, MOST_READING = 4.0, 0.10, 0.02, 20.0
#: Readings of each view.
REPEATS = 15


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """What to measure."""

    preset: str = "fast"
    """Settings of the scene."""
    seed: int = 7
    """Seed of the scene."""
    views: int = 3
    """Views; the first is not counted in times."""
    width: int = 640
    """Width of the pictures [px]."""
    height: int = 480
    """Height of the pictures [px]."""


def main(options: Options) -> int:
    """Measure and print; 1 where a bound is broken."""
    cameras = {"width": options.width, "height": options.height, "views": options.views}
    scene = draw(options.seed, 0, options.preset, cameras=cameras)
    with tempfile.TemporaryDirectory(prefix="glassware-bench-") as name:
        root, stages = Path(name, "data"), []
        renderer, stopwatch = Renderer(scene), Stopwatch()
        head = new_head("bench", scene.seed, {}, installed_versions(), renderer.variant, files=KINDS)
        start_dataset(root, head, [0])

        # Called between labelling a view and writing it: its writing and checks count towards the next difference.
        def on_view(_view: int) -> None:
            stages.append(dict(stopwatch.seconds))

        write_scene(root, renderer, stopwatch, on_view, files=KINDS)
        stages.append(dict(stopwatch.seconds))
        finish_dataset(root)
        views = Dataset.open(root).views()
        rows = [*_sizes(views), *_times(stages), *_reading(Dataset.open(root), views)]
    size = f"{options.width}x{options.height} px"
    return report(f"Files and times of a stereo view of {size}", rows, options.json_file, scene=repr(scene))


def _sizes(views: tuple[StoredView, ...]) -> list[Row]:
    names = sorted({path.name for view in views for path in view.folder.iterdir()})
    sizes = {name: mean((view.folder / name).stat().st_size for view in views) / 1e6 for name in names}
    whole = sum(sizes[name] for name in ALWAYS)
    rows = [
        Row(name, size, "MB", note="every view" if name in ALWAYS else "on request") for name, size in sizes.items()
    ]
    rows.append(Row("every view", whole, "MB", bound=MOST_BYTES, ok=whole <= MOST_BYTES))
    rows.append(Row("all files", sum(sizes.values()), "MB"))
    return rows


def _times(stages: list[dict[str, float]]) -> list[Row]:
    """Return the seconds of a view by stage, as means without the first view, and their fractions."""
    last, first, count = stages[-1], stages[0], len(stages) - 2
    names = ("picture", "denoise", "geometry", "refraction", "labels")
    seconds = {name: (stages[-2].get(name, 0.0) - first.get(name, 0.0)) / max(count, 1) for name in names}
    # The first view's files are written after its entry was made.
    before = stages[1] if len(stages) > 2 else {}
    for name in ("writing", "checking"):
        seconds[name] = (last[name] - before.get(name, 0.0)) / max(count, 1)
    picture = seconds["picture"] + seconds["denoise"]
    made = sum(seconds[name] for name in ("geometry", "refraction", "labels", "writing"))
    whole = sum(seconds.values())
    rows = [Row(name, value, "s") for name, value in seconds.items()]
    rows.append(_fraction("labels and files, of the pictures", made / picture, MOST_LABELS))
    rows.append(_fraction("checks, of the view", seconds["checking"] / whole, MOST_CHECKS))
    return rows


def _fraction(name: str, value: float, bound: float) -> Row:
    return Row(name, value, bound=bound, ok=value <= bound)


def _reading(data: Dataset, views: tuple[StoredView, ...]) -> list[Row]:
    objects = data.scenes[0].objects()
    size = views[0].picture().shape[:2]

    def sample(view: StoredView) -> None:
        for eye in EYES:
            view.picture(eye)
        read_ground_truth(view, objects, (size[0], size[1]))

    kinds: dict[str, Callable[[StoredView], object]] = {
        "reading a training sample": sample,
        "reading all of the left camera's geometry": lambda view: view.geometry(),
        "reading layers": lambda view: view.layers(),
        "reading refracted rays": lambda view: view.refraction(),
    }
    rows = []
    for name, read in kinds.items():
        took = median(_milliseconds(read, view) for view in views for _ in range(REPEATS))
        bound = MOST_READING if read is sample else None
        rows.append(Row(name, took, "ms CPU", bound=bound, ok=None if bound is None else took <= bound))
    return rows


def _milliseconds(read: Callable[[StoredView], object], view: StoredView) -> float:
    begun = process_time()
    read(view)
    return 1e3 * (process_time() - begun)


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
