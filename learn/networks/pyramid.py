"""ResNet-18 and a feature pyramid over the reference's features and its rough depth.

(Lin et al., "Feature Pyramid Networks for Object Detection", CVPR 2017, section 3.)
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from .heads import Pyramid
from .layers import Norm, conv_norm
from .resnet import ResNet


class FeaturePyramid(nn.Module):
    """Maps at 1/4 of the size to features at 1/4, 1/8 and 1/16.

    Parameters
    ----------
    inputs : int
        Channels of the maps.
    outputs : int
        Channels of the features.
    width : int
        First channels of the ResNet-18.
    """

    def __init__(self, inputs: int, outputs: int, width: int, kind: Norm) -> None:
        super().__init__()
        self.stem = nn.Sequential(conv_norm(inputs, width, kind=kind), nn.ReLU())
        self.resnet = ResNet("resnet18", stem=False, width=width)
        self.lateral = nn.ModuleList(nn.Conv2d(channels, outputs, 1) for channels in self.resnet.channels)
        self.smooth = nn.ModuleList(nn.Conv2d(outputs, outputs, 3, padding=1) for _ in range(3))

    def forward(self, x: Tensor) -> Pyramid:
        """Return the features, (B, outputs, h, w) each, the largest first."""
        features = [lateral(level) for lateral, level in zip(self.lateral, self.resnet(self.stem(x)), strict=True)]
        merged = [features[3]]
        for level in (2, 1, 0):
            merged.insert(0, features[level] + functional.interpolate(merged[0], scale_factor=2, mode="nearest"))
        p2, p3, p4 = (torch.relu(smooth(level)) for smooth, level in zip(self.smooth, merged[:3], strict=True))
        return p2, p3, p4
