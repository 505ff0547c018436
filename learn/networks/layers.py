"""Layers that several parts of the networks are made of."""

from __future__ import annotations

import math
from typing import Literal

import torch
from torch import Tensor, nn
from torch.nn import functional

Norm = Literal["batch", "group"]
#: Groups of a group norm, fewer where the channels do not divide. Heads have 32 channels, so a group has four: with the
#: 32 groups of Wu & He ("Group Normalization", 2018) each channel would lose its mean, which is what a head tells.
GROUPS = 8


def norm(kind: Norm, channels: int, dims: int = 2) -> nn.Module:
    """Return a normalisation of pictures (``dims`` 2) or volumes (3)."""
    if kind == "group":
        return nn.GroupNorm(math.gcd(GROUPS, channels), channels)
    return nn.BatchNorm2d(channels) if dims == 2 else nn.BatchNorm3d(channels)


def conv_norm(
    inputs: int, outputs: int, kernel: int = 3, stride: int = 1, dilation: int = 1, kind: Norm = "batch"
) -> nn.Sequential:
    """Return a convolution of pictures without bias, which keeps their size at stride 1, and its normalisation."""
    padding = dilation * (kernel // 2)
    conv = nn.Conv2d(inputs, outputs, kernel, stride, padding, dilation, bias=False)
    return nn.Sequential(conv, norm(kind, outputs))


def conv_norm_3d(inputs: int, outputs: int, kernel: int = 3, stride: int = 1, kind: Norm = "batch") -> nn.Sequential:
    """Return the same of volumes."""
    conv = nn.Conv3d(inputs, outputs, kernel, stride, kernel // 2, bias=False)
    return nn.Sequential(conv, norm(kind, outputs, dims=3))


def initialise(net: nn.Module) -> None:
    """Draw the weights of all convolutions from Kaiming's normal distribution and set biases to 0.

    (He et al., "Delving Deep into Rectifiers", ICCV 2015, eq. 10: standard deviation sqrt(2 / fan in).) The released
    code does so to the whole network, pretrained parts included. The global generator of torch decides the draws.
    """
    for module in net.modules():
        if isinstance(module, nn.Conv2d | nn.Conv3d):
            nn.init.kaiming_normal_(module.weight, nonlinearity="relu")
            if module.bias is not None:
                nn.init.zeros_(module.bias)
        elif isinstance(module, nn.BatchNorm2d | nn.BatchNorm3d | nn.GroupNorm):
            nn.init.ones_(module.weight)
            nn.init.zeros_(module.bias)


def enlarged(values: Tensor, factor: int) -> Tensor:
    """Return pictures at ``factor`` times the size, with every old value at its place in the new picture.

    Strided convolutions put cell i over pixel ``factor * i``. The usual bilinear enlargement puts it over
    ``factor * (i + 1/2) - 1/2``, which is 1.5 px beside that at a factor of 4. Beyond the last cell its value stays.

    Parameters
    ----------
    values : (B, C, H, W) Tensor
        Values at the pixels ``factor * i``.

    Returns
    -------
    (B, C, factor H, factor W) Tensor
    """
    height, width = values.shape[-2:]
    padded = functional.pad(values, (0, 1, 0, 1), mode="replicate")
    size = (factor * height + 1, factor * width + 1)
    return functional.interpolate(padded, size, mode="bilinear", align_corners=True)[..., :-1, :-1]


def convex_enlarged(values: Tensor, logits: Tensor, factor: int) -> Tensor:
    """Return a picture at ``factor`` times the size, each pixel a mean of nine old ones with weights of its own.

    So an edge may stay sharp: a pixel takes the value of the side that it lies on. (Teed & Deng, "RAFT: Recurrent
    All-Pairs Field Transforms for Optical Flow", ECCV 2020, section 3.3.)

    Parameters
    ----------
    values : (B, 1, H, W) Tensor
        The picture; beyond its edge the last value stays.
    logits : (B, 9 factor^2, H, W) Tensor
        Of the weights: for each of the nine in the order of rows, one for each new pixel of an old one.

    Returns
    -------
    (B, 1, factor H, factor W) Tensor
    """
    height, width = values.shape[-2:]
    padded = functional.pad(values, (1, 1, 1, 1), mode="replicate")
    near = functional.unfold(padded, 3).reshape(len(values), 9, 1, height, width)
    weights = logits.unflatten(1, (9, factor * factor)).softmax(dim=1)
    return functional.pixel_shuffle((weights * near).sum(1), factor)


def soft_argmin(logits: Tensor, planes: Tensor) -> Tensor:
    """Return the expected depth, (B, H, W), of logits, (B, D, H, W), over planes, (B, D).

    (Kendall et al., "End-to-End Learning of Geometry and Context for Deep Stereo Regression", ICCV 2017, eq. 1.)
    """
    return torch.einsum("bdhw,bd->bhw", logits.softmax(dim=1), planes)
