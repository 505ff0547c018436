"""Keypoints without a network: the same answer in every window.

A network that does not beat it has not learnt to find an object's keypoints in the window that it is given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from ..decoding.keypoints import points_in_space
from .report import distance_metrics


@dataclass(frozen=True, eq=False)
class Windows:
    """What is true of the windows of a batch."""

    targets: Mapping[str, Tensor]  #: of `KeyPoseSamples`
    K: Tensor  #: (B, 2, 3, 3) [px]


def constant_keypoints(windows: Sequence[Windows]) -> dict[str, Any]:
    """Return `report.keypoint_metrics` of the answer that is best for all windows together.

    That answer is the median of all true keypoints, by coordinate: column and row in the left window, and the shift to
    the right one. Like the floors of depth it is read from the true values of the tested windows themselves.
    """
    constant = torch.cat([batch.targets["keypoints"][:, 0] for batch in windows]).median(dim=0).values.double()
    distances: list[float] = []
    objects = 0
    for batch in windows:
        true = batch.targets["points"].double()  # (B, n, K, 3): in each order that looks the same
        answer = constant.expand(len(true), -1, -1)
        found = points_in_space(answer, batch.K.double(), batch.targets["baseline"].double())
        of_orders = (found[:, None] - true).norm(dim=-1)
        best = of_orders.mean(dim=-1).argmin(dim=1)
        distances += of_orders[torch.arange(len(true)), best].flatten().tolist()
        objects += len(true)
    return distance_metrics(distances, 0, objects)
