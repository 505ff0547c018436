"""The feature extractor of the matching branch: PSMNet's residual blocks and spatial pyramid pooling.

(Chang & Chen, "Pyramid Stereo Matching Network", CVPR 2018, table 1; pooling windows half as large, as in the released
MVTrans.) `recompute` is its gradient checkpointing.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.utils.checkpoint import checkpoint

from .layers import conv_norm
from .settings import Norm

#: Side of the average-pooling windows, on features at 1/4 of the image size [px].
POOLS = (32, 16, 8, 4)
_BatchNorm = nn.BatchNorm2d | nn.BatchNorm3d


class _Block(nn.Module):
    """A residual block of two convolutions, without a rectifier after the sum."""

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


class _Pool(nn.Module):
    """Average pooling with square windows, cut to the image where it is smaller."""

    def __init__(self, side: int) -> None:
        super().__init__()
        self.side = side

    def forward(self, x: Tensor) -> Tensor:
        height, width = x.shape[-2:]
        return functional.avg_pool2d(x, (min(self.side, height), min(self.side, width)))


class MatchingFeatures(nn.Module):
    """Images to features at 1/4 of their size.

    Parameters
    ----------
    outputs : int
        Channels of the features.
    width : int
        Channels of the first layers; later layers have two and four times as many.
    blocks : 4 int
        Residual blocks of the four layers.
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

    def forward(self, images: Tensor, recompute_early: bool = False) -> Tensor:
        """Return the features, (B, C, H/4, W/4), of images, (B, 3, H, W).

        With `recompute_early`, the first layers keep no activations for the backward pass: they hold half of the
        memory of the features, and take a small part of the time.
        """
        first = nn.Sequential(self.firstconv, self.layer1, self.layer2)
        early = recompute(first, images) if recompute_early else first(images)  # (B, 2 width, H/4, W/4)
        late = self.layer4(self.layer3(early))  # (B, 4 width, H/4, W/4)
        pooled = [self.get_submodule(f"branch{number}")(late) for number in range(len(POOLS), 0, -1)]
        size = late.shape[-2:]
        wide = [functional.interpolate(x, size, mode="bilinear", align_corners=False) for x in pooled]
        return self.lastconv(torch.cat([early, late, *wide], dim=1))  # 2 + 4 + 4 x 1 = 10 times width


def recompute(part: nn.Module, x: Tensor) -> Tensor:
    """Return ``part(x)`` with gradient checkpointing: activations are computed again in the backward pass.

    (Chen et al., "Training Deep Nets with Sublinear Memory Cost", 2016.) Gradients, weights and batch statistics are
    those of the plain call.
    """
    if not torch.is_grad_enabled():
        return part(x)

    def contexts() -> tuple[AbstractContextManager, AbstractContextManager]:
        return nullcontext(), _frozen_statistics(part)

    return checkpoint(part, x, use_reentrant=False, preserve_rng_state=False, context_fn=contexts)


@contextmanager
def _frozen_statistics(part: nn.Module) -> Iterator[None]:
    """Keep the running statistics, which the first forward pass has updated already."""
    norms = [module for module in part.modules() if isinstance(module, _BatchNorm)]
    before = [(norm.momentum, norm.num_batches_tracked) for norm in norms]
    for norm in norms:
        norm.momentum = 0.0
        norm.num_batches_tracked = None if norm.num_batches_tracked is None else norm.num_batches_tracked.clone()
    try:
        yield
    finally:
        for norm, (momentum, count) in zip(norms, before, strict=True):
            norm.momentum, norm.num_batches_tracked = momentum, count
