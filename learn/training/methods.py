"""What differs between the networks in a run: their samples, what follows from the data, their outputs and losses."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from torch import Tensor, nn

from ...core.errors import InputError
from ..data.samples import Batch, SampleDataset
from ..data.settings import AugmentSettings
from ..data.splits import SplitName
from ..networks.settings import NetworkSettings
from ..targets.encoding import encoding_of
from .losses import losses
from .settings import TrainSettings

#: How far the planes, and the nearest disparity, reach beyond the depths of the training data, as a fraction: other
#: scenes are a little larger.
_DEPTH_MARGIN = 0.1
#: Quarter-size pixels: the step between two disparities [px].
_QUARTER = 4.0


def with_own_views(settings: TrainSettings) -> TrainSettings:
    """Return settings with the views of their network: the eyes of a stereo pair for all but MVTrans.

    Their samples are not mirrored: the mirror image of a pair has its eyes exchanged, and labels are of the left one.

    Raises
    ------
    InputError
        Where other views are asked for.
    """
    if settings.network.name == "mvtrans":
        return settings
    if settings.views.rule == "grid" or settings.views.count != 2:
        found = f"{settings.views.count} by the rule {settings.views.rule}"
        raise InputError("views", f"the two eyes of a stereo pair, which {settings.network.name} takes", found)
    views = settings.views.model_copy(update={"rule": "stereo"})
    return settings.model_copy(update={"views": views, "augment": settings.augment.model_copy(update={"flip": 0.0})})


def samples_of(
    settings: TrainSettings,
    data: Path,
    split: SplitName,
    *,
    augment: AugmentSettings | None = None,
    seed: int = 0,
    ground_truth: bool = False,
) -> SampleDataset:
    """Return the samples of a network, as `SampleDataset`."""
    encoding = encoding_of(settings.network)
    return SampleDataset(data, split, settings.views, encoding, augment=augment, seed=seed, ground_truth=ground_truth)


def with_data(settings: TrainSettings, train: SampleDataset) -> TrainSettings:
    """Return settings with what follows from the training data where they leave it open: planes, disparities."""
    changes: dict[str, Any] = {}
    network = settings.network
    if network.name == "mvtrans" and network.variant == "corrected" and network.depth_range is None:
        near, far = train.depth_range()
        changes = {"depth_range": ((1.0 - _DEPTH_MARGIN) * near, (1.0 + _DEPTH_MARGIN) * far)}
    if network.name == "simnet" and network.simnet.bins is None:
        nearest = (1.0 - _DEPTH_MARGIN) * train.depth_range()[0]
        zoom = settings.augment.zoom[1] if settings.augment.probability else 1.0
        bins = math.ceil(zoom * train.focal_baseline() / nearest / _QUARTER) + 1
        changes = {"simnet": network.simnet.model_dump() | {"bins": bins}}
    if not changes:
        return settings
    network = NetworkSettings.model_validate(network.model_dump() | changes)
    return settings.model_copy(update={"network": network})


def outputs_of(network: nn.Module, batch: Batch, settings: NetworkSettings) -> dict[str, Tensor]:
    """Return the outputs of a network for a batch."""
    return network(batch.images, batch.world_T_camera, batch.K)


def losses_of(outputs: Mapping[str, Tensor], batch: Batch, settings: TrainSettings) -> dict[str, Tensor]:
    """Return each loss of a network, unweighted, by the names of `LossWeights`."""
    return losses(outputs, batch.targets, settings.network, settings.losses.huber)
