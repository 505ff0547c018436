"""The backbone of the released network: dilated, pre-activated residual layers and a feature pyramid.

The paper calls it ResNet-18-FPN. The released code has the backbone of SimNet (Laskey et al., "SimNet: Enabling Robust
Unknown Object Manipulation from Pure Synthetic Data via Stereo", CoRL 2021), built by one rule: every convolution has a
bias, and is preceded by a batch norm and a leaky rectifier of its own, except where it reads the input of the backbone.
Modules are numbered as in the released checkpoints.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

#: Slope of the leaky rectifier for negative inputs: torch's default.
_LEAK = 0.01
#: Dilations of the residual layers at 1/4, 1/8 and 1/16 of the image size.
_DILATIONS = ((1, 1, 1), (1, 1, 1, 1), (1, 2, 5, 9, 1, 2, 5, 9))
_CHANNELS = (64, 128, 256)


class _NumberedLayers(nn.Module):
    """Layers numbered in the order in which they run, in a list with the released name ``modules``."""

    def __init__(self) -> None:
        super().__init__()
        # `modules` is also a method of every nn.Module, so it cannot be set as an attribute.
        self._modules["modules"] = nn.ModuleList()

    @property
    def _layers(self) -> nn.ModuleList:
        return self._modules["modules"]  # pyright: ignore[reportReturnType]

    def _add(self, conv: nn.Conv2d, *, activated: bool = False) -> int:
        """Append a batch norm and a convolution, or only a convolution; return the number of the convolution."""
        if not activated:
            before = nn.Sequential(nn.BatchNorm2d(conv.in_channels), nn.LeakyReLU(_LEAK))
            self._layers.append(before)
        self._layers.append(conv)
        return len(self._layers) - 1

    def _run(self, number: int, x: Tensor, *, activated: bool = False) -> Tensor:
        if not activated:
            x = self._layers[number - 1](x)
        return self._layers[number](x)


def _conv3(inputs: int, outputs: int, stride: int = 1, dilation: int = 1) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, 3, stride, dilation, dilation)


class DepthFeatures(_NumberedLayers):
    """The coarse depth as 32 maps: its 1x1 convolution plus two dilated convolutions, added to each map."""

    def __init__(self) -> None:
        super().__init__()
        self._add(nn.Conv2d(1, 32, 1))
        self._add(_conv3(1, 1, dilation=5))
        self._add(_conv3(1, 1, dilation=5))

    def forward(self, depth: Tensor) -> Tensor:
        """Return (B, 32, h, w) of a depth map, (B, 1, h, w) [m]."""
        return self._run(1, depth) + self._run(5, self._run(3, depth))


class DilatedPyramid(_NumberedLayers):
    """Maps at 1/4 of the image size to a pyramid of three sizes with 64 channels."""

    def __init__(self) -> None:
        super().__init__()
        self._pairs: list[list[tuple[int, int]]] = []
        self._strided: list[int] = []
        for level, (channels, dilations) in enumerate(zip(_CHANNELS, _DILATIONS, strict=True)):
            if level:
                self._strided.append(self._add(_conv3(_CHANNELS[level - 1], channels, stride=2)))
            pairs = []
            for index, rate in enumerate(dilations):
                first = self._add(_conv3(channels, channels, dilation=rate), activated=not (level or index))
                pairs.append((first, self._add(_conv3(channels, channels, dilation=rate))))
            self._pairs.append(pairs)
        self._p4 = self._add(nn.Conv2d(256, 64, 1))
        self._lateral = self._add(nn.Conv2d(128, 64, 1))
        self._top = self._add(nn.Conv2d(256, 64, 1))

    def forward(self, x: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return features at 1/4, 1/8 and 1/16 of the image size, (B, 64, h, w) each."""
        quarter = self._residual(0, x, activated=True)
        eighth = self._residual(1, self._run(self._strided[0], quarter))
        sixteenth = self._residual(2, self._run(self._strided[1], eighth))
        p4 = self._run(self._p4, sixteenth)
        p3 = _upsample_bilinear(self._run(self._top, sixteenth)) + self._run(self._lateral, eighth)
        return _upsample_bilinear(p3) + quarter, p3, p4

    def _residual(self, level: int, x: Tensor, *, activated: bool = False) -> Tensor:
        for index, (first, second) in enumerate(self._pairs[level]):
            inner = self._run(first, x, activated=activated and not index)
            x = x + self._run(second, inner)
        return x


def _upsample_bilinear(x: Tensor) -> Tensor:
    return functional.interpolate(x, scale_factor=2, mode="bilinear", align_corners=True)


class ReferenceBackbone(nn.Module):
    """Context features and coarse depth to a feature pyramid."""

    def __init__(self) -> None:
        super().__init__()
        self.rgbd_backbone = DilatedPyramid()
        self.reduce_channel = nn.Conv2d(256, 32, 1)
        self.disp_features = DepthFeatures()

    def forward(self, features: Tensor, depth: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return the pyramid of context features, (B, 256, H/4, W/4), and coarse depth, (B, 1, H/4, W/4)."""
        return self.rgbd_backbone(torch.cat([self.disp_features(depth), self.reduce_channel(features)], dim=1))
