"""Refinement of depth at 1/2 of the image size: a choice among depths that are precise in themselves.

A layer that predicts a correction has to be exact to a hundredth of its range, which it did not learn in ten thousand
steps. To choose is easier: candidates are planes close around the depth found so far, the depths at which the pictures
are most alike, the table's plane, and, where asked for, depths of semi-global matching (`fused_depth`). Their
probabilities give the depth, as in the cost volume. (From coarse to fine, as in Gu et al., "Cascade Cost Volume for
High-Resolution Multi-View Stereo and Stereo Matching", CVPR 2020.)
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from . import fused_depth
from .layers import conv_norm, convex_upsample, upsample
from .photometric import STRIDE, halved, local_contrast, photometric_similarity, seen_by_others, window_mean
from .plane_sweep import plane_depths
from .settings import NetworkSettings, Norm
from .table_plane import table_plane

#: Planes to each side of the depth found so far, their distance, and those of further ones [distances of the planes of
#: the cost volume]. Glass can be found by its shape where what matches is the table behind it, so some are far away.
_SIDE, _STEP, _FURTHER = 6, 0.25, (-4.0, -2.5, 2.5, 4.0)
#: Planes over the whole range, among which the most similar one is looked for.
_SEARCHED = 64
#: Windows over which similarity is averaged close around the depth, and over the whole range [half-size px].
_NEAR_WINDOWS, _SEARCH_WINDOWS = (3, 7), (5, 9)
#: Channels of the image features and of the layers, and dilations of its residual blocks.
_FEATURES, _WIDTH, _DILATIONS = 16, 32, (1, 2, 4, 8, 1)
#: Channels of the evidence, which come first, and then those of what the image shows: features of it and of the
#: pyramid. With fused depths these are left out: on scenes that no training saw, opaque things are 18.8 mm off without
#: them and 19.5 mm with them, glass 32.5 and 33.1 mm (40 pairs, after 200 steps on 168 scenes).
EVIDENCE = (2 * _SIDE + 1) * len(_NEAR_WINDOWS) + 3 * len(_SEARCH_WINDOWS) + 3
APPEARANCE = _FEATURES + _WIDTH
#: Logit of the depth found so far in a new network, where those of all others are 0, and of the candidates that may be
#: far from it.
_KEEP, _AWAY = 5.0, -3.0
#: Differences of inverse depth are seen up to this [4 distances of the planes].
_SEEN_SHIFT, _SHIFT_UNIT = 3.0, 4.0
#: The least of 1 / depth that is left, as a fraction of it: it stays positive.
_LEAST = 0.25


@dataclass(frozen=True, eq=False)
class Candidates:
    """Depths to choose from, and what tells about them, at 1/2 of the image size."""

    inverse: Tensor  #: (B, N, h, w) [1/m]
    evidence: Tensor  #: (B, C, h, w)
    of_fused: Tensor  #: (B, F, h, w), evidence about fused depths, the last candidates; F is 0 without them


class _Block(nn.Module):
    """A residual block of two convolutions."""

    def __init__(self, channels: int, dilation: int, kind: Norm) -> None:
        super().__init__()
        self.first = nn.Sequential(conv_norm(channels, channels, dilation=dilation, kind=kind), nn.ReLU(inplace=True))
        self.second = conv_norm(channels, channels, dilation=dilation, kind=kind)

    def forward(self, x: Tensor) -> Tensor:
        return torch.relu(x + self.second(self.first(x)))


class Refinement(nn.Module):
    """Chooses among depths close to and away from the depth of the reference view.

    Parameters
    ----------
    settings : NetworkSettings
        Of the network whose depth is refined.
    classes : int
        Semantic classes; class 1 is the table.
    """

    def __init__(self, settings: NetworkSettings, classes: int) -> None:
        super().__init__()
        kind = settings.norm
        near, away = 2 * _SIDE + 1, len(_SEARCH_WINDOWS) + 1
        self.fused = settings.refinement == "semi_global"
        fused = fused_depth.CANDIDATES if self.fused else 0
        if self.fused:
            inputs = EVIDENCE + classes + 1 + fused_depth.EVIDENCE
        else:
            inputs = EVIDENCE + APPEARANCE + classes + 1
            self.features = nn.Sequential(
                conv_norm(3, _FEATURES, stride=STRIDE, kind=kind),
                nn.ReLU(inplace=True),
                conv_norm(_FEATURES, _FEATURES, kind=kind),
                nn.ReLU(inplace=True),
            )
            self.reduce = nn.Conv2d(settings.pyramid_channels, _WIDTH, 1)
        self.enter = nn.Sequential(conv_norm(inputs, _WIDTH, kind=kind), nn.ReLU(inplace=True))
        self.blocks = nn.Sequential(*(_Block(_WIDTH, dilation, kind) for dilation in _DILATIONS))
        self.choice = nn.Conv2d(_WIDTH, near + len(_FURTHER) + away + fused, 3, padding=1)
        self.upsampling = nn.Conv2d(_WIDTH, 9 * STRIDE**2, 1)

    def keep_depth(self) -> None:
        """Set the last layers so that a new refinement prefers the depth found so far, and fused depths as much."""
        nn.init.zeros_(self.choice.weight)
        nn.init.zeros_(self.upsampling.weight)
        assert self.choice.bias is not None
        with torch.no_grad():
            self.choice.bias[_SIDE] = _KEEP
            away = 2 * _SIDE + 1 + len(_FURTHER)
            self.choice.bias[away : away + len(_SEARCH_WINDOWS) + 1] = _AWAY
            # Fused depths are near the depth found so far where the pictures do not tell another one.
            self.choice.bias[away + len(_SEARCH_WINDOWS) + 1 :] = _KEEP

    def forward(
        self,
        images: Tensor,
        normalised: Tensor,
        world_T_camera: Tensor,
        K: Tensor,
        planes: Tensor,
        depth: Tensor,
        finest: Tensor,
        seg: Tensor,
    ) -> Tensor:
        """Return the refined depth, (B, H, W) [m].

        Parameters
        ----------
        images, normalised : (B, V, 3, H, W) Tensor
            Images in [0, 1], and normalised; the first view is the reference.
        world_T_camera, K : (B, V, 4, 4) and (B, V, 3, 3) Tensor
            Poses [m], and intrinsic matrices at full size [px].
        planes : (B, D) Tensor
            Depths of the planes of the cost volume [m], ascending.
        depth : (B, H, W) Tensor
            Depth found so far [m].
        finest : (B, C, H/4, W/4) Tensor
            Finest features of the pyramid.
        seg : (B, classes, H, W) Tensor
            Logits of the semantic classes.
        """
        # Depth far in front of the planes is not inverted: a network that has learnt little can give 0 or less.
        half = depth[..., ::STRIDE, ::STRIDE].clamp_min(0.5 * planes[:, :1, None])  # (B, H/2, W/2)
        inverse = 1.0 / half
        classes = seg.float().softmax(1)[..., ::STRIDE, ::STRIDE]
        with torch.no_grad(), torch.autocast(images.device.type, enabled=False):  # geometry needs 32 bits
            seen = images.float(), world_T_camera.float(), K.float(), planes, inverse.detach()
            found = candidates(*seen, classes.detach()[:, 1], self.fused)
        relative = inverse.detach()[:, None] * planes[:, :1, None, None]
        about = [classes.detach(), relative, found.of_fused]
        if not self.fused:
            about = [self.features(normalised[:, 0]).float(), upsample(self.reduce(finest), STRIDE).float(), *about]
        x = self.blocks(self.enter(torch.cat([found.evidence, *about], dim=1)))
        probability = self.choice(x).float().softmax(1)
        # The gradient of the depth found so far passes as if what is chosen were added to it.
        chosen = (probability * found.inverse).sum(1) + (inverse - inverse.detach())
        refined = 1.0 / torch.maximum(chosen, _LEAST * inverse)
        # Details of the depth at full size stay: what is upsampled is the correction.
        return depth + convex_upsample((refined - half)[:, None], self.upsampling(x).float(), STRIDE)[:, 0]


def candidates(
    images: Tensor,
    world_T_camera: Tensor,
    K: Tensor,
    planes: Tensor,
    inverse: Tensor,
    table: Tensor,
    fused: bool = False,
) -> Candidates:
    """Return the depths to choose from.

    Parameters
    ----------
    images, world_T_camera, K, planes : Tensor
        As in `Refinement.forward`.
    inverse, table : (B, H/2, W/2) Tensor
        Inverse depth found so far [1/m], and the probability of the table.
    fused : bool
        Whether depths of semi-global matching that know of the depth found so far are among them (`fused_depth`).
    """
    step = ((1.0 / planes[:, 0] - 1.0 / planes[:, -1]) / (planes.shape[1] - 1))[:, None, None]  # (B, 1, 1)
    contrast = local_contrast(halved(images.flatten(0, 1))).unflatten(0, images.shape[:2])
    near = planes_around(inverse, step)
    alike = photometric_similarity(contrast, world_T_camera, K, near)
    evidence = [window_mean(alike, side) for side in _NEAR_WINDOWS]
    further = [inverse + offset * step for offset in _FURTHER]
    found, peaks = _most_similar(contrast, world_T_camera, K, planes)
    seen = seen_by_others(1.0 / inverse, world_T_camera, K, STRIDE)
    plane, support = table_plane(inverse[..., ::2, ::2], (seen * table)[..., ::2, ::2], step)
    plane = upsample(plane[:, None], 2)[:, 0]
    shifts = [((x - inverse) / (_SHIFT_UNIT * step)).clamp(-_SEEN_SHIFT, _SEEN_SHIFT) for x in (*found, plane)]
    evidence += [torch.stack([*shifts, *peaks, seen, support[:, None, None].expand_as(seen)], dim=1)]
    away, of_fused = [1.0 / near, torch.stack([*further, *found, plane], dim=1)], inverse[:, None][:, :0]
    if fused:
        more, of_fused = fused_depth.fused_depths(images, contrast, world_T_camera, K, planes, inverse, step)
        away.append(more)
    least = _LEAST * inverse[:, None]
    return Candidates(torch.maximum(torch.cat(away, dim=1), least), torch.cat(evidence, dim=1), of_fused)


def _most_similar(
    contrast: Tensor, world_T_camera: Tensor, K: Tensor, planes: Tensor
) -> tuple[list[Tensor], list[Tensor]]:
    """Return for each window the inverse depth at which the pictures are most alike, and how much there and above all.

    Each is (B, H/2, W/2); the second list has the greatest similarity and its distance from the mean for each window.
    """
    searched = plane_depths(torch.stack([planes[:, 0], planes[:, -1]], dim=1), _SEARCHED, "inverse")
    alike = photometric_similarity(contrast, world_T_camera, K, searched)
    found, peaks = [], []
    for side in _SEARCH_WINDOWS:
        smooth = window_mean(alike, side)
        greatest, index = smooth.max(1)
        found.append((1.0 / searched).gather(1, index.flatten(1)).reshape(index.shape))
        peaks += [greatest, greatest - smooth.mean(1)]
    return found, peaks


def planes_around(inverse: Tensor, step: Tensor) -> Tensor:
    """Return depths, (B, 13, h, w) [m], at steps around 1 / depth, (B, h, w) [1/m]."""
    offsets = _STEP * torch.arange(-_SIDE, _SIDE + 1, device=inverse.device)[:, None, None]
    around = inverse[:, None] + offsets * step[:, None]  # (B, 13, h, w)
    return 1.0 / torch.maximum(around, _LEAST * inverse[:, None])
