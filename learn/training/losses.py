"""The losses of MVTrans, with the weights of the released code.

The paper (section III-D) names Huber's loss for depth and cross-entropy for classes, and gives no weights.
"""

from __future__ import annotations

from collections.abc import Mapping

import torch
from pydantic import Field
from torch import Tensor
from torch.nn import functional

from ...core.model import Model
from ..networks.settings import NetworkSettings
from ..targets.view import TRANSPARENT

#: The released code gives pixels without ground truth this depth, and cuts all greater ones to it [m].
REFERENCE_FARTHEST = 3.0
#: What the released code multiplies the target of the rough depth by, and divides its loss by.
REFERENCE_SCALE = 0.25


class LossWeights(Model):
    """How much each loss counts, 0 leaves it out; and where Huber's changes.

    Below `huber` a depth error counts with its square over twice that, so that at the released code's 1 m millimetres
    have hardly a gradient; a small value makes it the absolute error.
    """

    huber: float = Field(
        default=1.0, gt=0.0, description="Depth error from which Huber's loss is no longer a square [m]"
    )

    depth: float = Field(default=1.0, ge=0.0, description="Full-size depth, Huber [m]")
    small_depth: float = Field(default=1.0, ge=0.0, description="Rough depth, Huber [m]")
    planes: float = Field(default=1.0, ge=0.0, description="Cross-entropy over planes, with windowed readout alone")
    seg: float = Field(default=1.0, ge=0.0, description="Cross-entropy of classes")
    heatmap: float = Field(default=100.0, ge=0.0, description="Squared error of the heat")
    vertex: float = Field(default=0.1, ge=0.0, description="Absolute error of the vertex field, summed over channels")
    z_centroid: float = Field(default=0.1, ge=0.0, description="Absolute error of the depth of boxes' middles")
    covariance: float = Field(default=0.1, ge=0.0, description="Absolute error of the covariance, summed over channels")
    offset: float = Field(
        default=10.0, ge=0.0, description="Absolute error of offsets over the picture's height, summed over both"
    )


def losses(
    outputs: Mapping[str, Tensor],
    targets: Mapping[str, Tensor],
    settings: NetworkSettings,
    huber: float = 1.0,
) -> dict[str, Tensor]:
    """Return each loss, before its weight.

    Parameters
    ----------
    outputs : mapping of Tensor
        Of a network.
    targets : mapping of Tensor
        Batched, from `targets.view.view_targets`.
    settings : NetworkSettings
        Of the network.
    huber : float
        Of `LossWeights`.

    Returns
    -------
    dict of scalar Tensor
        By the names of `LossWeights`, those that this network has.
    """
    found = {
        "heatmap": functional.mse_loss(outputs["heatmap"], targets["heatmap"]),
        **{name: field_loss(outputs, targets, name) for name in ("vertex", "z_centroid", "covariance")},
    }
    if settings.variant == "reference":
        return found | _reference_losses(outputs, targets, huber)
    found |= {
        "seg": functional.cross_entropy(outputs["seg"], targets["seg"]),
        "depth": depth_loss(outputs["depth"], targets["depth"], huber),
        "small_depth": depth_loss(outputs["small_depth"], quartered(targets["depth"]), huber),
        "offset": masked_mean((outputs["offset"] - targets["offset"]).abs().sum(1), targets["owned"]),
    }
    if settings.readout == "windowed":
        found["planes"] = plane_loss(outputs["plane_logits"], outputs["planes"], quartered(targets["depth"]))
    return found


def total_loss(found: Mapping[str, Tensor], weights: LossWeights) -> Tensor:
    """Return the weighted sum."""
    return torch.stack([getattr(weights, name) * value for name, value in found.items()]).sum()


def masked_mean(values: Tensor, mask: Tensor) -> Tensor:
    """Return the mean of values where a mask of the same shape is true; 0 where it nowhere is."""
    return torch.where(mask, values, 0.0).sum() / mask.sum().clamp_min(1)


def depth_loss(depth: Tensor, target: Tensor, huber: float) -> Tensor:
    """Return Huber's loss over the pixels whose target is a depth, not 0."""
    return masked_mean(functional.smooth_l1_loss(depth, target, beta=huber, reduction="none"), target > 0.0)


def field_loss(outputs: Mapping[str, Tensor], targets: Mapping[str, Tensor], name: str) -> Tensor:
    """Return the absolute error of a field, summed over its channels, over the cells that count."""
    error = (outputs[name] - targets[name]).abs()
    return masked_mean(error.sum(1) if error.ndim == 4 else error, targets["counts"])


def quartered(depth: Tensor) -> Tensor:
    """Return the depth of the pixels that features stand for: every fourth row and column."""
    return depth[..., ::4, ::4]


def plane_loss(logits: Tensor, planes: Tensor, target: Tensor) -> Tensor:
    """Return the cross-entropy of the planes against the two next to the target.

    Their probabilities are such that the expectation is the target. Before the first plane or beyond the last, that one
    has all.

    Parameters
    ----------
    logits : (B, D, h, w) Tensor
        Of the planes.
    planes : (B, D) Tensor
        Their depths [m], ascending.
    target : (B, h, w) Tensor
        Depth [m]; 0 where it is unknown.
    """
    count = planes.shape[1]
    flat = target.flatten(1).contiguous()
    upper = torch.searchsorted(planes.contiguous(), flat).clamp(1, count - 1)
    near, far = planes.gather(1, upper - 1), planes.gather(1, upper)
    share = ((flat - near) / (far - near)).clamp(0.0, 1.0).reshape(target.shape)
    log_probability = logits.log_softmax(dim=1)
    index = upper.reshape(target.shape)[:, None]
    lower_term = log_probability.gather(1, index - 1)[:, 0] * (1.0 - share)
    return masked_mean(-lower_term - log_probability.gather(1, index)[:, 0] * share, target > 0.0)


def _reference_losses(outputs: Mapping[str, Tensor], targets: Mapping[str, Tensor], huber: float) -> dict[str, Tensor]:
    """Return the released code's: no pixel is left out, and the rough depth learns a quarter of the true one."""
    depth = torch.where(targets["depth"] > 0.0, targets["depth"], REFERENCE_FARTHEST).clamp_max(REFERENCE_FARTHEST)
    small = REFERENCE_SCALE * quartered(depth)
    return {
        "seg": functional.cross_entropy(outputs["seg"], targets["seg"].clamp_max(TRANSPARENT)),
        "depth": functional.smooth_l1_loss(outputs["depth"], depth, beta=huber),
        "small_depth": functional.smooth_l1_loss(outputs["small_depth"], small, beta=huber) / REFERENCE_SCALE,
    }
