"""Decoders: the context decoder (a U-Net's), the feature pyramid, and the prediction heads over it.

Modules of the context decoder and of the heads are named as in the released checkpoints.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from .layers import conv_norm, norm
from .resnet import ResNet
from .settings import Norm

#: Features at 1/4, 1/8 and 1/16 of the image size.
Pyramid = tuple[Tensor, Tensor, Tensor]


class UpConv(nn.Module):
    """A convolution, its normalisation and a rectifier."""

    def __init__(self, inputs: int, outputs: int, kind: Norm = "batch") -> None:
        super().__init__()
        self.conv = nn.Sequential(*conv_norm(inputs, outputs, kind=kind), nn.ReLU(inplace=True))

    def forward(self, x: Tensor) -> Tensor:
        """Return (B, outputs, H, W) of (B, inputs, H, W)."""
        return self.conv(x)


class ContextDecoder(nn.Module):
    """ResNet features at 1/4 to 1/32 of the image size to one map per plane at 1/4.

    (The U-Net decoder of Godard et al., "Digging into Self-Supervised Monocular Depth Estimation", ICCV 2019.)

    Parameters
    ----------
    channels : 4 int
        Channels of the features, from the finest to the coarsest.
    outputs : int
        Number of maps.
    width : int
        Channels of the decoder at 1/4 of the image size; two and four times as many at 1/8 and 1/16.
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
        x = self.upconv_4_1(torch.cat([_upsample_nearest(self.upconv_4_0(x)), sixteenth], dim=1))  # H/16
        x = self.upconv_3_1(torch.cat([_upsample_nearest(self.upconv_3_0(x)), eighth], dim=1))  # H/8
        return self.upconv_2_1(torch.cat([_upsample_nearest(self.upconv_2_0(x)), quarter], dim=1))  # H/4


class FeaturePyramid(nn.Module):
    """ResNet-18 and a feature pyramid: maps at 1/4 of the image size to features at 1/4, 1/8 and 1/16.

    (Lin et al., "Feature Pyramid Networks for Object Detection", CVPR 2017, section 3.)

    Parameters
    ----------
    inputs : int
        Channels of the maps.
    outputs : int
        Channels of the features.
    width : int
        Channels of the first layer of the ResNet-18.
    """

    def __init__(self, inputs: int, outputs: int, width: int, kind: Norm) -> None:
        super().__init__()
        self.stem = nn.Sequential(conv_norm(inputs, width, kind=kind), nn.ReLU())
        self.resnet = ResNet("resnet18", stem=False, width=width)
        self.lateral = nn.ModuleList(nn.Conv2d(channels, outputs, 1) for channels in self.resnet.channels)
        self.smooth = nn.ModuleList(nn.Conv2d(outputs, outputs, 3, padding=1) for _ in range(3))

    def forward(self, x: Tensor) -> Pyramid:
        """Return the features, (B, outputs, h, w) each, the finest first, of (B, inputs, H/4, W/4)."""
        features = [lateral(level) for lateral, level in zip(self.lateral, self.resnet(self.stem(x)), strict=True)]
        merged = [features[3]]  # H/32; top-down from there
        for level in (2, 1, 0):
            merged.insert(0, features[level] + _upsample_nearest(merged[0]))
        p2, p3, p4 = (torch.relu(smooth(level)) for smooth, level in zip(self.smooth, merged[:3], strict=True))
        return p2, p3, p4


class _Conv(nn.Conv2d):
    """A 3x3 convolution without bias, its normalisation and a rectifier, in one module."""

    def __init__(self, inputs: int, outputs: int, kind: Norm) -> None:
        super().__init__(inputs, outputs, 3, padding=1, bias=False)
        self.norm = norm(kind, outputs)

    def forward(self, input: Tensor) -> Tensor:
        return functional.relu(self.norm(super().forward(input)))


class DenseHead(nn.Module):
    """A head over the feature pyramid whose maps are predicted at 1/4 of the image size.

    (Kirillov et al., "Panoptic Feature Pyramid Networks", CVPR 2019, section 3.1.)

    Parameters
    ----------
    outputs : int
        Number of maps.
    inputs, width : int
        Channels of the pyramid, and of the head.
    """

    def __init__(self, outputs: int, inputs: int = 64, width: int = 32, kind: Norm = "batch") -> None:
        super().__init__()
        self.p2 = nn.Sequential(_Conv(inputs, width, kind))
        self.p3 = nn.Sequential(_Conv(inputs, width, kind), _bilinear())
        self.p4 = nn.Sequential(_Conv(inputs, width, kind), _bilinear(), _Conv(width, width, kind), _bilinear())
        self.predictor = nn.Conv2d(width, outputs, 1)

    def at_quarter(self, pyramid: Pyramid) -> Tensor:
        """Return the maps at 1/4 of the image size, (B, outputs, H/4, W/4)."""
        p2, p3, p4 = pyramid
        return self.predictor(self.p2(p2) + self.p3(p3) + self.p4(p4))

    def forward(self, pyramid: Pyramid) -> Tensor:
        """Return the maps, upsampled to (B, outputs, H, W)."""
        return functional.interpolate(self.at_quarter(pyramid), scale_factor=4, mode="bilinear", align_corners=False)


class FieldHead(nn.Module):
    """A head whose maps are predicted at 1/8 of the image size; the parameters are those of `DenseHead`."""

    def __init__(self, outputs: int, inputs: int = 64, width: int = 32, kind: Norm = "batch") -> None:
        super().__init__()
        self.p3 = nn.Sequential(_Conv(inputs, width, kind))
        self.p4 = nn.Sequential(_Conv(inputs, width, kind), _bilinear())
        self.predictor = nn.Conv2d(width, outputs, 1)

    def set_initial_output(self, value: float) -> None:
        """Set the bias of the last layer, so that the maps of a new network start near a value."""
        assert self.predictor.bias is not None
        nn.init.constant_(self.predictor.bias, value)

    def forward(self, pyramid: Pyramid) -> Tensor:
        """Return the maps, (B, outputs, H/8, W/8)."""
        return self.predictor(self.p3(pyramid[1]) + self.p4(pyramid[2]))


class UpsamplingHead(nn.Module):
    """A head over matching features: for each cell of 4 x 4 pixels, what upsamples its depth.

    Parameters
    ----------
    inputs, outputs : int
        Channels of the features, and number of maps.
    """

    def __init__(self, inputs: int, outputs: int, width: int = 32, kind: Norm = "batch") -> None:
        super().__init__()
        self.enter = _Conv(inputs, width, kind)
        self.predictor = nn.Conv2d(width, outputs, 1)

    def forward(self, features: Tensor) -> Tensor:
        """Return the maps, (B, outputs, H/4, W/4), of features, (B, inputs, H/4, W/4)."""
        return self.predictor(self.enter(features))


def _upsample_nearest(x: Tensor) -> Tensor:
    return functional.interpolate(x, scale_factor=2, mode="nearest")


def _bilinear() -> nn.Module:
    return nn.Upsample(scale_factor=2, mode="bilinear", align_corners=False)
