"""The cost volume of the plane sweep: built from the features of all views, regularised, and read as depth."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional

from ...core.errors import InputError
from .layers import conv_norm_3d, norm
from .plane_sweep import plane_sweep_grid, source_cameras, warp
from .settings import NetworkSettings, Norm

#: Keeps the mean over views finite where no view sees a point.
_MIN_WEIGHT = 1e-6


class ConcatMatching(nn.Module):
    """Features of reference and source concatenated, then mixed by 3D convolutions.

    The first, 1x1x1, convolution is split: its reference half runs once instead of on every plane, its source half
    before warping. The result equals that of the concatenated volume, because convolution and warping are linear.
    """

    def __init__(self, settings: NetworkSettings) -> None:
        super().__init__()
        features, self.channels = settings.feature_channels, settings.volume_channels
        self.reference = nn.Conv2d(features, self.channels, 1, bias=False)
        self.source = nn.Conv2d(features, self.channels, 1, bias=False)
        self.first = nn.Sequential(norm(settings.norm, self.channels, dims=3), nn.ReLU(inplace=True))
        self.second = conv_norm_3d(self.channels, self.channels, kind=settings.norm)

    def embeddings(self, reference: Tensor, sources: Tensor) -> tuple[Tensor, Tensor]:
        """Return what is matched: of the reference, (B, C, h, w), and of the sources, (B, V - 1, C, h, w)."""
        return self.reference(reference), self.source(sources.flatten(0, 1)).unflatten(0, sources.shape[:2])

    def volume(self, reference: Tensor, warped: Tensor) -> Tensor:
        """Return the cost volume of one pair, (B, C, D, h, w), of (B, C, h, w) and (B, C, D, h, w)."""
        return torch.relu_(self.second(self.first(reference[:, :, None] + warped)))

    def similarity(self, reference: Tensor, warped: Tensor) -> Tensor:
        """Return the scaled dot product of the features, (B, D, h, w)."""
        return torch.einsum("bchw,bcdhw->bdhw", reference, warped) / math.sqrt(self.channels)


class GroupCorrelation(nn.Module):
    """Group-wise correlation: products of features, averaged over groups of channels.

    (Guo et al., "Group-wise Correlation Stereo Network", CVPR 2019, eq. 3.)
    """

    def __init__(self, settings: NetworkSettings) -> None:
        super().__init__()
        if settings.feature_channels % settings.groups:
            raise InputError("groups", f"a divisor of feature_channels ({settings.feature_channels})", settings.groups)
        self.channels = self.groups = settings.groups

    def embeddings(self, reference: Tensor, sources: Tensor) -> tuple[Tensor, Tensor]:
        """Return what is matched: the features themselves."""
        return reference, sources

    def volume(self, reference: Tensor, warped: Tensor) -> Tensor:
        """Return the cost volume of one pair, (B, G, D, h, w), of (B, C, h, w) and (B, C, D, h, w)."""
        left = reference.unflatten(1, (self.groups, -1))  # (B, G, C/G, h, w)
        right = warped.unflatten(1, (self.groups, -1))  # (B, G, C/G, D, h, w)
        return torch.einsum("bgchw,bgcdhw->bgdhw", left, right) / left.shape[2]

    def similarity(self, reference: Tensor, warped: Tensor) -> Tensor:
        """Return the scaled dot product of the features, (B, D, h, w)."""
        return torch.einsum("bchw,bcdhw->bdhw", reference, warped) / math.sqrt(reference.shape[1])


class Visibility(nn.Module):
    """Weight of a source view at each pixel, from how sharp its match along the planes is.

    The entropy of the match, without a gradient, through four convolutions of 16, 16, 8 and 1 channels. (Cao et al.,
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

    def forward(self, similarity: Tensor, visible: Tensor) -> Tensor:
        """Return weights in (0, 1), (B, 1, h, w), of a similarity and a mask, (B, D, h, w) each."""
        # Planes outside the view are left out; where all are outside, the entropy is the greatest possible.
        logits = similarity.detach().float().masked_fill(~visible, -1e4)
        log_probability = logits.log_softmax(dim=1)
        entropy = -(log_probability.exp() * log_probability).sum(1, keepdim=True) / math.log(visible.shape[1])
        return self.layers(entropy)


class CostVolume(nn.Module):
    """Features and cameras of all views to the cost volume of the reference view.

    Parameters
    ----------
    settings : NetworkSettings
        Channels of the features, matching and fusion.
    stride : int
        Features are at 1/stride of the image size.
    """

    def __init__(self, settings: NetworkSettings, stride: int = 4) -> None:
        super().__init__()
        self.stride = stride
        self.pair = ConcatMatching(settings) if settings.matching == "concat" else GroupCorrelation(settings)
        self.visibility = Visibility() if settings.fusion == "visibility" else None
        self.channels = self.pair.channels

    def forward(self, features: Tensor, world_T_camera: Tensor, K: Tensor, planes: Tensor) -> Tensor:
        """Return the volume, (B, C, D, h, w): the weighted mean over the views that see a point; 0 where none does.

        Parameters
        ----------
        features : (B, V, C, h, w) Tensor
            Features of the views; the first view is the reference.
        world_T_camera, K : (B, V, 4, 4) and (B, V, 3, 3) Tensor
            Poses [m], and intrinsic matrices at full size [px].
        planes : (B, D) or (B, D, h, w) Tensor
            Depths of the planes [m], the same for all pixels or each pixel's own.
        """
        reference, sources = self.pair.embeddings(features[:, 0], features[:, 1:])
        cameras = source_cameras(world_T_camera, K, self.stride)
        height, width = sources.shape[-2:]
        total, weights = None, None
        for camera, source in zip(cameras, sources.unbind(1), strict=True):
            with torch.no_grad():
                pixels, visible = plane_sweep_grid(*camera, planes, (height, width))
            warped = warp(source.float(), pixels)  # (B, C, D, h, w)
            weight = self._weight(reference, warped, visible)  # (B, 1, D, h, w)
            weighted = weight * self.pair.volume(reference, warped)
            total = weighted if total is None else total + weighted
            weights = weight if weights is None else weights + weight
        assert total is not None
        assert weights is not None
        return total / (weights + _MIN_WEIGHT)

    def _weight(self, reference: Tensor, warped: Tensor, visible: Tensor) -> Tensor:
        mask = visible[:, None].to(warped)  # (B, 1, D, h, w)
        if self.visibility is None:
            return mask
        return self.visibility(self.pair.similarity(reference, warped), visible)[:, :, None] * mask


class Regularisation(nn.Module):
    """3D convolutions over the cost volume; the context joins as one more channel, its map d at plane d.

    After the first convolutions an hourglass widens the receptive field at 1/8 of the cost. (The hourglass of PSMNet,
    CVPR 2018, table 1, with one level.)
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
        """Return the plane logits, (B, D, h, w), of a volume, (B, C, D, h, w), and context, (B, D, h, w)."""
        joined = self.join(torch.cat([self.enter(volume), context[:, None]], dim=1))  # (B, C', D, h, w)
        deep = self.up(self.inside(self.down(joined)))  # (B, C', D/2, h/2, w/2)
        wide = functional.interpolate(deep, joined.shape[-3:], mode="trilinear", align_corners=False)
        return self.leave(torch.relu_(joined + wide))[:, 0]  # (B, 1, D, h, w) to (B, D, h, w)


def soft_argmin(logits: Tensor, planes: Tensor) -> Tensor:
    """Return the expected depth, (B, h, w) [m], of logits, (B, D, h, w), over planes, (B, D) [m].

    (Kendall et al., "End-to-End Learning of Geometry and Context for Deep Stereo Regression", ICCV 2017, eq. 1.)
    """
    return torch.einsum("bdhw,bd->bhw", logits.softmax(dim=1), planes)


def windowed_expectation(logits: Tensor, planes: Tensor, window: int) -> Tensor:
    """Return the expected depth over the planes around the most probable one, (B, h, w) [m].

    A pixel of glass has two true matches, its surface and what lies behind it, and the mean of both is neither. So only
    planes next to the most probable one are averaged.

    Parameters
    ----------
    logits : (B, D, h, w) Tensor
        Logits of the planes.
    planes : (B, D) Tensor
        Depths of the planes [m].
    window : int
        Planes to each side of the most probable one.
    """
    index = torch.arange(logits.shape[1], device=logits.device)[:, None, None]  # (D, 1, 1)
    inside = (index - logits.argmax(1, keepdim=True)).abs() <= window  # (B, D, h, w)
    probability = logits.masked_fill(~inside, float("-inf")).softmax(dim=1)
    return torch.einsum("bdhw,bd->bhw", probability, planes)
