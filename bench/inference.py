"""How long a network takes for one pair: torch, the whole of `Predictor.stereo`, and onnxruntime.

    taskset -c 0 python bench/inference.py WEIGHTS [--threads 1] [--rounds 5] [--onnx base.onnx]

Wall and processor time of the fastest of the rounds, in turns, so that other programs disturb all alike. The file of
`glassware export-onnx WEIGHTS` is written first where none is given.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
import tyro
from rich.console import Console
from rich.table import Table

from glassware.learn.prediction.export_onnx import INPUTS, example_inputs, export_onnx, session
from glassware.learn.prediction.predict import sample_pair
from glassware.learn.prediction.predictor import load


@dataclass(frozen=True)
class Request:
    """Weights, and how often what is run."""

    weights: tyro.conf.Positional[Path]
    threads: int = 1
    rounds: int = 5
    onnx: Path | None = None
    size: tuple[int, int] | None = None


def main() -> None:
    """Print a table."""
    import torch

    request = tyro.cli(Request, description=__doc__)
    torch.set_num_threads(request.threads)
    predictor = load(request.weights)
    size = request.size or predictor.settings.views.size or (128, 160)
    inputs = example_inputs(size, 2, seed=1)
    with tempfile.TemporaryDirectory() as folder:
        path = request.onnx or export_onnx(predictor, Path(folder) / "network.onnx", size).path
        runtime = session(path, request.threads)
    arrays = {name: value.numpy() for name, value in zip(INPUTS, inputs, strict=True)}

    def by_torch() -> None:
        with torch.inference_mode():
            predictor.network(*inputs)

    kinds: dict[str, Callable[[], object]] = {
        f"torch, {size[1]} x {size[0]} px": by_torch,
        f"onnxruntime, {size[1]} x {size[0]} px": lambda: runtime.run(None, arrays),
    }
    if sample_pair()[0].is_file():
        kinds["the sample pair, with reading, checks and decoding"] = lambda: predictor.stereo(
            *sample_pair(), camera=str(sample_pair()[0].with_name("camera.json"))
        )
    times = {kind: measured(run, request.rounds) for kind, run in kinds.items()}
    table = Table("what", "wall [ms]", "processor [ms]", title=f"{request.threads} threads")
    for kind, (wall, processor) in times.items():
        table.add_row(kind, f"{1e3 * wall:.0f}", f"{1e3 * processor:.0f}")
    Console(width=120).print(table)


def measured(run: Callable[[], object], rounds: int) -> tuple[float, float]:
    """Return the least wall and processor time of a call [s], after one that is not counted."""
    run()
    found = []
    for _ in range(rounds):
        wall, processor = perf_counter(), process_time()
        run()
        found.append((perf_counter() - wall, process_time() - processor))
    walls, processors = np.array(found).T
    return float(walls.min()), float(processors.min())


if __name__ == "__main__":
    sys.exit(main())
