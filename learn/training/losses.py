"""The losses of MVTrans and SimNet, with the weights of the released code.

The paper (section III-D) names the Huber loss for depth and cross-entropy for classes, and gives no weights.
"""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor
from torch.nn import functional

from ..networks.settings import NetworkSettings
from ..targets.view import TRANSPARENT
from .loss_weights import LossWeights

#: Greatest target depth of the released code, also that of pixels without ground truth [m].
REFERENCE_MAX_DEPTH = 3.0
#: Factor of the coarse depth's target in the released code, which divides its loss by the same factor.
REFERENCE_SCALE = 0.25
#: Disparities above the first are the second in the released SimNet [px].
_TOO_LARGE, _LARGEST = 128.0, 127.0


def losses(
    outputs: Mapping[str, Tensor],
    targets: Mapping[str, Tensor],
    settings: NetworkSettings,
    huber: float = 1.0,
    object_pixels: float = 1.0,
) -> dict[str, Tensor]:
    """Return each loss, unweighted.

    Parameters
    ----------
    outputs : mapping of Tensor
        Outputs of a network.
    targets : mapping of Tensor
        Batch of `targets.view.view_targets`.
    settings : NetworkSettings
        Settings of the network: MVTrans or SimNet.
    huber, object_pixels : float
        As in `LossWeights`.

    Returns
    -------
    dict of scalar Tensor
        By the names of `LossWeights`; losses that the network lacks are left out.
    """
    found = {
        "heatmap": functional.mse_loss(outputs["heatmap"], targets["heatmap"]),
        **{name: field_loss(outputs, targets, name) for name in ("vertex", "z_centroid", "covariance")},
    }
    if settings.name == "simnet":
        return found | _disparity_losses(outputs, targets, released=settings.variant == "reference")
    if settings.variant == "reference":
        return found | _reference_losses(outputs, targets, huber)
    weight = torch.where(targets["seg"] >= TRANSPARENT, object_pixels, 1.0)  # (B, H, W)
    found |= {
        "seg": functional.cross_entropy(outputs["seg"], targets["seg"]),
        "depth": depth_loss(outputs["depth"], targets["depth"], huber, weight),
        "small_depth": depth_loss(outputs["small_depth"], at_quarter(targets["depth"]), huber, at_quarter(weight)),
        "offset": masked_mean((outputs["offset"] - targets["offset"]).abs().sum(1), targets["object_mask"]),
    }
    if settings.refinement != "none":
        found["unrefined_depth"] = depth_loss(outputs["unrefined_depth"], targets["depth"], huber, weight)
    if settings.readout == "windowed":
        found["planes"] = plane_loss(outputs["plane_logits"], outputs["planes"], at_quarter(targets["depth"]))
    return found


def total_loss(found: Mapping[str, Tensor], weights: LossWeights) -> Tensor:
    """Return the weighted sum of losses."""
    return torch.stack([getattr(weights, name) * value for name, value in found.items()]).sum()


def masked_mean(values: Tensor, mask: Tensor) -> Tensor:
    """Return the mean of values where a mask of the same shape is true; 0 for an empty mask."""
    return torch.where(mask, values, 0.0).sum() / mask.sum().clamp_min(1)


def depth_loss(depth: Tensor, target: Tensor, huber: float, weight: Tensor) -> Tensor:
    """Return the weighted mean of the Huber loss over the pixels with a target depth (not 0)."""
    error = functional.smooth_l1_loss(depth, target, beta=huber, reduction="none")
    known = torch.where(target > 0.0, weight, 0.0)
    # Not `error * known` alone: the error of a pixel without a target may be infinite.
    return torch.where(target > 0.0, error * weight, 0.0).sum() / known.sum().clamp_min(1.0)


def field_loss(outputs: Mapping[str, Tensor], targets: Mapping[str, Tensor], name: str) -> Tensor:
    """Return the absolute error of a field, summed over channels, averaged over the cells with a target."""
    error = (outputs[name] - targets[name]).abs()
    return masked_mean(error.sum(1) if error.ndim == 4 else error, targets["cell_mask"])


def at_quarter(depth: Tensor) -> Tensor:
    """Return depth or weights at 1/4 of the image size, at the pixels of the features: every fourth row and column."""
    return depth[..., ::4, ::4]


def plane_loss(logits: Tensor, planes: Tensor, target: Tensor) -> Tensor:
    """Return the cross-entropy between plane probabilities and a soft label on the two planes next to the target depth.

    The expectation of the soft label is the target. Outside the range of the planes, the first or last plane has
    probability 1.

    Parameters
    ----------
    logits : (B, D, h, w) Tensor
        Logits of the planes.
    planes : (B, D) Tensor
        Depths of the planes [m], ascending.
    target : (B, h, w) Tensor
        Depth [m]; 0 where it is unknown.
    """
    count = planes.shape[1]
    flat = target.flatten(1).contiguous()
    upper = torch.searchsorted(planes.contiguous(), flat).clamp(1, count - 1)
    near, far = planes.gather(1, upper - 1), planes.gather(1, upper)
    fraction = ((flat - near) / (far - near)).clamp(0.0, 1.0).reshape(target.shape)
    log_probability = logits.log_softmax(dim=1)
    index = upper.reshape(target.shape)[:, None]
    lower_term = log_probability.gather(1, index - 1)[:, 0] * (1.0 - fraction)
    return masked_mean(-lower_term - log_probability.gather(1, index)[:, 0] * fraction, target > 0.0)


def _reference_losses(outputs: Mapping[str, Tensor], targets: Mapping[str, Tensor], huber: float) -> dict[str, Tensor]:
    """Return the losses of the released code: over all pixels, with a quarter of the depth as coarse target."""
    depth = torch.where(targets["depth"] > 0.0, targets["depth"], REFERENCE_MAX_DEPTH).clamp_max(REFERENCE_MAX_DEPTH)
    small = REFERENCE_SCALE * at_quarter(depth)
    return {
        "seg": functional.cross_entropy(outputs["seg"], targets["seg"].clamp_max(TRANSPARENT)),
        "depth": functional.smooth_l1_loss(outputs["depth"], depth, beta=huber),
        "small_depth": functional.smooth_l1_loss(outputs["small_depth"], small, beta=huber) / REFERENCE_SCALE,
    }


def _disparity_losses(
    outputs: Mapping[str, Tensor], targets: Mapping[str, Tensor], *, released: bool
) -> dict[str, Tensor]:
    """Return the losses of SimNet; the coarse disparity has the target at its own pixels, over 4.

    The released network learns a disparity everywhere, 0 where there is no surface; the corrected one where depth is
    known.
    """
    depth = targets["depth"]
    known = depth > 0.0
    disparity = torch.where(known, outputs["focal_baseline"][:, None, None] / torch.where(known, depth, 1.0), 0.0)
    if released:
        disparity = torch.where(disparity > _TOO_LARGE, _LARGEST, disparity)
        known = torch.ones_like(known)
    full = functional.smooth_l1_loss(outputs["disparity"], disparity, reduction="none")
    # At 1/4 of the size a disparity is a quarter of its pixels.
    small = functional.smooth_l1_loss(outputs["small_disparity"] / 4.0, at_quarter(disparity) / 4.0, reduction="none")
    return {
        "seg": functional.cross_entropy(outputs["seg"], targets["seg"]),
        "disparity": masked_mean(full, known),
        "small_disparity": masked_mean(small, at_quarter(known)),
    }
