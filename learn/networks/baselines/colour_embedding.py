"""The colour branch of DenseFusion: a ResNet-18 without batch norm, pooled at four scales, embeds each pixel."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional

#: Channels of the embedding.
EMBEDDING = 32
#: Channels, stride and dilation of the four stages of two blocks.
_STAGES = ((64, 1, 1), (128, 2, 1), (256, 1, 2), (512, 1, 4))
#: Cells of each pooled map in both directions.
_POOLS = (1, 2, 3, 6)
#: Fractions of channels that are dropped in training.
_DROP_POOLED, _DROP = 0.3, 0.15
#: Classes of a classifier that the released checkpoints hold and nothing uses.
_UNUSED_CLASSES = 21


class ColourEmbedding(nn.Module):
    """Images to the logarithms of 32 probabilities for each pixel.

    Parameters
    ----------
    released : bool
        Whether the unused classifier is kept: 17,455,224 parameters instead of 17,384,035.
    """

    def __init__(self, *, released: bool = False) -> None:
        super().__init__()
        self.enter = nn.Conv2d(3, 64, 7, 2, 3, bias=False)
        blocks, inputs = [], 64
        for channels, stride, dilation in _STAGES:
            blocks += [_Block(inputs, channels, stride, 1), _Block(channels, channels, 1, dilation)]
            inputs = channels
        self.blocks = nn.Sequential(*blocks)
        self.pools = nn.ModuleList(nn.Conv2d(inputs, inputs, 1, bias=False) for _ in _POOLS)
        self.pooled = nn.Conv2d((len(_POOLS) + 1) * inputs, 1024, 1)
        self.up = nn.ModuleList(_Up(before, after) for before, after in ((1024, 256), (256, 64), (64, 64)))
        self.embed = nn.Conv2d(64, EMBEDDING, 1)
        if released:
            self.classifier = nn.Sequential(nn.Linear(256, 256), nn.ReLU(), nn.Linear(256, _UNUSED_CLASSES))
        for module in self.modules():
            if isinstance(module, nn.Conv2d) and module.bias is None:
                fan_out = module.kernel_size[0] * module.kernel_size[1] * module.out_channels
                nn.init.normal_(module.weight, std=math.sqrt(2.0 / fan_out))

    def forward(self, image: Tensor) -> Tensor:
        """Return the embedding, (B, 32, h, w), of images, (B, 3, h, w) with sides that are multiples of 8."""
        x = functional.max_pool2d(torch.relu(self.enter(image)), 3, 2, 1)
        x = self.blocks(x)  # (B, 512, h/8, w/8)
        size = x.shape[-2:]
        levels = [
            functional.interpolate(
                conv(functional.adaptive_avg_pool2d(x, cells)), size, mode="bilinear", align_corners=False
            )
            for cells, conv in zip(_POOLS, self.pools, strict=True)
        ]
        x = torch.relu(self.pooled(torch.cat([*levels, x], dim=1)))
        x = functional.dropout2d(x, _DROP_POOLED, self.training)
        for number, up in enumerate(self.up):
            x = up(x)
            if number < len(self.up) - 1:
                x = functional.dropout2d(x, _DROP, self.training)
        return self.embed(x).log_softmax(dim=1)


class _Block(nn.Module):
    def __init__(self, inputs: int, outputs: int, stride: int, dilation: int) -> None:
        super().__init__()
        self.first = nn.Conv2d(inputs, outputs, 3, stride, dilation, dilation, bias=False)
        self.second = nn.Conv2d(outputs, outputs, 3, 1, dilation, dilation, bias=False)
        other = stride != 1 or inputs != outputs
        self.shortcut = nn.Conv2d(inputs, outputs, 1, stride, bias=False) if other else None

    def forward(self, x: Tensor) -> Tensor:
        shortcut = x if self.shortcut is None else self.shortcut(x)
        return torch.relu(self.second(torch.relu(self.first(x))) + shortcut)


class _Up(nn.Module):
    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.conv, self.act = nn.Conv2d(inputs, outputs, 3, padding=1), nn.PReLU()

    def forward(self, x: Tensor) -> Tensor:
        doubled = functional.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)
        return self.act(self.conv(doubled))
