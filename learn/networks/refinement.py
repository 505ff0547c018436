"""Refinement of depth: matched once more at 1/2 of the image size, over a few planes around the depth found so far.

At 1/4 of the image size a cell of a small picture is several centimetres of depth. Here the right disparity is looked
for next to the one found, at steps of half a pixel or so of the half-size picture. (From coarse to fine, as in Gu et
al., "Cascade Cost Volume for High-Resolution Multi-View Stereo and Stereo Matching", CVPR 2020.)
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from .cost_volume import CostVolume
from .layers import conv_norm, convex_upsample, upsample
from .settings import NetworkSettings, Norm

#: The features that are matched lie over every second pixel.
_STRIDE = 2
#: Channels of the features that are matched, and groups of their correlation.
_FEATURES, _GROUPS = 16, 4
#: Planes to each side of the depth, and their distance as a fraction of that of the planes of the cost volume.
_SIDE, _STEP = 6, 0.25
#: Channels of the layers, and dilations of its residual blocks: together they see 31 half-size pixels.
_WIDTH, _DILATIONS = 32, (1, 2, 4)
#: The greatest correction of 1 / depth, as a multiple of the distance of the planes of the cost volume. More than the
#: planes span: glass can be found by its shape where what matches is the table behind it.
_GREATEST = 4.0
#: The least of 1 / depth that is left, as a fraction of it: it stays positive.
_LEAST = 0.25


class _Block(nn.Module):
    """A residual block of two convolutions."""

    def __init__(self, channels: int, dilation: int, kind: Norm) -> None:
        super().__init__()
        self.first = nn.Sequential(conv_norm(channels, channels, dilation=dilation, kind=kind), nn.ReLU(inplace=True))
        self.second = conv_norm(channels, channels, dilation=dilation, kind=kind)

    def forward(self, x: Tensor) -> Tensor:
        return torch.relu(x + self.second(self.first(x)))


class Refinement(nn.Module):
    """Corrects the depth of the reference view.

    Parameters
    ----------
    settings : NetworkSettings
        Of the network whose depth is refined.
    """

    def __init__(self, settings: NetworkSettings) -> None:
        super().__init__()
        kind = settings.norm
        self.features = nn.Sequential(
            conv_norm(3, _FEATURES, stride=_STRIDE, kind=kind),
            nn.ReLU(inplace=True),
            conv_norm(_FEATURES, _FEATURES, kind=kind),
            nn.ReLU(inplace=True),
            nn.Conv2d(_FEATURES, _FEATURES, 3, padding=1),
        )
        matched = {"matching": "group", "feature_channels": _FEATURES, "groups": _GROUPS}
        self.matching = CostVolume(settings.model_copy(update=matched), _STRIDE)
        self.reduce = nn.Conv2d(settings.pyramid_channels, _WIDTH, 1)
        inputs = (2 * _SIDE + 1) * _GROUPS + _FEATURES + _WIDTH + 1
        self.enter = nn.Sequential(conv_norm(inputs, _WIDTH, kind=kind), nn.ReLU(inplace=True))
        self.blocks = nn.Sequential(*(_Block(_WIDTH, dilation, kind) for dilation in _DILATIONS))
        self.correction = nn.Conv2d(_WIDTH, 1, 3, padding=1)
        self.upsampling = nn.Conv2d(_WIDTH, 9 * _STRIDE**2, 1)

    def start_at_zero(self) -> None:
        """Set the last layers so that a new refinement corrects nothing."""
        nn.init.zeros_(self.correction.weight)
        nn.init.zeros_(self.upsampling.weight)

    def forward(
        self, images: Tensor, world_T_camera: Tensor, K: Tensor, planes: Tensor, depth: Tensor, finest: Tensor
    ) -> Tensor:
        """Return the refined depth, (B, H, W) [m].

        Parameters
        ----------
        images : (B, V, 3, H, W) Tensor
            Normalised images; the first view is the reference.
        world_T_camera, K : (B, V, 4, 4) and (B, V, 3, 3) Tensor
            Poses [m], and intrinsic matrices at full size [px].
        planes : (B, D) Tensor
            Depths of the planes of the cost volume [m], ascending.
        depth : (B, H, W) Tensor
            Depth found so far [m].
        finest : (B, C, H/4, W/4) Tensor
            Finest features of the pyramid.
        """
        features = self.features(images.flatten(0, 1)).unflatten(0, images.shape[:2])  # (B, V, F, H/2, W/2)
        half = depth[..., ::_STRIDE, ::_STRIDE]  # (B, H/2, W/2)
        # Depth far in front of the planes is not inverted: a network that has learnt little can give 0 or less.
        half = half.clamp_min(0.5 * planes[:, :1, None])
        inverse = 1.0 / half
        step = ((1.0 / planes[:, 0] - 1.0 / planes[:, -1]) / (planes.shape[1] - 1))[:, None, None]  # (B, 1, 1)
        with torch.autocast(images.device.type, enabled=False):  # geometry needs 32 bits
            depths = planes_around(inverse.detach(), step)
            volume = self.matching(features.float(), world_T_camera.float(), K.float(), depths)  # (B, G, 13, H/2, W/2)
        match = volume.flatten(1, 2)
        relative = inverse.detach()[:, None] * planes[:, :1, None, None]
        x = torch.cat([match, features[:, 0].to(match), upsample(self.reduce(finest), 2).to(match), relative], dim=1)
        x = self.blocks(self.enter(x))
        shift = _GREATEST * step * torch.tanh(self.correction(x)[:, 0].float())
        refined = 1.0 / torch.maximum(inverse + shift, _LEAST * inverse)
        # Details of the depth at full size stay: what is upsampled is the correction.
        return depth + convex_upsample((refined - half)[:, None], self.upsampling(x).float(), _STRIDE)[:, 0]


def planes_around(inverse: Tensor, step: Tensor) -> Tensor:
    """Return depths, (B, 13, h, w) [m], at steps around 1 / depth, (B, h, w) [1/m]."""
    offsets = _STEP * torch.arange(-_SIDE, _SIDE + 1, device=inverse.device)[:, None, None]
    around = inverse[:, None] + offsets * step[:, None]  # (B, 13, h, w)
    return 1.0 / torch.maximum(around, _LEAST * inverse[:, None])
