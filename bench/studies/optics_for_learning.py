"""What in the light of pictures a network learns from: one network for each simplification of the renderer.

    python bench/studies/optics_for_learning.py --out study [--real KEYPOSE] [--scenes 60] [--steps 1000]
    python bench/studies/optics_for_learning.py --out study --table

The same scenes, of one vessel each, are rendered again and again, each time with one thing simplified. On each data set
the same small network for stereo pairs is trained with the same seeds, samples and steps. All are tested on other
scenes in full light, and on real pairs of KeyPose where their folder is given. What is done already in OUT is not done
again, so the command goes on where it was stopped. Each run uses one thread.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, stdev
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[1]))
from command import run, seconds_of

from glassware.core.errors import InputError

#: What is simplified: settings of the data set on top of `SCENES`, and what it stands for.
VARIANTS: Mapping[str, tuple[str, dict[str, Any]]] = {
    "full": ("full light", {}),
    "gap": ("a film of air between glass and liquid", {"picture": {"air_gap": True}}),
    "opaque": ("painted vessels", {"twin": "opaque"}),
    "straight": ("no refraction, no reflection", {"picture": {"refractivity": 0.0}}),
    "index": ("half of the index less one", {"picture": {"refractivity": 0.5}}),
    "shadows": ("no caustics, no shadows of glass", {"picture": {"glass_shadows": False}}),
    "camera": ("an ideal camera", {"picture": {"camera": "ideal"}}),
}
#: One vessel, most often with a liquid, seen by a narrow stereo camera that is as wide as KeyPose's windows.
SCENES: Mapping[str, Any] = {
    "vessels": {"fill_probability": 0.8, "categories": ["tumbler", "beaker", "bottle", "stem glass", "bowl", "mug"]},
    "cameras": {"width": 96, "height": 64, "fov": 0.5585, "views": 10},
    "picture": {"light": "path", "spp": 12, "fireflies": "remove", "camera": "d435", "layers": 4, "refraction": False},
}
#: Seeds of the scenes to train on, and of those to test on.
TRAIN_SEED, TEST_SEED = 71, 72
#: The network that a processor trains at ten samples a second, and its training.
TRAINING: Mapping[str, Any] = {
    "network": {
        "planes": 32,
        "spacing": "inverse",
        "matching": "group",
        "feature_width": 24,
        "feature_blocks": [2, 3, 2, 2],
        "volume_channels": 12,
        "context": "resnet18",
        "context_width": 24,
        "decoder_width": 32,
        "backbone_width": 32,
    },
    "views": {"count": 2, "rule": "stereo", "size": [64, 96]},
    "losses": {"huber": 0.01, "depth": 30.0, "small_depth": 10.0, "heatmap": 200.0, "covariance": 0.5},
    "optimiser": {"learning_rate": 0.002, "warmup": 60, "schedule": "cosine", "ema": 0.99},
    "machine": {"accelerator": "cpu", "precision": "auto", "threads": 1, "workers": 1},
    "batch": 4,
    "val_split": "none",
    "save_every": 200,
}
#: Figures of a report: heading, where it stands, factor, digits.
FIGURES = (
    ("depth on glass, MAE [mm]", ("depth", "full", "transparent", "mae"), 1e3, 1),
    ("within 5 %", ("depth", "full", "transparent", "delta_105"), 1.0, 3),
    ("found", ("pose", "found"), 1.0, 3),
    ("3D AP25", ("boxes", "ap25"), 1.0, 3),
    ("mask AP50", ("masks", "ap50"), 1.0, 3),
    ("mask IoU", ("masks", "iou_all"), 1.0, 3),
    ("translation, median [mm]", ("pose", "translation_median"), 1e3, 1),
)


@dataclass(frozen=True, kw_only=True)
class Options:
    """What to run."""

    out: Path
    """Folder of data sets and runs."""
    only: tuple[str, ...] = tuple(VARIANTS)
    """Names of the variants."""
    seeds: tuple[int, ...] = (0, 1, 2)
    """Seeds of the networks, one run each."""
    scenes: int = 60
    """Scenes to train on; a third as many are tested on."""
    steps: int = 1000
    """Training steps of four samples."""
    real: Path | None = None
    """Folder of real frames of KeyPose."""
    table: bool = False
    """Print the results of finished runs instead."""


def main(given: Options) -> int:
    """Build, train and test, or print the results."""
    for name in given.only:
        if name not in VARIANTS:
            raise InputError("--only", "names of " + ", ".join(VARIANTS), name)
    if not given.table:
        test = _built(given, "test", {}, TEST_SEED, max(1, given.scenes // 3))
        for seed in given.seeds:
            for name in given.only:
                data = _built(given, name, VARIANTS[name][1], TRAIN_SEED, given.scenes)
                _trained(given, name, data, test, seed)
    sys.stdout.write(table(given))
    return 0


def _built(given: Options, name: str, changes: Mapping[str, Any], seed: int, scenes: int) -> Path:
    """Return a data set, built where it is not there as a whole."""
    out, done = given.out / f"data-{name}", given.out / f"data-{name}.json"
    if not done.exists():
        given.out.mkdir(parents=True, exist_ok=True)
        settings = dict(SCENES) | {key: value for key, value in changes.items() if key != "picture"}
        settings["picture"] = {**SCENES["picture"], **changes.get("picture", {})}
        config = given.out / f"data-{name}.yaml"
        config.write_text(json.dumps(settings, indent=1))  # JSON is YAML
        command = ["build-dataset", "--preset", "keypose", "--config", config, "--seed", seed]
        command += ["--scenes", f"0:{scenes}", "--workers", 1, "--out", out]
        spent = seconds_of(command, given.out / f"data-{name}.txt", allowed=(0, 1))  # 1: a scene failed, and is listed
        done.write_text(json.dumps({"seconds": spent}))
    return out


def _trained(given: Options, name: str, data: Path, test: Path, seed: int) -> None:
    """Train and test a network where that is not done."""
    folder = given.out / f"{name}-{seed}"
    if (folder / "seconds.json").exists():
        return
    folder.mkdir(parents=True, exist_ok=True)
    config, weights = folder / "run.yaml", folder / "run" / "last.safetensors"
    config.write_text(json.dumps({**TRAINING, "seed": seed, "steps": given.steps}, indent=1))
    train = ["glassware", "train", data, "--config", config, "--out", folder / "run"]
    spent = seconds_of([*train, *(["--resume", weights] if weights.exists() else [])], folder / "train.txt")
    score = ["glassware", "evaluate", weights, test, "--split", "all", "--out", folder / "report"]
    seconds_of([*score, "--worst", "4", "--workers", "0", "--threads", "1"], folder / "evaluate.txt")
    if given.real is not None:
        script = Path(__file__).resolve().parents[1] / "real_pictures.py"
        seconds_of(["python", script, weights, given.real, "--out", folder / "real"], folder / "real.txt")
    (folder / "seconds.json").write_text(json.dumps({"train": spent}))


def table(given: Options) -> str:
    """Return the figures of the finished runs, mean and deviation over seeds, in Markdown."""
    heads = [head for head, *_ in FIGURES] + (["real pairs: mask IoU"] if given.real else [])
    lines = [f"| pictures | seeds | steps | {' | '.join(heads)} |", "|---" * (3 + len(heads)) + "|"]
    for name in given.only:
        folders = [path.parent for path in sorted(given.out.glob(f"{name}-*/seconds.json"))]
        if folders:
            steps = json.loads((folders[0] / "run.yaml").read_text())["steps"]
            lines.append(f"| {VARIANTS[name][0]} | {len(folders)} | {steps} | {' | '.join(_cells(given, folders))} |")
    return "\n".join(lines) + "\n"


def _cells(given: Options, folders: list[Path]) -> Iterator[str]:
    reports = [json.loads((folder / "report" / "report.json").read_text()) for folder in folders]
    for _, path, factor, digits in FIGURES:
        yield _cell([_value(report, path) for report in reports], factor, digits)
    if given.real is not None:
        yield _cell([_real_iou(folder) for folder in folders], 1.0, 3)


def _value(report: Any, path: tuple[str, ...]) -> float | None:
    for key in path:
        report = report[key]
    return report


def _real_iou(folder: Path) -> float | None:
    """Return the mean overlap with the true mask over real frames, in windows where weights know a focal length."""
    path = folder / "real" / "report.json"
    if not path.exists():
        return None
    ways = json.loads(path.read_text())["ways"]
    return mean(frame["mask_iou"] for frame in ways.get("windows x 1", ways["whole"]).values())


def _cell(values: list[float | None], factor: float, digits: int) -> str:
    known = [factor * value for value in values if value is not None]
    if not known:
        return "-"
    spread = f" ± {stdev(known):.{digits}f}" if len(known) > 1 else ""
    return f"{mean(known):.{digits}f}{spread}"


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
