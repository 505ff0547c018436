"""Peaks of heatmaps."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional

from ..targets.heatmap import THRESHOLD

#: Peaks are at least this far apart, in rows or in columns [px] (the released code's value).
DISTANCE = 5


@dataclass(frozen=True, eq=False)
class Peaks:
    """Peaks of a batch, each sample's by falling score."""

    sample: Tensor  #: (n,) int64, which sample of the batch
    at: Tensor  #: (n, 2) float32, (x, y) [px]
    score: Tensor  #: (n,) float32, the heat


def find_peaks(heatmap: Tensor, threshold: float = THRESHOLD) -> Peaks:
    """Return the peaks of heatmaps, (B, H, W): pixels over the threshold with no hotter one within `DISTANCE`.

    Of equally hot ones within that distance the first in the order of rows counts.
    """
    width = heatmap.shape[-1]
    window = 2 * DISTANCE + 1
    hottest = functional.max_pool2d(heatmap[:, None], window, 1, DISTANCE)[:, 0]
    is_peak = (heatmap == hottest) & (heatmap > threshold)
    # Among equals the largest of falling numbers is the first.
    order = torch.arange(heatmap[0].numel(), 0, -1, device=heatmap.device, dtype=torch.float64).reshape(
        heatmap[0].shape
    )
    rank = torch.where(is_peak, order, 0.0)
    is_peak &= functional.max_pool2d(rank[:, None], window, 1, DISTANCE)[:, 0] == rank
    sample, place = is_peak.flatten(1).nonzero().unbind(1)
    score = heatmap.flatten(1)[sample, place]
    by_score = torch.argsort(score, descending=True, stable=True)
    by_sample = by_score[torch.argsort(sample[by_score], stable=True)]
    sample, place, score = sample[by_sample], place[by_sample], score[by_sample]
    return Peaks(sample, torch.stack([place % width, place // width], dim=1).float(), score)
