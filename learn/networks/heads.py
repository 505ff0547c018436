"""Heads over a feature pyramid: full resolution, and an eighth of it.

(Kirillov et al., "Panoptic Feature Pyramid Networks", CVPR 2019, section 3.1. Modules are named as in the released
checkpoints.)
"""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn import functional

from .layers import Norm, norm

#: Features at 1/4, 1/8 and 1/16 of the picture's size.
Pyramid = tuple[Tensor, Tensor, Tensor]


class _Conv(nn.Conv2d):
    """A 3x3 convolution without bias, its normalisation and a rectifier, in one module."""

    def __init__(self, inputs: int, outputs: int, kind: Norm) -> None:
        super().__init__(inputs, outputs, 3, padding=1, bias=False)
        self.norm = norm(kind, outputs)

    def forward(self, input: Tensor) -> Tensor:
        return functional.relu(self.norm(super().forward(input)))


def _twice() -> nn.Module:
    return nn.Upsample(scale_factor=2, mode="bilinear", align_corners=False)


class DenseHead(nn.Module):
    """Maps of the whole picture; computed at 1/4 of its size and then enlarged.

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
        self.p3 = nn.Sequential(_Conv(inputs, width, kind), _twice())
        self.p4 = nn.Sequential(_Conv(inputs, width, kind), _twice(), _Conv(width, width, kind), _twice())
        self.predictor = nn.Conv2d(width, outputs, 1)

    def quarter(self, pyramid: Pyramid) -> Tensor:
        """Return the maps at a quarter of the size, (B, n, H/4, W/4)."""
        p2, p3, p4 = pyramid
        return self.predictor(self.p2(p2) + self.p3(p3) + self.p4(p4))

    def forward(self, pyramid: Pyramid) -> Tensor:
        """Return the maps, (B, n, H, W)."""
        return functional.interpolate(self.quarter(pyramid), scale_factor=4, mode="bilinear", align_corners=False)


class FieldHead(nn.Module):
    """Maps at an eighth of the picture's size; the parameters are those of `DenseHead`."""

    def __init__(self, outputs: int, inputs: int = 64, width: int = 32, kind: Norm = "batch") -> None:
        super().__init__()
        self.p3 = nn.Sequential(_Conv(inputs, width, kind))
        self.p4 = nn.Sequential(_Conv(inputs, width, kind), _twice())
        self.predictor = nn.Conv2d(width, outputs, 1)

    def start(self, value: float) -> None:
        """Let the maps of a new network lie round a value."""
        assert self.predictor.bias is not None
        nn.init.constant_(self.predictor.bias, value)

    def forward(self, pyramid: Pyramid) -> Tensor:
        """Return the maps, (B, n, H/8, W/8)."""
        return self.predictor(self.p3(pyramid[1]) + self.p4(pyramid[2]))
