"""What one picture alone says of depth: the features of a residual network, decoded to one map per plane."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from .layers import Norm, conv_norm


class UpConv(nn.Module):
    """A convolution, its normalisation and a rectifier."""

    def __init__(self, inputs: int, outputs: int, kind: Norm = "batch") -> None:
        super().__init__()
        self.conv = nn.Sequential(*conv_norm(inputs, outputs, kind=kind), nn.ReLU(inplace=True))

    def forward(self, x: Tensor) -> Tensor:
        """Return (B, outputs, H, W) of (B, inputs, H, W)."""
        return self.conv(x)


class ContextDecoder(nn.Module):
    """Features at 1/4 to 1/32 of the size to one map per plane at 1/4.

    (A U-Net's decoder, as in Godard et al., "Digging into Self-Supervised Monocular Depth Estimation", ICCV 2019.)

    Parameters
    ----------
    channels : 4 int
        Channels of the features, the largest picture first.
    outputs : int
        Maps.
    width : int
        Channels of the decoder at a quarter of the size; two and four times as many at 1/8 and 1/16.
    """

    def __init__(self, channels: tuple[int, ...], outputs: int, width: int = 64, kind: Norm = "batch") -> None:
        super().__init__()
        self.upconv_4_0 = UpConv(channels[3], 4 * width, kind)
        self.upconv_4_1 = UpConv(4 * width + channels[2], 4 * width, kind)
        self.upconv_3_0 = UpConv(4 * width, 2 * width, kind)
        self.upconv_3_1 = UpConv(2 * width + channels[1], 2 * width, kind)
        self.upconv_2_0 = UpConv(2 * width, width, kind)
        self.upconv_2_1 = UpConv(width + channels[0], outputs, kind)

    def context(self, features: tuple[Tensor, ...]) -> Tensor:
        """Return the maps, (B, outputs, H/4, W/4)."""
        quarter, eighth, sixteenth, x = features
        x = self.upconv_4_1(torch.cat([_twice(self.upconv_4_0(x)), sixteenth], dim=1))
        x = self.upconv_3_1(torch.cat([_twice(self.upconv_3_0(x)), eighth], dim=1))
        return self.upconv_2_1(torch.cat([_twice(self.upconv_2_0(x)), quarter], dim=1))


def _twice(x: Tensor) -> Tensor:
    return functional.interpolate(x, scale_factor=2, mode="nearest")
