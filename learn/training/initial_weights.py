"""Weights that a run begins with: those of another run, fitted to what the network has more than the trained one."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import torch
from torch import Tensor, nn

from ..networks.mvtrans import MVTrans
from ..networks.refinement import APPEARANCE, EVIDENCE
from ..networks.settings import NetworkSettings
from .checkpoint import TrainedWeights, load_weights
from .plane_weights import on_planes

#: Settings of a network that may differ from those of the weights with which a run begins.
MAY_DIFFER = ("depth_range", "planes", "recompute")
#: Settings that may ask for more than the weights have, and their values, each with all that those before it have.
MAY_GROW = {"refinement": ("none", "half", "semi_global"), "objects_at": ("full", "half")}
#: Tensors of a refinement that have more channels with more candidates: of the inputs, and of the outputs.
_ENTER, _CHOICE = "refinement.enter.0.0.weight", ("refinement.choice.weight", "refinement.choice.bias")
#: Parts by the first part of the names of their tensors.
_REFINEMENT, _MATCHING, _OBJECTS, _DEPTH = "refinement.", "features.", "object_features.", "depth_head."


def load_initial_weights(network: nn.Module, trained: TrainedWeights, where: Path) -> None:
    """Load the weights that a run begins with.

    They follow the network's planes. A refinement of depth that they do not have stays as it is, and one that gets more
    candidates begins with the weights for those it had. Where objects are found at half size for the first time, what
    recognises them gets the weights that it had at full size, and the head that upsamples depth, which sees other
    features now, stays as it is.
    """
    weights, own = dict(trained.weights), network.state_dict()
    if isinstance(network, MVTrans):
        weights = on_planes(weights, trained.settings.network, network.settings)
        refinement = _grown_refinement(_part(weights, _REFINEMENT), _part(own, _REFINEMENT))
        weights = {name: value for name, value in weights.items() if not name.startswith(_REFINEMENT)} | refinement
        weights = _objects_at_half(weights, own, trained.settings.network, network.settings)
    load_weights(network, weights, where)


def _grown_refinement(weights: Mapping[str, Tensor], own: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Return the weights of a refinement, with the network's own for candidates that they do not know.

    New evidence comes last among the inputs, and counts nothing at first; new candidates come last among the outputs.
    What the image shows is not seen with them.
    """
    if not weights or weights.keys() == own.keys():
        return dict(weights or own)
    enter = torch.zeros_like(own[_ENTER])
    kept = torch.cat([weights[_ENTER][:, :EVIDENCE], weights[_ENTER][:, EVIDENCE + APPEARANCE :]], dim=1)
    enter[:, : kept.shape[1]] = kept
    last = {name: torch.cat([weights[name], own[name][len(weights[name]) :]]) for name in _CHOICE}
    return {**{name: weights[name] for name in own}, _ENTER: enter, **last}


def _objects_at_half(
    weights: Mapping[str, Tensor], own: Mapping[str, Tensor], old: NetworkSettings, new: NetworkSettings
) -> dict[str, Tensor]:
    if old.objects_at == new.objects_at:
        return dict(weights)
    copied = {_OBJECTS + name.removeprefix(_MATCHING): value for name, value in _part(weights, _MATCHING).items()}
    kept = {name: value for name, value in weights.items() if not name.startswith(_DEPTH)}
    return kept | copied | _part(own, _DEPTH)


def _part(weights: Mapping[str, Tensor], prefix: str) -> dict[str, Tensor]:
    return {name: value for name, value in weights.items() if name.startswith(prefix)}
