"""A frozen network over a split of a data set."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from ...core.atomic_io import write_atomically
from ...core.json_file import json_text
from ...core.stopping import check_stop
from ...dataset.format.pictures import write_png
from ...dataset.reader import Dataset
from ..data.loading import load_batches
from ..data.samples import SampleDataset
from ..data.visualise import sample_picture
from ..networks.build import Network
from ..targets.encoding import encoding_of
from ..training.checkpoint import data_digest, load_network
from ..training.out_folder import made_folder
from .report import figures
from .score import SampleScore, frozen, score_sample

#: Evaluation draws neighbours once, the same for every network.
_SEED, _DRAW = 0, 0
#: Samples between two lines about the progress.
_LINES = 20


@dataclass(frozen=True, eq=False)
class Scored:
    """A sample's score, and its picture where it is one of the worst so far."""

    score: SampleScore
    picture: np.ndarray


def evaluate(
    checkpoint: Path,
    data: Path,
    split: str,
    out: Path,
    say: Callable[[str], None],
    *,
    worst: int = 8,
    workers: int = 0,
    device: str = "cpu",
) -> dict[str, Any]:
    """Evaluate the network of a checkpoint and write ``report.json`` and the worst samples as pictures.

    Parameters
    ----------
    checkpoint : Path
        Ours, or one of the released code.
    data : Path
        A data set.
    split : str
        ``train``, ``val``, ``test`` or ``all``.
    out : Path
        Folder of the report.
    say : callable
        Takes lines about the progress.
    worst : int
        How many samples, those with the greatest error of depth on objects, are drawn.
    workers : int
        Processes that load samples; 0: none but this one.
    device : str
        Torch's name of the device.

    Returns
    -------
    dict
        `report.figures`, and what was evaluated on what.
    """
    digest = data_digest(Dataset.open(data).root)
    network, settings = load_network(checkpoint)
    made_folder(out)
    encoding = encoding_of(settings.network.variant)
    samples = SampleDataset(data, split, settings.views, encoding, seed=_SEED, truth=True)
    scored, bad = score_all(network.to(device), samples, settings.network.variant, say, worst, workers)
    found = {
        "checkpoint": str(checkpoint),
        "data": {"path": str(data), "split": split, "sha256": digest},
        "views": settings.views.model_dump(mode="json"),
        **figures(scored),
    }
    for earlier in out.glob("worst-*.png"):
        earlier.unlink()
    write_atomically(out / "report.json", json_text(found).encode())
    for rank, case in enumerate(bad):
        write_png(out / f"worst-{rank:02d}-{case.score.name.replace('/', '-')}.png", case.picture)
    return found


def score_all(
    network: Network,
    samples: SampleDataset,
    variant: str,
    say: Callable[[str], None],
    worst: int = 0,
    workers: int = 0,
) -> tuple[list[SampleScore], list[Scored]]:
    """Return the scores of all samples, and the worst ones; the network is frozen and no weight of it changes."""
    frozen(network)
    device = next(network.parameters()).device
    order = [[(index, _DRAW)] for index in range(len(samples))]
    scores: list[SampleScore] = []
    bad: list[Scored] = []
    with torch.inference_mode():
        for number, batch in enumerate(load_batches(samples, order, workers), start=1):
            check_stop()
            moved = batch.to(device)
            outputs = network(moved.images, moved.world_T_camera, moved.K)
            outputs = {name: value.float().cpu() for name, value in outputs.items()}
            (truth,) = batch.truths
            assert truth is not None, "samples come with their labels"
            score = score_sample(batch.names[0], outputs, batch.K[0, 0], truth, encoding_of(variant))
            scores.append(score)
            if worst and (len(bad) < worst or _error(score) > _error(bad[-1].score)):
                bad.append(Scored(score, sample_picture(batch, outputs, variant)))
                bad = sorted(bad, key=lambda case: -_error(case.score))[:worst]
            if number % _LINES == 0 or number == len(samples):
                say(f"sample {number}/{len(samples)}")
    return scores, bad


def _error(score: SampleScore) -> float:
    errors = score.full["objects"]
    return 0.0 if errors is None else errors.mae
