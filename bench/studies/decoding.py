"""What decoding, metrics and planes were before they were mended, and are now: the same weights on the same samples.

python bench/studies/decoding.py DATA [--weights base]

Boxes: their sizes from the corners, as in the released code, and from the covariance. ADD-S: over the eight keypoints,
and over points all over the surface. Planes: between the extremes of table and objects, and between quantiles of the
objects; how many of them lie among 99 % of the pixels of objects.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import torch
import tyro

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from command import Output, run
from table import Row, report

from glassware.learn.data.loading import load_batches
from glassware.learn.data.samples import SampleDataset
from glassware.learn.evaluation.report import summarise
from glassware.learn.evaluation.score import SampleScore, eval_mode, score_sample
from glassware.learn.networks.plane_sweep import plane_depths
from glassware.learn.targets.encoding import encoding_of
from glassware.learn.training.checkpoint import load_network
from glassware.learn.training.methods import outputs_of, samples_of, with_data
from glassware.learn.training.settings import TrainSettings
from glassware.procedural.description.scene import TABLE_ID


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """Which weights, on which samples."""

    data: Annotated[Path, tyro.conf.Positional]
    """Data set with stereo pairs."""
    weights: str = "base"
    """Weights that come with glassware, or a checkpoint."""


def main(given: Options) -> int:
    """Print each figure before and now."""
    torch.set_num_threads(1)
    network, settings = load_network(Path(given.weights))
    samples = samples_of(settings, given.data, "all", seed=0, ground_truth=True)
    assert isinstance(samples, SampleDataset)
    corners, keypoints, now = (summarise(scores) for scores in _scores(eval_mode(network), settings, samples))
    before_planes, now_planes = _planes(samples, settings)
    rows = (
        _row("3D AP25, sizes from corners or covariance", corners["boxes"]["ap25"], now["boxes"]["ap25"]),
        _row("objects found, sizes likewise", corners["pose"]["found"], now["pose"]["found"]),
        _row("ADD-S, over keypoints or surface", keypoints["pose"]["add_s"], now["pose"]["add_s"], "m"),
        _row("mask AP, COCO's or at 0.5 as in the paper", now["masks"]["ap"], now["masks"]["ap50"]),
        _row(f"of {settings.network.planes} planes among objects", before_planes, now_planes),
    )
    return report("before (peer) and now", rows, given.json_file, samples=len(samples), data=given.data)


def _row(name: str, before: float, now: float, unit: str = "") -> Row:
    return Row(name, now, unit, peer=before)


def _scores(
    network: torch.nn.Module, settings: TrainSettings, samples: SampleDataset
) -> tuple[Sequence[SampleScore], ...]:
    """Return scores with sizes from corners, with ADD-S over keypoints, and as they are now."""
    now = encoding_of(settings.network)
    found: tuple[list[SampleScore], ...] = ([], [], [])
    with torch.inference_mode():
        for batch in load_batches(samples, [[(index, 0)] for index in range(len(samples))], 0):
            outputs = outputs_of(network, batch, settings.network)
            outputs = {name: value.float() for name, value in outputs.items()}
            (labels,) = batch.ground_truths
            assert labels is not None
            ways: tuple[dict[str, Any], ...] = (
                {"labels": labels, "encoding": replace(now, rotation="vertices")},
                {"labels": replace(labels, surface={}), "encoding": now},
                {"labels": labels, "encoding": now},
            )
            for scores, way in zip(found, ways, strict=True):
                scores.append(score_sample(batch.names[0], outputs, batch.K[0, 0], **way))
    return found


def _planes(samples: SampleDataset, settings: TrainSettings) -> tuple[float, float]:
    """Return how many planes lie among 99 % of the pixels of objects: between the extremes of all, and now."""
    of_objects, of_all = [], []
    for index in range(len(samples)):
        labels = samples.labels(index)
        known = np.isfinite(labels.Z)
        of_objects.append(labels.Z[known & (labels.instances > TABLE_ID)])
        of_all.append(labels.Z[known & (labels.instances >= TABLE_ID)])
    least, most = np.quantile(np.concatenate(of_objects), (0.005, 0.995))
    everything = np.concatenate(of_all)
    own = settings.network.model_copy(update={"depth_range": None})
    fitted, _ = with_data(settings.model_copy(update={"network": own}), samples)
    assert fitted.network.depth_range is not None
    counts = []
    for near, far in ((everything.min(), everything.max()), fitted.network.depth_range):
        planes = plane_depths(torch.tensor([[near, far]]), own.planes, own.spacing)[0].numpy()
        counts.append(float(((planes >= least) & (planes <= most)).sum()))
    return counts[0], counts[1]


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
