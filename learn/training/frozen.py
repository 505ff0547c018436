"""Parts of a network that a run leaves as they are: their weights, and the statistics of their batch norms."""

from __future__ import annotations

from collections.abc import Iterable

from torch import nn

from ...core.errors import InputError
from ...core.setting_errors import suggest


def freeze(network: nn.Module, names: Iterable[str]) -> None:
    """Take the parts of a network that are named out of the training.

    Raises
    ------
    InputError
        Where there is no such part, or nothing is left to train.
    """
    parts = dict(network.named_children())
    for name in names:
        if name not in parts:
            raise InputError(
                "optimiser.frozen", f"parts of the network: {', '.join(parts)}{suggest(name, list(parts))}", name
            )
        parts[name].requires_grad_(False)
    if not any(parameter.requires_grad for parameter in network.parameters()):
        raise InputError("optimiser.frozen", "a part that is trained", "none")


def set_training_mode(network: nn.Module, frozen: Iterable[str]) -> None:
    """Set a network to training, but its frozen parts to evaluation: they normalise by their own statistics."""
    network.train()
    for name in frozen:
        network.get_submodule(name).train(False)
