"""Weights between those that a run began with and those that it ended with.

Fine-tuning on other data improves what these data show and forgets some of the rest. A mean of the weights before and
after it often keeps both. (Wortsman et al., "Robust fine-tuning of zero-shot models", CVPR 2022, section 3.)
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import torch
from torch import Tensor

from ...core.errors import InputError
from ...core.model import differences
from .checkpoint import Checkpoint, TrainedWeights, check_weights


def interpolated_weights(run: Checkpoint, before: TrainedWeights, alpha: float, where: Path) -> dict[str, Tensor]:
    """Return (1 - alpha) times the weights before a run, plus alpha times those of its checkpoint.

    Parameters
    ----------
    run : Checkpoint
        Its averaged weights are taken where it keeps them.
    before : TrainedWeights
        Of the same network.
    alpha : float
        0 to 1. Statistics of batch norms are interpolated as well; counters are the run's.
    where : Path
        Of the weights before, for messages.

    Raises
    ------
    InputError
        Where the networks differ.
    """
    network, other = (one.settings.network.model_dump(exclude={"recompute"}) for one in (run, before))
    for name, expected, found in differences(network, other):
        raise InputError(f"{where}: network.{name}", f"{expected}, as in the checkpoint", found)
    after = run.eval_weights()
    check_weights(after, before.weights, where)
    return {name: _between(before.weights, name, value, alpha) for name, value in after.items()}


def _between(before: Mapping[str, Tensor], name: str, after: Tensor, alpha: float) -> Tensor:
    return torch.lerp(before[name].to(after), after, alpha) if after.is_floating_point() else after
