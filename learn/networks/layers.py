"""Building blocks of both networks: normalisation, convolutions, initialisation, upsampling, input checks."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional

from ...core.errors import InputError
from .settings import SIZE_MULTIPLE, Norm

#: Groups of a group norm; fewer where they do not divide the channels. Heads have 32 channels, so a group has four:
#: with the 32 groups of Wu & He ("Group Normalization", 2018) each channel would lose its mean, which heads predict.
GROUPS = 8
#: Channels up to which strided 1 x 1 convolutions count as narrow (`set_memory_formats`).
NARROW = 16


def norm(kind: Norm, channels: int, dims: int = 2) -> nn.Module:
    """Return a normalisation layer for images (``dims`` 2) or volumes (3)."""
    if kind == "group":
        return nn.GroupNorm(math.gcd(GROUPS, channels), channels)
    return nn.BatchNorm2d(channels) if dims == 2 else nn.BatchNorm3d(channels)


def conv_norm(
    inputs: int, outputs: int, kernel: int = 3, stride: int = 1, dilation: int = 1, kind: Norm = "batch"
) -> nn.Sequential:
    """Return a 2D convolution without bias, padded to keep the size at stride 1, and its normalisation."""
    padding = dilation * (kernel // 2)
    conv = nn.Conv2d(inputs, outputs, kernel, stride, padding, dilation, bias=False)
    return nn.Sequential(conv, norm(kind, outputs))


def conv_norm_3d(inputs: int, outputs: int, kernel: int = 3, stride: int = 1, kind: Norm = "batch") -> nn.Sequential:
    """Return a 3D convolution without bias, padded to keep the size at stride 1, and its normalisation."""
    conv = nn.Conv3d(inputs, outputs, kernel, stride, kernel // 2, bias=False)
    return nn.Sequential(conv, norm(kind, outputs, dims=3))


def initialise(net: nn.Module) -> None:
    """Draw all convolution weights from Kaiming's normal distribution and set biases to 0.

    (He et al., "Delving Deep into Rectifiers", ICCV 2015, eq. 10: standard deviation sqrt(2 / fan in).) The released
    code initialises the whole network this way, pretrained parts included. Draws come from torch's global generator.
    """
    for module in net.modules():
        if isinstance(module, nn.Conv2d | nn.Conv3d):
            nn.init.kaiming_normal_(module.weight, nonlinearity="relu")
            if module.bias is not None:
                nn.init.zeros_(module.bias)
        elif isinstance(module, nn.BatchNorm2d | nn.BatchNorm3d | nn.GroupNorm) and module.affine:
            nn.init.ones_(module.weight)
            nn.init.zeros_(module.bias)


def set_memory_formats(net: nn.Module) -> None:
    """Lay the weights of convolutions out with channels last, in which oneDNN multiplies without reordering.

    On a CPU a training step takes 0.6 times the CPU time together with a fused optimiser and bfloat16. Two-dimensional
    ones stay as they are where a network has narrow strided 1 x 1 convolutions: with `NARROW` channels or fewer, their
    backward pass in torch 2.13 writes out of bounds for channels-last memory.
    """
    flat = [module for module in net.modules() if isinstance(module, nn.Conv2d)]
    narrow = any(
        module.kernel_size == (1, 1) and module.stride != (1, 1) and module.in_channels <= NARROW for module in flat
    )
    for module in net.modules():
        if isinstance(module, nn.Conv3d):
            module.weight.data = module.weight.data.contiguous(memory_format=torch.channels_last_3d)
        elif isinstance(module, nn.Conv2d) and not narrow:
            module.weight.data = module.weight.data.contiguous(memory_format=torch.channels_last)


def upsample(values: Tensor, factor: int) -> Tensor:
    """Return maps upsampled bilinearly, with old cell i at new pixel ``factor * i``.

    Strided convolutions put cell i at pixel ``factor * i``. `torch.nn.functional.interpolate` alone puts it at
    ``factor * (i + 1/2) - 1/2``, which is 1.5 px away at a factor of 4. Beyond the last cell its value is repeated.

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


def half_size(images: Tensor) -> Tensor:
    """Return images at half of their size, with new pixel i over old pixel ``2 i``.

    The mean of 1, 2 and 1 parts of three pixels in each direction; beyond the edge its pixels are repeated.

    Parameters
    ----------
    images : (B, C, H, W) Tensor
        H and W are even.

    Returns
    -------
    (B, C, H/2, W/2) Tensor
    """
    between = functional.avg_pool2d(functional.pad(images, (1, 1, 1, 1), mode="replicate"), 2, 1)  # (H + 1, W + 1)
    return functional.avg_pool2d(between, 2)


def convex_upsample(values: Tensor, logits: Tensor, factor: int) -> Tensor:
    """Return a map upsampled as a convex combination of the 3x3 nearest cells, with learnt weights for each pixel.

    Edges can stay sharp: a pixel can take the value of the side that it lies on. (Teed & Deng, "RAFT: Recurrent
    All-Pairs Field Transforms for Optical Flow", ECCV 2020, section 3.3.)

    Parameters
    ----------
    values : (B, 1, H, W) Tensor
        The map; beyond its edge the last value is repeated.
    logits : (B, 9 factor^2, H, W) Tensor
        Logits of the weights: for each of the nine cells, row by row, one for each new pixel of a cell.

    Returns
    -------
    (B, 1, factor H, factor W) Tensor
    """
    height, width = values.shape[-2:]
    padded = functional.pad(values, (1, 1, 1, 1), mode="replicate")
    near = functional.unfold(padded, 3).reshape(len(values), 9, 1, height, width)  # (B, 9, 1, H, W)
    weights = logits.unflatten(1, (9, factor * factor)).softmax(dim=1)  # (B, 9, factor^2, H, W)
    return functional.pixel_shuffle((weights * near).sum(1), factor)  # (B, 1, factor H, factor W)


def check_inputs(images: Tensor, world_T_camera: Tensor, K: Tensor, multiple: int = SIZE_MULTIPLE) -> None:
    """Raise InputError where the inputs of a network have wrong shapes.

    Parameters
    ----------
    images : (B, V, 3, H, W) Tensor
        V is 2 or more; H and W are multiples of `multiple`.
    world_T_camera : (B, V, 4, 4) Tensor
        Camera poses.
    K : (B, V, 3, 3) Tensor
        Intrinsic matrices.
    multiple : int
        Pixels of a cell of the network's coarsest features [px].
    """
    if images.ndim != 5 or images.shape[2] != 3:
        raise InputError("images", "shape (B, V, 3, H, W)", tuple(images.shape))
    batch, views, _, height, width = images.shape
    if views < 2:
        raise InputError("images", "two views or more", views)
    if height % multiple or width % multiple:
        expected = f"a height and a width that are multiples of {multiple} px"
        raise InputError("images", expected, f"{height} x {width}")
    if world_T_camera.shape != (batch, views, 4, 4):
        raise InputError("world_T_camera", f"shape {(batch, views, 4, 4)}", tuple(world_T_camera.shape))
    if K.shape != (batch, views, 3, 3):
        raise InputError("K", f"shape {(batch, views, 3, 3)}", tuple(K.shape))
