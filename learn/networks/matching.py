"""From the features of several views to one volume: how well each pixel matches on each plane."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn

from ...core.errors import InputError
from .layers import conv_norm_3d, norm
from .settings import NetworkSettings
from .sweep import plane_grid, quarter_intrinsics, sampled, source_T_reference

#: Keeps the mean finite where no view sees a point.
_NO_VIEW = 1e-6


class Concatenation(nn.Module):
    """Features of reference and source side by side, mixed by 3D convolutions.

    The first, 1x1x1, convolution is split: of the reference it is computed once instead of on every plane, of the
    source before it is warped. Both give the numbers of the whole volume, because it is linear, as warping is.
    """

    def __init__(self, settings: NetworkSettings) -> None:
        super().__init__()
        features, self.channels = settings.feature_channels, settings.volume_channels
        self.reference = nn.Conv2d(features, self.channels, 1, bias=False)
        self.source = nn.Conv2d(features, self.channels, 1, bias=False)
        self.first = nn.Sequential(norm(settings.norm, self.channels, dims=3), nn.ReLU(inplace=True))
        self.second = conv_norm_3d(self.channels, self.channels, kind=settings.norm)

    def prepared(self, reference: Tensor, sources: Tensor) -> tuple[Tensor, Tensor]:
        """Return what is compared: of the reference, (B, C, h, w), and of the sources, (B, V - 1, C, h, w)."""
        return self.reference(reference), self.source(sources.flatten(0, 1)).unflatten(0, sources.shape[:2])

    def matched(self, reference: Tensor, warped: Tensor) -> Tensor:
        """Return the volume of one pair, (B, C, D, h, w)."""
        return torch.relu_(self.second(self.first(reference[:, :, None] + warped)))

    def similarity(self, reference: Tensor, warped: Tensor) -> Tensor:
        """Return how alike both are, (B, D, h, w): the scaled product of the features."""
        return torch.einsum("bchw,bcdhw->bdhw", reference, warped) / math.sqrt(self.channels)


class GroupCorrelation(nn.Module):
    """Products of features, averaged in groups of channels.

    (Guo et al., "Group-wise Correlation Stereo Network", CVPR 2019, eq. 3.)
    """

    def __init__(self, settings: NetworkSettings) -> None:
        super().__init__()
        if settings.feature_channels % settings.groups:
            raise InputError("groups", f"a divisor of feature_channels ({settings.feature_channels})", settings.groups)
        self.channels = self.groups = settings.groups

    def prepared(self, reference: Tensor, sources: Tensor) -> tuple[Tensor, Tensor]:
        """Return what is compared: the features themselves."""
        return reference, sources

    def matched(self, reference: Tensor, warped: Tensor) -> Tensor:
        """Return the volume of one pair, (B, G, D, h, w)."""
        left = reference.unflatten(1, (self.groups, -1))
        right = warped.unflatten(1, (self.groups, -1))
        return torch.einsum("bgchw,bgcdhw->bgdhw", left, right) / left.shape[2]

    def similarity(self, reference: Tensor, warped: Tensor) -> Tensor:
        """Return how alike both are, (B, D, h, w): the scaled product of the features."""
        return torch.einsum("bchw,bcdhw->bdhw", reference, warped) / math.sqrt(reference.shape[1])


class Visibility(nn.Module):
    """How much a pair is trusted at each pixel, from how sharp its match along the planes is.

    The entropy of the match, without a gradient, through four convolutions of 16, 16, 8 and 1 maps. (Cao et al.,
    "MVSFormer++: Revealing the Devil in Transformer's Details for Multi-View Stereo", ICLR 2024.)
    """

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            nn.Conv2d(1, 16, 3, padding=1),
            nn.ReLU(),
            nn.Conv2d(16, 16, 3, padding=1),
            nn.ReLU(),
            nn.Conv2d(16, 8, 3, padding=1),
            nn.ReLU(),
            nn.Conv2d(8, 1, 1),
            nn.Sigmoid(),
        )

    def forward(self, similarity: Tensor, seen: Tensor) -> Tensor:
        """Return weights in (0, 1), (B, 1, h, w), of a similarity and of what is seen, (B, D, h, w)."""
        # Unseen planes take no part; where none is seen the match is as unsure as it can be.
        logits = similarity.detach().float().masked_fill(~seen, -1e4)
        log_probability = logits.log_softmax(dim=1)
        entropy = -(log_probability.exp() * log_probability).sum(1, keepdim=True) / math.log(seen.shape[1])
        return self.layers(entropy)


class MatchingVolume(nn.Module):
    """Features and cameras of all views to the volume of the reference."""

    def __init__(self, settings: NetworkSettings) -> None:
        super().__init__()
        self.pair = Concatenation(settings) if settings.matching == "concat" else GroupCorrelation(settings)
        self.visibility = Visibility() if settings.fusion == "visibility" else None
        self.channels = self.pair.channels

    def forward(self, features: Tensor, world_T_camera: Tensor, K: Tensor, planes: Tensor) -> Tensor:
        """Return the volume, (B, C, D, h, w): a mean over the views that see a point; 0 where none does.

        Parameters
        ----------
        features : (B, V, C, h, w) Tensor
            Features of the views at a quarter of the pictures' size; the first is the reference.
        world_T_camera, K : (B, V, 4, 4) and (B, V, 3, 3) Tensor
            Poses [m], and intrinsic matrices at full size [px].
        planes : (B, D) Tensor
            Depths of the planes [m].
        """
        reference, sources = self.pair.prepared(features[:, 0], features[:, 1:])
        poses, small_K = source_T_reference(world_T_camera), quarter_intrinsics(K)
        height, width = sources.shape[-2:]
        total, weights = None, None
        for view, source in enumerate(sources.unbind(1)):
            with torch.no_grad():
                place = poses[:, view], small_K[:, 0], small_K[:, view + 1]
                pixels, seen = plane_grid(*place, planes, (height, width))
            warped = sampled(source.float(), pixels)
            weight = self._weight(reference, warped, seen)
            matched = weight * self.pair.matched(reference, warped)
            total = matched if total is None else total + matched
            weights = weight if weights is None else weights + weight
        assert total is not None
        assert weights is not None
        return total / (weights + _NO_VIEW)

    def _weight(self, reference: Tensor, warped: Tensor, seen: Tensor) -> Tensor:
        mask = seen[:, None].to(warped)
        if self.visibility is None:
            return mask
        return self.visibility(self.pair.similarity(reference, warped), seen)[:, :, None] * mask
