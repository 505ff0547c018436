"""Photometric similarity: how alike the pictures themselves are along the planes of the sweep, without weights.

Colours less their local mean, over their local contrast, are compared: neither exposure nor vignetting changes them.
(Normalised matching costs, as in Scharstein & Szeliski, "A Taxonomy and Evaluation of Dense Two-Frame Stereo
Correspondence Algorithms", IJCV 2002, section 3.1.)
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from .plane_sweep import plane_sweep_grid, source_cameras, warp

#: Pictures are compared at 1/2 of their size.
STRIDE = 2
#: Side of the window of the local mean and contrast [px].
_CONTRAST = 5
#: Variance of colours in [0, 1] that is added to the local one: about that of a noisy camera, 0.02^2.
_NOISE = 4e-4


def local_contrast(images: Tensor) -> Tensor:
    """Return colours less their mean over a window, divided by their deviation there.

    Parameters
    ----------
    images : (N, 3, h, w) Tensor
        Images in [0, 1], or `halved` ones.

    Returns
    -------
    (N, 3, h, w) Tensor
    """
    residual, variance = _local_moments(images)
    return residual / (variance + _NOISE).sqrt()


def halved(images: Tensor) -> Tensor:
    """Return the images at 1/2 of their size, (N, 3, H/2, W/2); pixel i lies over pixel 2 i of the images."""
    return functional.avg_pool2d(images, 3, STRIDE, 1, count_include_pad=False)


def local_deviation(images: Tensor) -> Tensor:
    """Return the deviation of colours over the window of `local_contrast`, (N, h, w), of images as there."""
    return _local_moments(images)[1][:, 0].sqrt()


def _local_moments(images: Tensor) -> tuple[Tensor, Tensor]:
    """Return colours less their local mean, (N, 3, h, w), and their mean variance, (N, 1, h, w)."""
    residual = images - window_mean(images, _CONTRAST)
    return residual, window_mean(residual.square(), _CONTRAST).mean(1, keepdim=True)


def photometric_similarity(
    contrast: Tensor, world_T_camera: Tensor, K: Tensor, planes: Tensor, finer: int = 1, unseen: float = 0.0
) -> Tensor:
    """Return the similarity of the reference view and the others along the planes, (B, D, H/2, W/2) in [0, 1].

    The mean over the views that see a point of exp(-|difference|), with the mean difference of the three colours.

    Parameters
    ----------
    contrast : (B, V, 3, H/2, W/2) or (B, V, 3, H, W) Tensor
        Of `local_contrast`; the first view is the reference. At full size every second pixel of it is matched, in the
        finer views.
    world_T_camera, K : (B, V, 4, 4) and (B, V, 3, 3) Tensor
        Poses [m], and intrinsic matrices at full size [px].
    planes : (B, D) or (B, D, H/2, W/2) Tensor
        Depths of the planes [m].
    finer : int
        Size of `contrast` over 1/2 of that of the images: 1 or 2.
    unseen : float
        Similarity of a point that lies in none of the other images.
    """
    size = (contrast.shape[-2] // finer, contrast.shape[-1] // finer)
    reference = contrast[:, 0, :, None, ::finer, ::finer]
    total, count = torch.zeros((), device=contrast.device), torch.zeros((), device=contrast.device)
    for view, camera in enumerate(source_cameras(world_T_camera, K, STRIDE), start=1):
        pixels, visible = plane_sweep_grid(*camera, planes, size)
        warped = warp(contrast[:, view], finer * pixels)  # (B, 3, D, H/2, W/2)
        difference = (reference - warped).abs().mean(1)
        total = total + torch.where(visible, torch.exp(-difference), 0.0)
        count = count + visible
    return torch.where(count > 0, total / count.clamp_min(1), unseen)


def seen_by_others(depth: Tensor, world_T_camera: Tensor, K: Tensor, stride: int) -> Tensor:
    """Return the fraction of the other views inside whose image a pixel's point lies, (B, h, w), hidden or not.

    Parameters
    ----------
    depth : (B, h, w) Tensor
        Depth at 1/stride of the image size [m].
    world_T_camera, K : (B, V, 4, 4) and (B, V, 3, 3) Tensor
        Poses [m], and intrinsic matrices at full size [px].
    stride : int
        Of the depth.
    """
    size, cameras = (depth.shape[-2], depth.shape[-1]), source_cameras(world_T_camera, K, stride)
    seen = [plane_sweep_grid(*camera, depth[:, None], size)[1][:, 0] for camera in cameras]
    return torch.stack(seen).to(depth).mean(0)


def window_mean(values: Tensor, side: int) -> Tensor:
    """Return means over square windows, cut at the border, of the same shape."""
    return functional.avg_pool2d(values, side, 1, side // 2, count_include_pad=False)
