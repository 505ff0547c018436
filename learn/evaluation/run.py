"""Evaluation of a network on a split of a data set."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from ...core.atomic_io import write_atomically
from ...core.errors import InputError
from ...core.json_file import json_text
from ...core.stopping import check_stop
from ...dataset.format.pictures import write_png
from ...dataset.reader import Dataset
from ..data.dataset_digest import dataset_digest
from ..data.loading import load_batches
from ..data.samples import Batch, Samples
from ..data.semi_global import filled_depth, semi_global_depth
from ..data.splits import SplitName
from ..data.views import CameraView
from ..data.visualise import rgb, sample_picture
from ..networks.build import Network
from ..networks.photometric import seen_by_others
from ..networks.settings import NetworkSettings
from ..targets.encoding import encoding_of
from ..training.checkpoint import load_network
from ..training.methods import outputs_of, samples_of, with_own_views
from ..training.out_folder import make_out_folder
from ..training.settings import TrainSettings
from .object_scores import evaluate_objects, load_detector
from .report import summarise
from .score import SampleScore, eval_mode, score_sample

#: Seed and draw of the source views: the same for every network.
_SEED, _DRAW = 0, 0
#: Samples between two lines about the progress.
_PROGRESS_STEP = 20


@dataclass(frozen=True, eq=False)
class WorstSample:
    """The score of a sample, and its image."""

    score: SampleScore
    picture: np.ndarray


def evaluate(
    checkpoint: Path,
    data: Path,
    split: SplitName,
    out: Path,
    say: Callable[[str], None],
    *,
    worst: int = 8,
    workers: int = 0,
    device: str = "cpu",
    detector: Path | None = None,
    convergence: float | None = None,
) -> dict[str, Any]:
    """Evaluate the network of a checkpoint and write ``report.json`` and images of the worst samples.

    Parameters
    ----------
    checkpoint : Path
        A checkpoint of ours, or of the released code.
    data : Path
        A data set.
    split : str
        ``train``, ``val``, ``test`` or ``all``.
    out : Path
        Output folder.
    say : callable
        Takes lines about the progress.
    worst : int
        Number of samples drawn as images: those with the greatest depth error on objects.
    workers : int
        Worker processes of the data loader; 0: load in this process.
    device : str
        Torch's name of the device.
    detector : Path, optional
        Checkpoint of a network that says where objects are, for KeyPose and DenseFusion.
    convergence : float, optional
        Depth at which both pictures of a stereo pair are cut to show the same [m]; by default that of the training.

    Returns
    -------
    dict
        `report.summarise`, or `object_scores.evaluate_objects`, with the checkpoint and the data set.
    """
    digest = dataset_digest(Dataset.open(data).root)
    network, settings = load_network(checkpoint)
    settings = settings if convergence is None else _cut_at(settings, convergence)
    make_out_folder(out)
    network = network.to(device)
    worst_samples: list[WorstSample] = []
    if settings.network.name in ("keypose", "densefusion"):
        known_by = None if detector is None else load_detector(detector, settings)
        summary = evaluate_objects(network, settings, data, split, say, detector=known_by, workers=workers)
    else:
        if detector is not None:
            raise InputError("--detector", "keypose or densefusion, which find no objects", settings.network.name)
        samples = samples_of(settings, data, split, seed=_SEED, ground_truth=True)
        scores, worst_samples = score_all(network, samples, settings.network, say, worst, workers)
        summary = summarise(scores)
    found = {
        "checkpoint": str(checkpoint),
        "network": settings.network.name,
        "data": {"path": str(data), "split": split, "sha256": digest},
        "views": settings.views.model_dump(mode="json"),
        **summary,
    }
    write_atomically(out / "report.json", json_text(found).encode())
    _write_worst(out, worst_samples)
    return found


def _write_worst(out: Path, samples: list[WorstSample]) -> None:
    for earlier in out.glob("worst-*.png"):
        earlier.unlink()
    for rank, case in enumerate(samples):
        write_png(out / f"worst-{rank:02d}-{case.score.name.replace('/', '-')}.png", case.picture)


def _cut_at(settings: TrainSettings, convergence: float) -> TrainSettings:
    views = settings.views.model_copy(update={"convergence": convergence})
    return with_own_views(settings.model_copy(update={"views": views}))


def score_all(
    network: Network,
    samples: Samples,
    settings: NetworkSettings,
    say: Callable[[str], None],
    worst: int = 0,
    workers: int = 0,
) -> tuple[list[SampleScore], list[WorstSample]]:
    """Put a network into evaluation mode, and return the scores of all samples and the worst samples."""
    eval_mode(network)
    device = next(network.parameters()).device
    order = [[(index, _DRAW)] for index in range(len(samples))]
    scores: list[SampleScore] = []
    worst_samples: list[WorstSample] = []
    with torch.inference_mode():
        for number, batch in enumerate(load_batches(samples, order, workers), start=1):
            check_stop()
            moved = batch.to(device)
            outputs = outputs_of(network, moved, settings)
            outputs = {name: value.float().cpu() for name, value in outputs.items()}
            (labels,) = batch.ground_truths
            matched = matched_depth(batch)
            assert labels is not None, "the data set was made with ground truth"
            of_views = matched, overlap_of(batch, labels.Z)
            score = score_sample(batch.names[0], outputs, batch.K[0, 0], labels, encoding_of(settings), *of_views)
            scores.append(score)
            if worst and (len(worst_samples) < worst or _depth_mae(score) > _depth_mae(worst_samples[-1].score)):
                worst_samples.append(WorstSample(score, sample_picture(batch, outputs, settings)))
                worst_samples = sorted(worst_samples, key=lambda case: -_depth_mae(case.score))[:worst]
            if number % _PROGRESS_STEP == 0 or number == len(samples):
                say(f"sample {number}/{len(samples)}")
    return scores, worst_samples


def overlap_of(batch: Batch, Z: np.ndarray) -> np.ndarray | None:
    """Return which pixels of true depth lie within the picture of another view, (H, W) bool; None for a single view."""
    if batch.K.shape[1] < 2:
        return None
    known = torch.from_numpy(np.where((Z > 0.0) & np.isfinite(Z), Z, 1.0)).double()
    return seen_by_others(known[None], batch.world_T_camera.double(), batch.K.double(), 1)[0].numpy() > 0.0


def matched_depth(batch: Batch) -> np.ndarray | None:
    """Return the depth of a stereo pair by semi-global matching, holes filled, (H, W) [m]; None for other views."""
    poses = batch.world_T_camera[0].double().numpy()
    if len(poses) != 2:
        return None
    relative = np.linalg.inv(poses[0]) @ poses[1]
    # Poses are of float32 here: turns of less than 1e-5 rad and 0.1 mm beside the x axis are none.
    rectified = np.abs(relative[:3, :3] - np.eye(3)).max() < 1e-5 and np.abs(relative[1:3, 3]).max() < 1e-4
    if not rectified or relative[0, 3] <= 0.0:
        return None
    left, right = (
        CameraView(rgb(image), pose, K.double().numpy())
        for image, pose, K in zip(batch.images[0], poses, batch.K[0], strict=True)
    )
    return filled_depth(semi_global_depth(left, right))


def _depth_mae(score: SampleScore) -> float:
    errors = score.full["objects"]
    return 0.0 if errors is None else errors.mae
