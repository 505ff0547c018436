"""Features that are matched between views: residual blocks and spatial pyramid pooling.

(Chang & Chen, "Pyramid Stereo Matching Network", CVPR 2018, table 1; pools half as large, as in the released MVTrans.)
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from .layers import Norm, conv_norm
from .recompute import recomputed

#: Sides of the squares that are averaged, on the features at a quarter of the picture's size [px].
POOLS = (32, 16, 8, 4)


class _Block(nn.Module):
    """Two convolutions and a shortcut, without a rectifier after the sum."""

    def __init__(self, inputs: int, outputs: int, stride: int, dilation: int, kind: Norm) -> None:
        super().__init__()
        first = conv_norm(inputs, outputs, stride=stride, dilation=dilation, kind=kind)
        self.conv1 = nn.Sequential(first, nn.ReLU(inplace=True))
        self.conv2 = conv_norm(outputs, outputs, dilation=dilation, kind=kind)
        changes = stride != 1 or inputs != outputs
        self.downsample = conv_norm(inputs, outputs, 1, stride, kind=kind) if changes else None

    def forward(self, x: Tensor) -> Tensor:
        shortcut = x if self.downsample is None else self.downsample(x)
        return self.conv2(self.conv1(x)) + shortcut


class MatchingFeatures(nn.Module):
    """Pictures to features at a quarter of their size.

    Parameters
    ----------
    outputs : int
        Channels of the features.
    width : int
        Channels of the first layers; the later ones have two and four times as many.
    blocks : 4 int
        Residual blocks in the four layers.
    kind : str
        Normalisation.
    """

    def __init__(self, outputs: int, width: int, blocks: tuple[int, ...], kind: Norm = "batch") -> None:
        super().__init__()
        self.firstconv = nn.Sequential(
            conv_norm(3, width, stride=2, kind=kind),
            nn.ReLU(inplace=True),
            conv_norm(width, width, kind=kind),
            nn.ReLU(inplace=True),
            conv_norm(width, width, kind=kind),
            nn.ReLU(inplace=True),
        )
        self.layer1 = self._layer(width, width, blocks[0], 1, 1, kind)
        self.layer2 = self._layer(width, 2 * width, blocks[1], 2, 1, kind)
        self.layer3 = self._layer(2 * width, 4 * width, blocks[2], 1, 1, kind)
        self.layer4 = self._layer(4 * width, 4 * width, blocks[3], 1, 2, kind)
        for number, side in enumerate(POOLS, start=1):
            reduced = conv_norm(4 * width, width, 1, kind=kind)
            self.add_module(f"branch{number}", nn.Sequential(_Pool(side), reduced, nn.ReLU(inplace=True)))
        self.lastconv = nn.Sequential(
            conv_norm(10 * width, 4 * width, kind=kind),
            nn.ReLU(inplace=True),
            nn.Conv2d(4 * width, outputs, 1, bias=False),
        )

    @staticmethod
    def _layer(inputs: int, outputs: int, count: int, stride: int, dilation: int, kind: Norm) -> nn.Sequential:
        first = _Block(inputs, outputs, stride, dilation, kind)
        return nn.Sequential(first, *(_Block(outputs, outputs, 1, dilation, kind) for _ in range(count - 1)))

    def forward(self, pictures: Tensor, recompute: bool = False) -> Tensor:
        """Return the features, (B, C, H/4, W/4), of pictures, (B, 3, H, W).

        With `recompute`, the first layers keep nothing for the backward pass: they hold half of the features' memory,
        and take a small part of the time.
        """
        first = nn.Sequential(self.firstconv, self.layer1, self.layer2)
        early = recomputed(first, pictures) if recompute else first(pictures)
        late = self.layer4(self.layer3(early))
        pooled = [self.get_submodule(f"branch{number}")(late) for number in range(len(POOLS), 0, -1)]
        size = late.shape[-2:]
        wide = [functional.interpolate(x, size, mode="bilinear", align_corners=False) for x in pooled]
        return self.lastconv(torch.cat([early, late, *wide], dim=1))


class _Pool(nn.Module):
    """The mean over squares; over the whole of a side that is shorter than the square."""

    def __init__(self, side: int) -> None:
        super().__init__()
        self.side = side

    def forward(self, x: Tensor) -> Tensor:
        height, width = x.shape[-2:]
        return functional.avg_pool2d(x, (min(self.side, height), min(self.side, width)))
