"""Builds of many scenes: how fast two workers are, where the time goes, and whether memory stays flat.

    python bench/build.py --parts start speed memory index
    python bench/build.py --parts stages --scenes 2 --preset standard

Parts: `start`, of a worker process; `speed`, two workers on two cores against one on one core; `stages`, shares of the
time of a preset; `memory`, of build and workers from scene 20 to the last of `--many`; `index`, of 2,000 scenes x 57
views. A part builds into a temporary folder by the command itself, as a process of its own.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import threading
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, median
from time import perf_counter, sleep
from typing import Literal

import cv2
import numpy as np
from command import Output, run
from rich.console import Console
from table import Row, report

Part = Literal["start", "speed", "stages", "memory", "index"]

#: Longest start of a worker [s]; least gain of two workers on two cores; most time for all but light; most growth of
#: memory; longest opening and listing of an index of 2,000 scenes [s].
START, GAIN, OVERHEAD, GROWTH, LISTING = 3.0, 1.7, 0.25, 0.05, 1.0
#: Stages that make pictures: paths, stored light, and the denoiser.
_LIGHT = ("picture", "light", "denoise")
#: Scenes that are left out while caches fill, and scenes at each end that are averaged.
_WARM, _WINDOW = 20, 30
#: How often the memory of a build is read [s].
_PULSE = 0.2
_BUILD = [sys.executable, "-P", "-m", "glassware.dataset.commands.build_dataset"]
#: Settings of scenes that take half a second: a small environment map is neither baked nor slow to read.
_TINY = """vessel_count: [1, 1]
prop_count: [0, 1]
vessels: {{chord_error: 1.0e-4, fill_probability: 0.5}}
environment: {{hdri_dir: {folder}, hdri_share: 1.0}}
cameras: {{width: 16, height: 12, views: 1}}
picture: {{spp: 1}}
"""
#: Opens and lists a data set in a process of its own, and prints the seconds.
_LIST = """
import sys, time
from pathlib import Path
from glassware.dataset.reader import Dataset
start = time.perf_counter()
data = Dataset.open(Path(sys.argv[1]))
scenes, rows = len(data.scenes), data.index(["scene_id", "view", "path", "left"]).num_rows
print(time.perf_counter() - start, scenes, rows)
"""


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """What to measure."""

    parts: tuple[Part, ...] = ("start", "speed", "memory", "index")
    """Which figures."""
    preset: str = "fast"
    """Preset of `speed` and `stages`."""
    scenes: int = 6
    """Scenes of `speed` and `stages`."""
    many: int = 300
    """Scenes of `memory`."""
    seed: int = 1
    """Seed of all scenes."""


def main(options: Options) -> int:
    """Measure and print."""
    parts = {"start": _start, "speed": _speed, "stages": _stages, "memory": _memory, "index": _index}
    rows: list[Row] = []
    for name in options.parts:
        Console(stderr=True).print(f"{name} ...", highlight=False)
        rows += parts[name](options)
    return report("Builds of many scenes", rows, options.json_file, seed=options.seed, preset=options.preset)


def _start(options: Options) -> list[Row]:
    from glassware.dataset.builds.local_executor import LocalExecutor
    from glassware.dataset.builds.manifest import Manifest
    from glassware.dataset.builds.messages import WorkerConfig
    from glassware.procedural.scene.settings import SceneSettings

    config = WorkerConfig(root=Path.cwd(), seed=options.seed, settings=SceneSettings(), manifest=Manifest(), threads=1)
    seconds = []
    for _ in range(5):
        start = perf_counter()
        with LocalExecutor(config, workers=1, max_tasks_per_child=1, timeout=60.0) as executor:
            executor.worker_info()
            seconds.append(perf_counter() - start)
    return [_at_most("start of a worker, median of 5", median(seconds), "s", START, f"worst {max(seconds):.2f} s")]


def _speed(options: Options) -> list[Row]:
    """Build the same scenes in turns: one worker on one core, two on two, and the other way round."""
    cores = sorted(os.sched_getaffinity(0))[:2]
    rates: dict[int, list[float]] = {1: [], 2: []}
    work: dict[int, list[float]] = {1: [], 2: []}
    for workers in (1, 2, 2, 1):
        with tempfile.TemporaryDirectory() as folder:
            pinned = ["taskset", "-c", ",".join(map(str, cores[:workers]))]
            given = ["--preset", options.preset, "--workers", str(workers)]
            before = _cpu_seconds()
            seconds, log = _built(options, Path(folder, "data"), options.scenes, given, pinned)
            rates[workers].append(3600.0 * len(log) / seconds)
            work[workers].append((_cpu_seconds() - before) / len(log))
    one, two = mean(rates[1]), mean(rates[2])
    told = ", ".join(f"{rate:.0f}" for rate in rates[2])
    rows = [Row("scenes an hour, one worker on one core", one, note=", ".join(f"{rate:.0f}" for rate in rates[1]))]
    rows.append(Row("scenes an hour, two workers on two cores", two, note=told))
    rows.append(Row("gain of the second", two / one, bound=GAIN, ratio=two / one / GAIN, ok=two / one >= GAIN))
    told = f"{mean(work[1]):.1f} s with one, {mean(work[2]):.1f} s with two: does not depend on other programs"
    return [*rows, Row("CPU time a scene, one worker over two", mean(work[1]) / mean(work[2]), note=told)]


def _cpu_seconds() -> float:
    """Return the CPU time of all builds that have ended, with their workers."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _stages(options: Options) -> list[Row]:
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder, "data")
        given = ["--preset", options.preset, "--workers", "2"]
        seconds, log = _built(options, root, options.scenes, given)
        start = perf_counter()
        verify = [sys.executable, "-P", "-m", "glassware.dataset.commands.verify", str(root)]
        subprocess.run(verify, check=True, capture_output=True)
        verified = perf_counter() - start
        size = sum(path.stat().st_size for path in root.rglob("*") if path.is_file())
    sums: dict[str, float] = defaultdict(float)
    for line in log:
        for stage, value in line["seconds"].items():
            sums[stage] += value
    # What the workers did besides scenes: their start, and waiting for the last scene of the other one.
    sums["start, waiting, index"] = max(0.0, 2.0 * seconds - sum(sums.values()))
    sums["verification"] = verified
    total, views = sum(sums.values()), sum(line["views"] for line in log)
    rows = [Row(name, value / total, note=f"{value / len(log):.2f} s a scene") for name, value in sums.items()]
    rows.sort(key=lambda row: -(row.measured or 0.0))
    rest = 1.0 - sum(sums[stage] for stage in _LIGHT) / total
    rows.append(_at_most("all but light and denoiser", rest, "", OVERHEAD, ""))
    rows.append(Row("scenes", float(len(log)), note=f"{views} stereo views, {seconds:.0f} s, {size / 1e6:.0f} MB"))
    rows.append(Row("core seconds a stereo view", 2.0 * seconds / views, "s"))
    return rows


def _memory(options: Options) -> list[Row]:
    """Build many tiny scenes; compare what build and workers hold at the start and in the end."""
    parent: list[tuple[float, float]] = []
    with tempfile.TemporaryDirectory() as folder:
        given = ["--config", str(_tiny_settings(Path(folder))), "--workers", "2"]
        seconds, log = _built(options, Path(folder, "data"), options.many, given, watched=parent)
    early = [line["resident"] for line in log[_WARM : _WARM + _WINDOW]]
    late = [line["resident"] for line in log[-_WINDOW:]]
    # The parent by time: at the share of the build at which scene 20 was done, and at its end.
    after = _WARM / len(log) * parent[-1][0]
    begin = mean([size for at, size in parent if after <= at <= 2.0 * after])
    end = mean([size for at, size in parent if at >= parent[-1][0] - after])
    name = f"from scene {_WARM} to {len(log)}"
    grown = [line["resident"] for line in log if line["served"] > _WARM]
    return [
        _at_most(f"build, growth {name}", end / begin - 1.0, "", GROWTH, f"{begin:.0f} to {end:.0f} MB"),
        _at_most(
            f"workers, growth {name}",
            mean(late) / mean(early) - 1.0,
            "",
            GROWTH,
            f"{mean(early):.0f} to {mean(late):.0f} MB in the mean, at most {max(grown):.0f}",
        ),
        Row("memory of a worker, by scenes that it has served", _slope(log), "MB a scene", note="least squares"),
        Row("tiny scenes", float(len(log)), note=f"{seconds:.0f} s"),
    ]


def _tiny_settings(folder: Path) -> Path:
    """Write the settings of tiny scenes, and the environment map that lights them."""
    pixels = np.random.default_rng(1).uniform(0.5, 1.0, (8, 16, 3)).astype(np.float32)
    (folder / "hdri").mkdir()
    cv2.imwrite(str(folder / "hdri" / "plain.hdr"), pixels)
    path = folder / "tiny.yaml"
    path.write_text(_TINY.format(folder=folder / "hdri"), encoding="utf-8")
    return path


def _slope(log: Sequence[dict]) -> float:
    """Return the growth of a worker's memory per scene, after the first few."""
    points = [(line["served"], line["resident"]) for line in log if line["served"] > _WARM // 2]
    x, y = mean(at for at, _ in points), mean(size for _, size in points)
    return sum((at - x) * (size - y) for at, size in points) / max(1e-9, sum((at - x) ** 2 for at, _ in points))


def _index(options: Options) -> list[Row]:
    """Make the folders of 2,000 scenes x 57 views with the records of a real one; gather the index and list it."""
    from glassware.dataset.writer import finish_dataset

    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder, "data")
        _built(options, root, 1, ["--config", str(_tiny_settings(Path(folder)))])
        _multiplied(root, scenes=2000, views=57)
        start = perf_counter()
        views = finish_dataset(root)
        gathered, size = perf_counter() - start, (root / "views.parquet").stat().st_size
        told = subprocess.run(
            [sys.executable, "-P", "-c", _LIST, str(root)], check=True, capture_output=True, text=True
        )
        listed, scenes, rows = told.stdout.split()
    note = f"{scenes} scenes, {rows} views, read from the disk's cache"
    return [
        Row("gathering the index", gathered, "s", note=f"{views} views, {size / 1e6:.1f} MB"),
        _at_most("opening and listing", float(listed), "s", LISTING, note),
    ]


def _multiplied(root: Path, scenes: int, views: int) -> None:
    record = json.loads((root / "scenes/000000/views.json").read_text())
    row = record["views"][0]
    for scene in range(scenes):
        folder = root / "scenes" / f"{scene:06d}"
        rows = []
        for view in range(views):
            (folder / f"{view:03d}").mkdir(parents=True, exist_ok=True)
            path = f"scenes/{scene:06d}/{view:03d}"
            own = {"scene_id": scene, "view": view, "path": path, "left": f"{path}/left.png"}
            rows.append(row | own | {"right": f"{path}/right.png"})
        (folder / "views.json").write_text(json.dumps(record | {"views": rows}))


def _built(
    options: Options,
    root: Path,
    scenes: int,
    given: Sequence[str],
    before: Sequence[str] = (),
    watched: list[tuple[float, float]] | None = None,
) -> tuple[float, list[dict]]:
    """Build; return the seconds and the log's lines of scenes that were made."""
    command = [*before, *_BUILD, "--scenes", f"0:{scenes}", "--seed", str(options.seed), "--out", str(root), *given]
    start = perf_counter()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as child:
        if watched is not None:
            threading.Thread(target=lambda: watched.extend(_resident(child)), daemon=True).start()
        _, errors = child.communicate()
    if child.returncode:
        raise RuntimeError(f"the build ended with code {child.returncode}: {errors}")
    lines = [json.loads(line) for line in (root / "build.jsonl").read_text("utf-8").splitlines()]
    return perf_counter() - start, [line for line in lines if line["event"] == "scene" and line["state"] == "made"]


def _resident(child: subprocess.Popen) -> Iterator[tuple[float, float]]:
    """Go through the seconds and the memory of a process [MB] until it ends."""
    start, page = perf_counter(), os.sysconf("SC_PAGE_SIZE")
    while child.poll() is None:
        try:
            pages = int(Path(f"/proc/{child.pid}/statm").read_text().split()[1])
        except OSError:
            return
        if pages:
            yield perf_counter() - start, pages * page / 1e6
        sleep(_PULSE)


def _at_most(name: str, measured: float, unit: str, bound: float, note: str) -> Row:
    return Row(name, measured, unit, bound=bound, ratio=measured / bound, ok=measured <= bound, note=note)


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
