"""Networks that differ in one thing, trained and evaluated by the commands: the runs behind docs/results.md.

A study: it backs the table "Runs" of docs/results.md, last run 2026-11-25. It is not maintained beyond importing.

    python bench/studies/experiments.py --pairs PAIRS --near NEAR --out OUT [--only base linear ...] [--steps 400]
    python bench/studies/experiments.py --pairs PAIRS --near NEAR --out OUT --table

PAIRS is a data set for stereo pairs, NEAR one whose cameras stand near each other, for two views and more.

A run goes to OUT/NAME-SEED and is skipped where that folder exists, so several processes can work side by side. Each
uses one thread. All train on the data set's split `train` and are evaluated on `test`.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from statistics import mean, stdev
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[1]))
from command import run, seconds_of

from glassware.core.errors import InputError

#: Height and width of the pictures [px]: half of the preset `fast`, rounded to multiples of 32.
SIZE = (128, 160)
#: A network that a processor trains at 8 samples a second, and how it is trained.
SMALL = {
    "planes": 24,
    "spacing": "inverse",
    "matching": "group",
    "feature_width": 16,
    "feature_blocks": [2, 3, 2, 2],
    "volume_channels": 8,
    "context": "resnet18",
    "context_width": 32,
    "decoder_width": 32,
    "backbone_width": 32,
}
#: Weights of the losses that let depth count beside the fields; why Huber's bound is small: `LossWeights`.
LOSSES = {"huber": 0.01, "depth": 30.0, "small_depth": 10.0}
#: Greatest learning rate of the small networks. (Depth off by 59 mm after 500 steps, by 64 with the paper's 6e-4: one
#: seed, tried by hand.)
RATE = 2e-3
#: The views of a sample: a stereo pair, or the nearest cameras.
PAIR: Mapping[str, Any] = {"count": 2, "rule": "stereo"}
TWO, THREE, FIVE = ({"count": count, "rule": "distance", "pool": 4} for count in (2, 3, 5))


@dataclass(frozen=True)
class Experiment:
    """What sets a run apart."""

    network: Mapping[str, Any]
    views: Mapping[str, Any] = field(default_factory=lambda: PAIR)
    losses: Mapping[str, float] = field(default_factory=lambda: LOSSES)
    rate: float = RATE
    steps_fraction: float = 1.0  #: of the steps


EXPERIMENTS = {
    "base": Experiment(SMALL),
    "linear": Experiment(SMALL | {"spacing": "linear"}),
    "concat": Experiment(SMALL | {"matching": "concat"}),
    "windowed": Experiment(SMALL | {"readout": "windowed"}),
    "two": Experiment(SMALL, TWO),
    "three": Experiment(SMALL, THREE),
    "five": Experiment(SMALL, FIVE),
    "visibility": Experiment(SMALL | {"fusion": "visibility"}, FIVE),
    # The networks as large as the paper's, with the released weights of losses and the paper's rate. A step takes five
    # to nine times as long.
    "corrected": Experiment({}, losses={}, rate=6e-4, steps_fraction=0.3),
    "released": Experiment({"variant": "reference"}, losses={}, rate=6e-4, steps_fraction=0.3),
}
#: Figures of a report that are shown: heading, and where it stands.
FIGURES = {
    "MAE [mm]": ("depth", "full", "objects", "mae"),
    "transparent": ("depth", "full", "transparent", "mae"),
    "opaque": ("depth", "full", "opaque", "mae"),
    "all pixels": ("depth", "full", "all", "mae"),
    "1.10": ("depth", "full", "objects", "delta_110"),
    "3D AP25": ("boxes", "ap25"),
    "3D IoU all": ("boxes", "iou_all"),
    "mask IoU": ("masks", "iou_all"),
    "found": ("pose", "found"),
}


@dataclass(frozen=True, kw_only=True)
class Options:
    """What to run."""

    pairs: Path
    """Data set for stereo pairs."""
    near: Path
    """Data set whose cameras stand near each other."""
    out: Path
    """Folder of the runs."""
    only: tuple[str, ...] = tuple(EXPERIMENTS)
    """Names of the experiments."""
    seeds: tuple[int, ...] = (0, 1, 2)
    """Seeds, one run each."""
    steps: int = 400
    """Training steps."""
    table: bool = False
    """Print the results of finished runs instead."""


def main(given: Options) -> int:
    """Train and evaluate, or print the results."""
    for name in given.only:
        if name not in EXPERIMENTS:
            raise InputError("--only", "names of " + ", ".join(EXPERIMENTS), name)
    if given.table:
        sys.stdout.write(table(given))
        return 0
    for seed in given.seeds:
        for name in given.only:
            _run(name, seed, given)
    return 0


def settings_of(name: str, seed: int, steps: int) -> dict[str, Any]:
    """Return the settings of a run, as the command takes them."""
    experiment = EXPERIMENTS[name]
    return {
        "network": dict(experiment.network),
        "views": {**experiment.views, "size": list(SIZE)},
        "losses": dict(experiment.losses),
        "machine": {"accelerator": "cpu", "threads": 1, "workers": 1, "precision": "auto"},
        "optimiser": {"warmup": 50, "learning_rate": experiment.rate},
        "seed": seed,
        "steps": round(steps * experiment.steps_fraction),
        "batch": 4,
        "val_split": "none",
        "log_every": 50,
        "pictures_every": 10_000,
        "save_every": 10_000,
    }


def _run(name: str, seed: int, given: Options) -> None:
    folder = given.out / f"{name}-{seed}"
    data = given.pairs if EXPERIMENTS[name].views is PAIR else given.near
    given.out.mkdir(parents=True, exist_ok=True)
    try:
        folder.mkdir()
    except FileExistsError:
        return
    config = folder / "run.yaml"
    config.write_text(json.dumps(settings_of(name, seed, given.steps), indent=1))  # JSON is YAML
    train = ["glassware", "train", data, "--config", config, "--out", folder / "run"]
    score = ["glassware", "evaluate", folder / "run" / "last.safetensors", data, "--split", "test", "--out", folder]
    spent = {
        "train": seconds_of(train, folder / "train.txt"),
        "evaluate": seconds_of([*score, "--worst", "4", "--workers", "0", "--threads", "1"], folder / "evaluate.txt"),
    }
    (folder / "seconds.json").write_text(json.dumps(spent))
    sys.stdout.write(f"{name}-{seed}: {spent}\n")
    sys.stdout.flush()


def table(given: Options) -> str:
    """Return the figures of the finished runs, mean and deviation over seeds, in Markdown."""
    lines = ["| | seeds | steps | CPU min | " + " | ".join(FIGURES) + " |", "|---" * (4 + len(FIGURES)) + "|"]
    for name in given.only:
        folders = [path.parent for path in sorted(given.out.glob(f"{name}-*/seconds.json"))]
        if not folders:
            continue
        reports = [json.loads((folder / "report.json").read_text()) for folder in folders]
        minutes = mean(json.loads((folder / "seconds.json").read_text())["train"] for folder in folders) / 60.0
        steps = json.loads((folders[0] / "run.yaml").read_text())["steps"]
        cells = [_cell([_figure(report, path) for report in reports], path[-1]) for path in FIGURES.values()]
        lines.append(f"| {name} | {len(folders)} | {steps} | {minutes:.1f} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _figure(report: Mapping[str, Any], path: tuple[str, ...]) -> float | None:
    value: Any = report
    for key in path:
        value = value[key]
    return value


def _cell(values: list[float | None], name: str) -> str:
    known = [value for value in values if value is not None]
    if len(known) < len(values) or not known:
        return "-"
    scale, digits = (1000.0, 1) if name == "mae" else (1.0, 3)
    spread = f" ± {scale * stdev(known):.{digits}f}" if len(known) > 1 else ""
    return f"{scale * mean(known):.{digits}f}{spread}"


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
