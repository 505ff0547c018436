"""Weights of a network for other depth planes: what belongs to a plane follows the depth that it lies at."""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor

from ..networks.plane_sweep import plane_depths
from ..networks.settings import NetworkSettings

#: Weights of the last layer of the context decoder, which has a map for each plane, and of the first layer of the
#: feature pyramid, which sees these maps.
_MAPS, _STEM = "decoder.upconv_2_1.", "pyramid.stem.0.0.weight"


def on_planes(weights: Mapping[str, Tensor], old: NetworkSettings, new: NetworkSettings) -> dict[str, Tensor]:
    """Return weights of MVTrans for the planes of other settings.

    Each new plane takes the context map of the old one that is nearest (by 1 / depth), and what reads the maps reads
    copies by equal parts: a network with more planes, as far apart, finds the same where it did before. The coarse
    depth, which the pyramid sees over the range of the planes, keeps its scale.

    Parameters
    ----------
    weights : mapping of Tensor
        State dict.
    old, new : NetworkSettings
        Of the weights, and of the network that gets them.
    """
    if (old.depth_range, old.planes, old.spacing) == (new.depth_range, new.planes, new.spacing):
        return dict(weights)
    before, after = _depths(old), _depths(new)
    nearest = (1.0 / after[:, None] - 1.0 / before).abs().argmin(1)
    weight = 1.0 / torch.bincount(nearest, minlength=len(before))[nearest]
    found = {name: w[nearest] if name.startswith(_MAPS) and w.ndim else w for name, w in weights.items()}
    features = old.feature_channels
    matching, coarse, maps = weights[_STEM].split([features, 1, weights[_STEM].shape[1] - features - 1], dim=1)
    if old.heads_see_context:
        maps = maps[:, nearest] * weight.to(maps)[:, None, None]
    coarse = coarse * float((after[-1] - after[0]) / (before[-1] - before[0]))
    return found | {_STEM: torch.cat([matching, coarse, maps], dim=1)}


def _depths(settings: NetworkSettings) -> Tensor:
    assert settings.depth_range is not None  # of a network with weights
    return plane_depths(torch.tensor([settings.depth_range]), settings.planes, settings.spacing)[0]
