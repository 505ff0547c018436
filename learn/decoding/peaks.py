"""Peaks of heatmaps: non-maximum suppression (NMS) by max pooling."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional

from ...annotate.heatmap import HEAT_THRESHOLD

#: Least distance of two peaks, in rows or in columns [px] (from the released code).
MIN_DISTANCE = 5


@dataclass(frozen=True, eq=False)
class Peaks:
    """Peaks of a batch, those of each sample by descending score."""

    sample: Tensor  #: (n,) int64, index of the sample in the batch
    pixel: Tensor  #: (n, 2) float32, (x, y) [px]
    score: Tensor  #: (n,) float32, the heat


def find_peaks(heatmap: Tensor, threshold: float = HEAT_THRESHOLD) -> Peaks:
    """Return the peaks of heatmaps, (B, H, W): pixels above the threshold with no hotter one within `MIN_DISTANCE`.

    Of equally hot pixels within that distance only the first in row order is a peak.
    """
    width = heatmap.shape[-1]
    window = 2 * MIN_DISTANCE + 1
    hottest = functional.max_pool2d(heatmap[:, None], window, 1, MIN_DISTANCE)[:, 0]
    is_peak = (heatmap == hottest) & (heatmap > threshold)
    # Numbers descend in row order, so the maximum is at the first of equal pixels.
    order = torch.arange(heatmap[0].numel(), 0, -1, device=heatmap.device, dtype=torch.float64).reshape(
        heatmap[0].shape
    )
    rank = torch.where(is_peak, order, 0.0)
    is_peak &= functional.max_pool2d(rank[:, None], window, 1, MIN_DISTANCE)[:, 0] == rank
    sample, index = is_peak.flatten(1).nonzero().unbind(1)
    score = heatmap.flatten(1)[sample, index]
    by_score = torch.argsort(score, descending=True, stable=True)
    by_sample = by_score[torch.argsort(sample[by_score], stable=True)]
    sample, index, score = sample[by_sample], index[by_sample], score[by_sample]
    return Peaks(sample, torch.stack([index % width, index // width], dim=1).float(), score)
