"""Time and memory of training and inference, of all four networks, and of their data loaders.

python bench/learn.py [--rounds 2] [--threads 1] [--data DIR] [--only-networks] [--json FILE]

Each round starts a process for each network, which takes one warm-up step and then `--steps` measured steps, at
640 x 480 with 2 views and one sample. Memory is the peak resident size of the process. SimNet, KeyPose and DenseFusion
take a sample of the size that they were published with; beside the time of a step stand the published multiplications
and additions of a forward pass, three times which a step takes, and what part of this machine's peak that is.
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
from glassware.learn.data.samples import Batch
from glassware.learn.training.loss_weights import LossWeights
from glassware.learn.training.losses import losses, total_loss
from glassware.learn.training.methods import losses_of, outputs_of, samples_of, with_data, with_own_views
from glassware.learn.training.settings import TrainSettings

HEIGHT, WIDTH, VIEWS = 480, 640, 2
DEPTH_RANGE = (0.25, 3.0)
#: Targets: least speed relative to the released network, greatest fraction of its memory, and least speed of the data
#: loader relative to the network.
FASTER, MEMORY, LOADER = 2.0, 0.6, 5.0
#: Multiplications and additions of a forward pass as published or counted in the released code [1e9], and its size.
PUBLISHED = {
    "simnet": (38.7, "640 x 512"),
    "keypose": (6.04, "window of 180 x 120"),
    "densefusion": (6.8, "window of 80 x 80, 1,000 points"),
    "reference": (492.0, "640 x 480, 2 views"),
}
#: Passes that cost as much as a forward one in a training step: its own, and one for inputs and weights each.
PASSES = 3.0
#: Side of the matrices by which the peak is measured, and repetitions.
PEAK_SIDE, PEAK_ROUNDS = 1536, 4


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
    only_networks: bool = False
    """Leave out memory and inference of MVTrans."""
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
        for job in MVTRANS_JOBS[:2] if given.only_networks else MVTRANS_JOBS:
            found.setdefault(job, []).append(_child(job, given))
        for job in ("simnet", "keypose", "densefusion", "peak"):
            found.setdefault(job, []).append(_child(job, given))
    best = {job: {key: _best(key, [run[key] for run in runs]) for key in runs[0]} for job, runs in found.items()}
    rows = _training(best["reference"], best["corrected"], "corrected")
    if not given.only_networks:
        rows += _training(best["reference"], best["recompute"], "corrected, recompute: features")[1::2]
        rows += _inference(best)
    rows += _networks(best)
    rows += _loading(given, best)
    facts = {"size": f"{WIDTH} x {HEIGHT}, {VIEWS} views, 1 sample", "rounds": given.rounds, "threads": given.threads}
    return report("training, inference and loading", rows, given.json_file, **facts, torch=torch.__version__)


#: Measurements of MVTrans.
MVTRANS_JOBS = ("reference", "corrected", "recompute", "float32", "bfloat16", "compiled")


def _best(key: str, values: list[float]) -> float:
    """Return the best of several runs: the least time or memory, and the greatest speed."""
    return max(values) if key == "gmac" else min(values)


def _networks(best: dict[str, dict[str, float]]) -> list[Row]:
    """Return the rows of all networks: a step, and the part of the machine's peak that the published cost makes."""
    peak, rows = best["peak"]["gmac"], []
    for name, (gmac, size) in PUBLISHED.items():
        seconds = best[name]["seconds"]
        used = PASSES * gmac / seconds / peak
        note = f"{size}: {gmac:g} GMAC a pass, {100.0 * used:.0f} % of {peak:.0f} GMAC/s"
        rows.append(Row(f"training step, {name}", seconds, "s", note=note))
    return rows


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


def _loading(given: Options, best: dict[str, dict[str, float]]) -> list[Row]:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        data = given.data or _rendered(Path(folder))
        for name, job in (("mvtrans", "corrected"), *((one, one) for one in ("simnet", "keypose", "densefusion"))):
            step, seconds = best[job]["seconds"], _sample_seconds(name, data)
            rows.append(
                Row(
                    f"a sample from the loader, {name}, 2 workers",
                    seconds,
                    "s",
                    bound=step / LOADER,
                    ratio=step / seconds,
                    ok=step / seconds >= LOADER,
                    note="ratio: to a training step",
                )
            )
    return rows


def _sample_seconds(name: str, data: Path) -> float:
    settings = with_own_views(TrainSettings.model_validate({"network": name, "train_split": "all"}))
    samples = samples_of(settings, data, "all", augment=settings.augment)
    _, samples = with_data(settings, samples)
    order = [[(index % len(samples), index // len(samples))] for index in range(24)]
    batches = load_batches(samples, order, 2)
    next(batches)
    start = perf_counter()
    count = sum(1 for _ in batches)
    return (perf_counter() - start) / count


def _rendered(folder: Path) -> Path:
    picture = {"spp": 1, "layers": 0, "refraction": False, "light": "path"}
    cameras = {"views": VIEWS + 1, "width": WIDTH, "height": HEIGHT}
    scene = gw.draw(seed=7, cameras=cameras, picture=picture)
    gw.write(folder / "data", scene, gw.Renderer(scene))
    return folder / "data"


def _job(job: str, steps: int) -> dict[str, float]:
    torch.manual_seed(0)
    if job == "peak":
        return {"gmac": _peak()}
    if job in ("simnet", "keypose", "densefusion"):
        return {"seconds": _baseline_steps(job, steps)}
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


def _targets(height: int = HEIGHT) -> dict[str, torch.Tensor]:
    cells, size = (1, height // 8, WIDTH // 8), (1, height, WIDTH)
    fields = {"vertex": torch.zeros(1, 16, *cells[1:]), "covariance": torch.zeros(1, 6, *cells[1:])}
    whole = {"depth": torch.ones(size), "heatmap": torch.zeros(size), "seg": torch.zeros(size, dtype=torch.int64)}
    masks = {"object_mask": torch.ones(size, dtype=torch.bool), "cell_mask": torch.ones(cells, dtype=torch.bool)}
    return {**fields, **whole, **masks, "offset": torch.zeros(1, 2, height, WIDTH), "z_centroid": torch.zeros(cells)}


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


def published_settings(name: str) -> TrainSettings:
    """Return the settings of SimNet, KeyPose or DenseFusion as published."""
    options = {"simnet": {"bins": 22}, "keypose": {"count": 2}, "densefusion": {"categories": ["cup"], "points": 1000}}
    return TrainSettings.model_validate({"network": {"name": name, name: options[name]}})


def _baseline_steps(name: str, count: int) -> float:
    """Return the time of a training step of a network at its published size, with targets of the right shapes."""
    settings = published_settings(name)
    net = build_network(settings.network)
    optimiser = torch.optim.Adam(net.parameters(), lr=1e-6)
    batch, start = BATCHES[name](), 0.0
    for step in range(count + 1):
        if step == 1:
            start = perf_counter()
        loss = total_loss(losses_of(outputs_of(net, batch, settings.network, 0.0), batch, settings), LossWeights())
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        optimiser.step()
    return (perf_counter() - start) / count


def _simnet_batch() -> Batch:
    images, poses, K = torch.rand(1, 2, 3, 512, 640), torch.eye(4).repeat(1, 2, 1, 1), torch.eye(3).repeat(1, 2, 1, 1)
    poses[0, 1, 0, 3] = 0.1
    K[..., 0, 0] = K[..., 1, 1] = 614.0
    return Batch(("",), images, poses, K, _targets(512), (None,))


def _keypose_batch() -> Batch:
    targets = {"keypoints": torch.rand(1, 2, 2, 3), "points": torch.rand(1, 2, 2, 3) + 0.5}
    targets |= {"baseline": torch.ones(1), "projections": torch.eye(3, 4).repeat(1, 5, 1, 1)}
    targets |= {"projection_mask": torch.ones(1, 5, dtype=torch.bool)}
    cameras = torch.eye(4).repeat(1, 2, 1, 1), torch.eye(3).repeat(1, 2, 1, 1)
    return Batch(("",), torch.rand(1, 2, 3, 120, 180), *cameras, targets, (None,))


def _densefusion_batch() -> Batch:
    targets = {"cloud": torch.rand(1, 1000, 3), "pixels": torch.randint(6400, (1, 1000))}
    targets |= {"category": torch.zeros(1, dtype=torch.int64), "model": torch.rand(1, 500, 3)}
    targets |= {"pose": torch.eye(4)[None], "symmetric": torch.tensor([False]), "lost": torch.tensor([False])}
    cameras = torch.eye(4).repeat(1, 1, 1, 1), torch.eye(3).repeat(1, 1, 1, 1)
    return Batch(("",), torch.rand(1, 1, 3, 80, 80), *cameras, targets, (None,))


#: A batch of one sample of each network's published size.
BATCHES = {"simnet": _simnet_batch, "keypose": _keypose_batch, "densefusion": _densefusion_batch}


def _peak() -> float:
    """Return the multiplications and additions of float32 in a second, by products of matrices [1e9]."""
    a, b = torch.rand(PEAK_SIDE, PEAK_SIDE), torch.rand(PEAK_SIDE, PEAK_SIDE)
    torch.matmul(a, b)
    start = perf_counter()
    for _ in range(PEAK_ROUNDS):
        torch.matmul(a, b)
    return PEAK_ROUNDS * PEAK_SIDE**3 / (perf_counter() - start) / 1e9


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
