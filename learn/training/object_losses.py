"""The losses of KeyPose and DenseFusion: methods that see one object at a time."""

from __future__ import annotations

import math
from collections.abc import Mapping

import torch
from torch import Tensor

from ..decoding.keypoints import points_in_space
from .loss_weights import RELEASED_DISPARITY
from .losses import masked_mean

#: Fractions of a run between which the loss of other views sets in: 5,000 and 10,000 of 80,000 steps (released code).
PROJECTION_RAMP = (1.0 / 16.0, 1.0 / 8.0)
#: Least depth of a point in another view that is projected [m].
_MIN_DEPTH = 0.05
#: Greatest squared error of a keypoint in another view, in half pictures: its whole diagonal. A first guess of no
#: disparity lies kilometres away, where the error has no bound and no meaning.
_MOST_APART = 8.0
#: Standard deviation around a keypoint beyond which its probability is punished, over the window's width: 20 of 180 px.
_NEAR = 20.0 / 180.0
#: Predictions whose nearest points are looked up at once: the distances of 32 x 500 x 500 points take 32 MB.
_CHUNK = 32


def keypose_losses(
    outputs: Mapping[str, Tensor],
    targets: Mapping[str, Tensor],
    K: Tensor,
    size: tuple[int, int],
    progress: float,
    *,
    disparity: float = RELEASED_DISPARITY,
    released: bool = False,
) -> dict[str, Tensor]:
    """Return the losses of KeyPose (Liu et al., CVPR 2020, section 4.2), each for the best order of the keypoints.

    Parameters
    ----------
    outputs : mapping of Tensor
        Of `KeyPose`.
    targets : mapping of Tensor
        Batch of `data.keypose_samples.KeyPoseSamples`.
    K : (B, 2, 3, 3) Tensor
        Intrinsic matrices of the windows [px].
    size : (int, int)
        Height and width of the windows [px].
    progress : float
        Fraction of the run that is done.
    disparity : float
        Weight of the squared error of the disparity, where columns and rows have 1; all are over half windows.
    released : bool
        Whether other views that do not exist count with an error of 0, as in the released code.
    """
    height, width = size
    found, wanted = outputs["keypoints"], targets["keypoints"]  # (B, K, 3), (B, n, K, 3)
    scale = found.new_tensor([2.0 / width, 2.0 / height, math.sqrt(disparity) * 2.0 / width])
    error = (((found[:, None] - wanted) * scale) ** 2).sum((2, 3))  # (B, n)
    best = error.argmin(1)
    rows = torch.arange(len(best), device=best.device)
    terms = {"keypoint": error[rows, best].mean()}
    start, end = PROJECTION_RAMP
    ramp = min(max((progress - start) / (end - start), 0.0), 1.0)
    if ramp:
        points = points_in_space(found, K, targets["baseline"])
        true, mask = targets["points"][rows, best], targets["projection_mask"]
        apart = (_seen(points, targets["projections"]) - _seen(true, targets["projections"])) ** 2
        apart = apart.sum(3)  # (B, V, K)
        apart = (apart if released else apart.clamp_max(_MOST_APART)).sum(2)  # (B, V)
        terms["projection"] = ramp * (torch.where(mask, apart, 0.0).mean() if released else masked_mean(apart, mask))
    if "probability" in outputs:
        terms["probability"] = _away(outputs["probability"], wanted[rows, best], _NEAR * width)
    return terms


def densefusion_losses(
    outputs: Mapping[str, Tensor], targets: Mapping[str, Tensor], confidence: float
) -> dict[str, Tensor]:
    """Return the loss of DenseFusion (Wang et al., CVPR 2019, section 3.3 and 3.4), or of its refiner where it ran.

    Parameters
    ----------
    outputs : mapping of Tensor
        Of `DenseFusion`.
    targets : mapping of Tensor
        Batch of `data.densefusion_samples.DenseFusionSamples`; objects that are `lost` have no loss.
    confidence : float
        Weight of the logarithm of the confidence [m].
    """
    kept = ~targets["lost"]
    model, pose = targets["model"], targets["pose"]
    true = model @ pose[:, :3, :3].mT + pose[:, None, :3, 3]  # (B, M, 3)
    if "refined" in outputs:
        passes = outputs["refined"]  # (B, S, 4, 4)
        distance = model_distances(passes, model, true, targets["symmetric"])
        return {"refined": masked_mean(distance.mean(1), kept)}
    distance = model_distances(outputs["poses"], model, true, targets["symmetric"])  # (B, N)
    weighted = distance * outputs["confidence"] - confidence * outputs["confidence"].log()
    return {"distance": masked_mean(weighted.mean(1), kept)}


def model_distances(poses: Tensor, model: Tensor, true: Tensor, symmetric: Tensor) -> Tensor:
    """Return the mean distance of the points of a model under poses from the true ones, (B, N) [m].

    Parameters
    ----------
    poses : (B, N, 4, 4) Tensor
        Predicted poses [m].
    model, true : (B, M, 3) Tensor
        Points in the object's frame, and under the true pose [m].
    symmetric : (B,) bool Tensor
        Objects whose points are compared with the nearest true one.
    """
    found = torch.einsum("bnij,bmj->bnmi", poses[..., :3, :3], model) + poses[:, :, None, :3, 3]
    rows = []
    for number in range(len(found)):
        target = true[number].expand_as(found[number])
        if bool(symmetric[number]):
            with torch.no_grad():
                nearest = torch.cat([torch.cdist(part, true[number]).argmin(2) for part in found[number].split(_CHUNK)])
            target = true[number][nearest]
        rows.append((found[number] - target).norm(dim=2).mean(1))
    return torch.stack(rows)


def _seen(points: Tensor, projections: Tensor) -> Tensor:
    """Return points, (B, K, 3), in other views, (B, V, K, 2), by their projections, (B, V, 3, 4)."""
    seen = torch.einsum("bvij,bkj->bvki", projections[..., :3], points) + projections[:, :, None, :, 3]
    return seen[..., :2] / seen[..., 2:].clamp_min(_MIN_DEPTH)


def _away(probability: Tensor, keypoints: Tensor, deviation: float) -> Tensor:
    """Return the probability that is far from keypoints, summed over them, the mean over samples."""
    height, width = probability.shape[-2:]
    row = torch.arange(height, device=probability.device)[:, None] - keypoints[..., 1, None, None]
    column = torch.arange(width, device=probability.device) - keypoints[..., 0, None, None]
    far = 1.0 - torch.exp(-(row**2 + column**2) / (2.0 * deviation**2))
    return (probability * far).sum((1, 2, 3)).mean()
