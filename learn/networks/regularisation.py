"""From matches and context to a probability of each plane, and from there to depth."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from .layers import Norm, conv_norm_3d


class Regularisation(nn.Module):
    """3D convolutions over the volume; the context enters as one more channel, its map d at plane d.

    After the first convolutions an hourglass sees each place from farther away at an eighth of the cost. (The hourglass
    of PSMNet, CVPR 2018, table 1, with one level.)
    """

    def __init__(self, inputs: int, channels: int, kind: Norm) -> None:
        super().__init__()
        self.enter = nn.Sequential(conv_norm_3d(inputs, channels, kind=kind), nn.ReLU(inplace=True))
        self.join = nn.Sequential(conv_norm_3d(channels + 1, channels, kind=kind), nn.ReLU(inplace=True))
        self.down = nn.Sequential(conv_norm_3d(channels, 2 * channels, stride=2, kind=kind), nn.ReLU(inplace=True))
        self.inside = nn.Sequential(conv_norm_3d(2 * channels, 2 * channels, kind=kind), nn.ReLU(inplace=True))
        self.up = conv_norm_3d(2 * channels, channels, 1, kind=kind)
        self.leave = nn.Conv3d(channels, 1, 3, padding=1)

    def forward(self, volume: Tensor, context: Tensor) -> Tensor:
        """Return the logits of the planes, (B, D, h, w), of a volume, (B, C, D, h, w), and context, (B, D, h, w)."""
        joined = self.join(torch.cat([self.enter(volume), context[:, None]], dim=1))
        deep = self.up(self.inside(self.down(joined)))
        wide = functional.interpolate(deep, joined.shape[-3:], mode="trilinear", align_corners=False)
        return self.leave(torch.relu_(joined + wide))[:, 0]


def windowed_expectation(logits: Tensor, planes: Tensor, window: int) -> Tensor:
    """Return the expected depth round the likeliest plane, (B, h, w) [m].

    A pixel of glass has two true matches, its surface and what lies behind it; the mean of both is neither. So only the
    planes next to the likeliest take part.

    Parameters
    ----------
    logits : (B, D, h, w) Tensor
        Of the planes.
    planes : (B, D) Tensor
        Their depths [m].
    window : int
        Planes to each side of the likeliest one.
    """
    index = torch.arange(logits.shape[1], device=logits.device)[:, None, None]
    inside = (index - logits.argmax(1, keepdim=True)).abs() <= window
    probability = logits.masked_fill(~inside, float("-inf")).softmax(dim=1)
    return torch.einsum("bdhw,bd->bhw", probability, planes)
