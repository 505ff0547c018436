"""Time and memory of training and inference, of the corrected and the released network, and of the data loader.

python bench/learn.py [--rounds 2] [--threads 1] [--data DIR] [--json FILE]

Each round starts a process for each network, which takes one warm-up step and then `--steps` measured steps, at
640 x 480 with 2 views and one sample. Memory is the peak resident size of the process.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import torch
from command import Output, run
from table import Row, report

import glassware as gw
from glassware.core.randomness import stream
from glassware.learn import NetworkSettings, build_network
from glassware.learn.data.loading import load_batches
from glassware.learn.data.samples import SampleDataset
from glassware.learn.data.settings import AugmentSettings, ViewSettings
from glassware.learn.targets.encoding import CORRECTED
from glassware.learn.training.loss_weights import LossWeights
from glassware.learn.training.losses import losses, total_loss

HEIGHT, WIDTH, VIEWS = 480, 640, 2
DEPTH_RANGE = (0.25, 3.0)
#: Targets: least speed relative to the released network, greatest fraction of its memory, and least speed of the data
#: loader relative to the network.
FASTER, MEMORY, LOADER = 2.0, 0.6, 5.0


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """What to measure."""

    rounds: int = 2
    """Processes of each network, alternating; each figure is the least of them."""
    steps: int = 2
    """Measured steps of a process."""
    threads: int = torch.get_num_threads()
    """Threads of PyTorch."""
    data: Path | None = None
    """Data set at 640 x 480; by default one is rendered."""
    only: str | None = None
    """Internal: the measurement of a child process."""


def main(given: Options) -> int:
    """Measure and print; 1 where a bound is broken."""
    if given.only:
        torch.set_num_threads(given.threads)
        sys.stdout.write(json.dumps(_job(given.only, given.steps)) + "\n")
        return 0
    found: dict[str, list[dict[str, float]]] = {}
    for _ in range(given.rounds):
        for job in ("reference", "corrected", "recompute", "float32", "bfloat16", "compiled"):
            found.setdefault(job, []).append(_child(job, given))
    best = {job: {key: min(run[key] for run in runs) for key in runs[0]} for job, runs in found.items()}
    rows = _training(best["reference"], best["corrected"], "corrected")
    rows += _training(best["reference"], best["recompute"], "corrected, recompute: features")[1::2]
    rows += _inference(best)
    rows += _loading(given, best["corrected"]["seconds"])
    facts = {"size": f"{WIDTH} x {HEIGHT}, {VIEWS} views, 1 sample", "rounds": given.rounds, "threads": given.threads}
    return report("training, inference and loading", rows, given.json_file, **facts, torch=torch.__version__)


def _child(job: str, given: Options) -> dict[str, float]:
    command = [sys.executable, __file__, "--only", job, "--steps", str(given.steps), "--threads", str(given.threads)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def _training(reference: dict[str, float], corrected: dict[str, float], name: str) -> list[Row]:
    faster = reference["seconds"] / corrected["seconds"]
    fraction = corrected["peak"] / reference["peak"]
    return [
        Row("training step, released", reference["seconds"], "s"),
        Row(
            f"training step, {name}",
            corrected["seconds"],
            "s",
            peer=reference["seconds"],
            ratio=faster,
            bound=reference["seconds"] / FASTER,
            ok=faster >= FASTER,
        ),
        Row("peak memory, released", reference["peak"], "GB"),
        Row(
            f"peak memory, {name}",
            corrected["peak"],
            "GB",
            peer=reference["peak"],
            ratio=1.0 / fraction,
            bound=MEMORY * reference["peak"],
            ok=fraction <= MEMORY,
        ),
    ]


def _inference(best: dict[str, dict[str, float]]) -> list[Row]:
    plain = best["float32"]["seconds"]
    rows = [Row("inference, float32", plain, "s")]
    for job, name in (("bfloat16", "bfloat16"), ("compiled", "torch.compile")):
        seconds = best[job]["seconds"]
        if seconds < 0.0:
            rows.append(Row(f"inference, {name}", None, "s", note="no C++ compiler on this machine"))
        else:
            rows.append(Row(f"inference, {name}", seconds, "s", peer=plain, ratio=plain / seconds))
    return rows


def _loading(given: Options, step: float) -> list[Row]:
    with tempfile.TemporaryDirectory() as folder:
        data = given.data or _rendered(Path(folder))
        samples = SampleDataset(data, "all", ViewSettings(count=VIEWS), CORRECTED, augment=AugmentSettings())
        order = [[(index % len(samples), index // len(samples))] for index in range(24)]
        batches = load_batches(samples, order, 2)
        next(batches)
        start = perf_counter()
        count = sum(1 for _ in batches)
        seconds = (perf_counter() - start) / count
    return [
        Row(
            "a sample from the loader, 2 workers",
            seconds,
            "s",
            bound=step / LOADER,
            ratio=step / seconds,
            ok=step / seconds >= LOADER,
            note="ratio: to a training step",
        )
    ]


def _rendered(folder: Path) -> Path:
    picture = {"spp": 1, "layers": 0, "refraction": False, "light": "path"}
    cameras = {"views": VIEWS + 1, "width": WIDTH, "height": HEIGHT}
    scene = gw.draw(seed=7, cameras=cameras, picture=picture)
    gw.write(folder / "data", scene, gw.Renderer(scene))
    return folder / "data"


def _job(job: str, steps: int) -> dict[str, float]:
    torch.manual_seed(0)
    variants = {"reference": {"variant": "reference"}, "corrected": {}, "recompute": {"recompute": "features"}}
    if job in variants:
        settings = NetworkSettings.model_validate({"depth_range": DEPTH_RANGE, **variants[job]})
        seconds = _steps(settings, steps)
    else:
        seconds = _forward(job, steps)
    # Linux reports kilobytes.
    return {"seconds": seconds, "peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9}


def _inputs() -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    images = torch.from_numpy(stream(0, 0, "bench/learn").uniform(0.0, 1.0, (1, VIEWS, 3, HEIGHT, WIDTH))).float()
    poses = torch.eye(4).repeat(1, VIEWS, 1, 1)
    poses[0, 1, 0, 3] = 0.1
    K = torch.tensor([[614.0, 0.0, 319.5], [0.0, 614.0, 239.5], [0.0, 0.0, 1.0]]).repeat(1, VIEWS, 1, 1)
    return images, poses, K


def _targets() -> dict[str, torch.Tensor]:
    cells, size = (1, HEIGHT // 8, WIDTH // 8), (1, HEIGHT, WIDTH)
    fields = {"vertex": torch.zeros(1, 16, *cells[1:]), "covariance": torch.zeros(1, 6, *cells[1:])}
    whole = {"depth": torch.ones(size), "heatmap": torch.zeros(size), "seg": torch.zeros(size, dtype=torch.int64)}
    masks = {"object_mask": torch.ones(size, dtype=torch.bool), "cell_mask": torch.ones(cells, dtype=torch.bool)}
    return {**fields, **whole, **masks, "offset": torch.zeros(1, 2, HEIGHT, WIDTH), "z_centroid": torch.zeros(cells)}


def _steps(settings: NetworkSettings, count: int) -> float:
    net, inputs, targets, weights = build_network(settings), _inputs(), _targets(), LossWeights()
    optimiser = torch.optim.Adam(net.parameters(), lr=1e-6)
    start = 0.0
    for step in range(count + 1):
        if step == 1:
            start = perf_counter()
        loss = total_loss(losses(net(*inputs), targets, settings), weights)
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        optimiser.step()
        del loss
    return (perf_counter() - start) / count


def _forward(job: str, count: int) -> float:
    net = build_network(NetworkSettings(depth_range=DEPTH_RANGE)).eval()
    run = torch.compile(net) if job == "compiled" else net
    inputs, start = _inputs(), 0.0
    with torch.inference_mode(), torch.autocast("cpu", torch.bfloat16, enabled=job == "bfloat16"):
        for step in range(count + 1):
            if step == 1:
                start = perf_counter()
            try:
                run(*inputs)
            except torch._inductor.exc.InductorError:  # pyright: ignore - raised where there is no C++ compiler
                return -1.0
    return (perf_counter() - start) / count


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
