"""Size of each file of a stereo view with its labels, and the time for making, writing, checking and reading them.

    python bench/labels.py
    python bench/labels.py --preset standard --views 3 --json labels.json

A scene is drawn and rendered once with every file. Labels are what is traced and computed beside the two pictures:
geometry, layers, refracted rays, the right camera's, and the maps. The first view compiles, so it is left out. Times
are those of all threads on the processor: other work on the machine changes them little.
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

from glassware.annotate.keypoints import scene_keypoints
from glassware.annotate.labels import label
from glassware.core.stopwatch import Stopwatch
from glassware.dataset.format import layout
from glassware.dataset.format.dataset_file import installed_versions, new_head
from glassware.dataset.format.file_kinds import KINDS
from glassware.dataset.pipeline import pair_labels, requested_mattes
from glassware.dataset.reader import Dataset
from glassware.dataset.settings.draw import draw
from glassware.dataset.stored_view import StoredView
from glassware.dataset.verification.scene import check_written
from glassware.dataset.writer import finish_dataset, scene_writer, start_dataset, write_view
from glassware.learn.data.ground_truth import read_ground_truth
from glassware.render.frame import EYES
from glassware.render.labels.geometry import trace_straight
from glassware.render.labels.refraction import trace_refraction
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
        root = Path(name, "data")
        renderer = Renderer(scene)
        head = new_head("bench", scene.seed, {}, installed_versions(), renderer.variant, files=KINDS)
        start_dataset(root, head, [0])
        seconds = _written(root, renderer)
        finish_dataset(root)
        views = Dataset.open(root).views()
        rows = [*_sizes(views), *_times(seconds), *_reading(Dataset.open(root), views)]
    size = f"{options.width}x{options.height} px"
    return report(f"Files and times of a stereo view of {size}", rows, options.json_file, scene=repr(scene))


def _written(root: Path, renderer: Renderer) -> dict[str, float]:
    """Render, label, write and check all views, as `pipeline.write_scene` does; return seconds of a view by stage."""
    scene, points = renderer.scene, scene_keypoints(renderer.scene)
    stopwatch = Stopwatch(process_time)
    with scene_writer(root, scene, points, files=KINDS) as writer:
        for view, camera in enumerate(scene.cameras):
            if view == 1:  # the first one has compiled
                stopwatch = Stopwatch(process_time)
            with stopwatch.stage("frame"):
                frame = renderer.frame(view)
            # These two are part of the frame: they are made again, to be counted apart.
            with stopwatch.stage("geometry"):
                trace_straight(renderer.loaded, camera, scene.picture.layers)
            with stopwatch.stage("refraction"):
                trace_refraction(renderer.loaded, [camera])
            with stopwatch.stage("labels"):
                labels = label(scene, frame, renderer, points)
            with stopwatch.stage("right camera"):
                stereo = pair_labels(KINDS, frame, renderer, points)
            with stopwatch.stage("mattes"):
                mattes = requested_mattes(KINDS, frame, renderer)
            with stopwatch.stage("writing"):
                writer.add(frame, labels, stereo, mattes)
            folder = writer.folder / layout.view_name(view)
            with stopwatch.stage("checking"):
                check_written(StoredView(folder, view), scene, writer.records)
            with tempfile.TemporaryDirectory(prefix="glassware-bench-") as name:
                with stopwatch.stage("writing, by default"):
                    write_view(Path(name, "view"), scene, frame, labels, ())
                with stopwatch.stage("checking, by default"):
                    check_written(StoredView(Path(name, "view"), view), scene, writer.records)
    counted = max(len(scene.cameras) - 1, 1)
    return {name: value / counted for name, value in stopwatch.seconds.items()}


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


def _times(seconds: dict[str, float]) -> list[Row]:
    """Return the seconds of a view by stage, and their fractions."""
    traced = seconds["geometry"] + seconds["refraction"]
    pictures = seconds["frame"] - traced
    rows = [Row("pictures", pictures, "s CPU")]
    rows += [Row(name, value, "s CPU") for name, value in seconds.items() if name != "frame"]
    default = seconds["geometry"] + seconds["labels"] + seconds["writing, by default"]
    every = traced + seconds["labels"] + seconds["right camera"] + seconds["writing"]
    plain = seconds["frame"] - seconds["refraction"] + seconds["labels"] + seconds["writing, by default"]
    whole = pictures + every + seconds["mattes"]
    rows.append(_fraction("labels and files by default, of the pictures", default / pictures, MOST_LABELS))
    rows.append(_fraction("all labels and files but mattes, of the pictures", every / pictures, MOST_LABELS))
    rows.append(Row("mattes, of the pictures", seconds["mattes"] / pictures))
    rows.append(_fraction("checks by default, of the view", seconds["checking, by default"] / plain, MOST_CHECKS))
    rows.append(_fraction("checks of all files, of the view", seconds["checking"] / whole, MOST_CHECKS))
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
