"""A part of a network that keeps none of its inner values for the backward pass and computes them again there.

(Chen et al., "Training Deep Nets with Sublinear Memory Cost", 2016.)
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

import torch
from torch import Tensor, nn
from torch.utils.checkpoint import checkpoint

_BatchNorm = nn.BatchNorm2d | nn.BatchNorm3d


def recomputed(part: nn.Module, x: Tensor) -> Tensor:
    """Return ``part(x)``; gradients, weights and statistics of batches are those of the plain call."""
    if not torch.is_grad_enabled():
        return part(x)

    def contexts() -> tuple[AbstractContextManager, AbstractContextManager]:
        return nullcontext(), _same_statistics(part)

    return checkpoint(part, x, use_reentrant=False, preserve_rng_state=False, context_fn=contexts)


@contextmanager
def _same_statistics(part: nn.Module) -> Iterator[None]:
    """Keep the running statistics, which the first pass has moved already."""
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
