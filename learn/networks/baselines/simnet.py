"""SimNet: disparity, classes and oriented boxes of a rectified stereo pair.

(Laskey et al., "SimNet: Enabling Robust Unknown Object Manipulation from Pure Synthetic Data via Stereo", CoRL 2021.)
Its rule for layers is that of `reference_backbone`: every convolution has a bias, and before it a batch norm and a
leaky rectifier, except where it reads the input.

1. `_StereoFeatures`: 16 features of both eyes at 1/4 of the image size.
2. `correlation`: their mean products at disparities of 0, 1, 2 ... quarter-size pixels, processed as maps.
3. Soft argmin: the coarse disparity.
4. Its 32 features beside 32 of the left image, a dilated pyramid, and heads as in MVTrans.

What the released network does and the corrected one does not: 22 disparities whatever the camera; each eye stretched
to all values; upsampling a part of a cell off; unknown depth as a disparity; a random heatmap at first. Its generator
of targets was never released, and both variants here learn the targets of `targets.view`.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from ....core.errors import InputError
from ..decoders import DenseHead, FieldHead, Pyramid
from ..layers import check_inputs, initialise, upsample
from ..reference_backbone import DepthFeatures, DilatedPyramid
from .settings import SimNetSettings

#: Disparities of the released network: 90 px by 4, rounded down.
RELEASED_BINS = 22
#: Classes of the released network; ours are the first four.
CLASSES = 5
#: Mean and standard deviation of ImageNet's images in [0, 1].
_MEAN, _STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
#: Slope of the leaky rectifier for negative inputs: torch's default.
_LEAK = 0.01
#: Dilations of the residual layers at 1/16, and of those over the correlation.
_DEEP, _COST = (1, 2, 5, 9, 1, 2, 5, 9), (1, 2, 5, 9)
#: Channels of the features that are matched.
_MATCHED = 16
#: Features are at 1/4 of the image size.
_QUARTER = 4
#: Least disparity that is turned into a depth [px]: with KeyPose's camera 810 m.
MIN_DISPARITY = 0.1
#: Value of the vertex field where a corner lies at the pixel itself: 100 times a half (`targets.encoding`).
_VERTEX_CENTRE = 50.0


class SimNet(nn.Module):
    """SimNet: 14,443,282 parameters with 22 disparities.

    Parameters
    ----------
    settings : SimNetSettings
        With `bins`.
    released : bool
        Whether it is the released network, faults included.
    """

    mean: Tensor
    deviation: Tensor

    def __init__(self, settings: SimNetSettings, *, released: bool = False) -> None:
        super().__init__()
        bins = RELEASED_BINS if released else settings.bins
        if bins is None:
            raise InputError("network.simnet.bins", "a number of disparities", "none")
        self.bins, self.released = bins, released
        self.features = _StereoFeatures()
        self.cost = _Cost(bins)
        self.rgb_stem = nn.Sequential(nn.Conv2d(3, 32, 3, 2, 1), _activated(nn.Conv2d(32, 32, 3, 2, 1)))
        self.disparity_features = DepthFeatures()
        self.backbone = DilatedPyramid()
        self.disparity_head, self.heatmap_head, self.seg_head = DenseHead(1), DenseHead(1), DenseHead(CLASSES)
        self.vertex_head, self.z_centroid_head, self.covariance_head = FieldHead(16), FieldHead(1), FieldHead(6)
        self.register_buffer("mean", torch.tensor(_MEAN)[:, None, None], persistent=False)
        self.register_buffer("deviation", torch.tensor(_STD)[:, None, None], persistent=False)
        initialise(self)
        if not released:
            nn.init.zeros_(self.heatmap_head.predictor.weight)
            self.vertex_head.set_initial_output(_VERTEX_CENTRE)

    def forward(self, images: Tensor, world_T_camera: Tensor, K: Tensor) -> dict[str, Tensor]:
        """Return the predictions for the left eye.

        Parameters
        ----------
        images : (B, 2, 3, H, W) Tensor
            Left and right image in [0, 1]. H and W are multiples of 32.
        world_T_camera : (B, 2, 4, 4) Tensor
            Poses [m], from which the baseline follows.
        K : (B, 2, 3, 3) Tensor
            Intrinsic matrices [px].

        Returns
        -------
        dict of Tensor
            As of MVTrans, without offsets: ``seg`` (B, 5, H, W) logits, ``depth`` and ``heatmap`` (B, H, W),
            ``vertex``, ``z_centroid`` and ``covariance``; and ``disparity`` (B, H, W) and ``small_disparity``
            (B, H/4, W/4) in pixels of the full size, and ``focal_baseline`` (B,) [px m].
        """
        check_inputs(images, world_T_camera, K)
        if images.shape[1] != 2:
            raise InputError("images", "a stereo pair", f"{images.shape[1]} views")
        # The released network takes images that each eye's loader has stretched, in [0, 1].
        eyes = images if self.released else (images - self.mean) / self.deviation
        matched = self.features(eyes.flatten(0, 1).contiguous()).unflatten(0, images.shape[:2])
        small = self.cost(correlation(matched[:, 0], matched[:, 1], self.bins).float())  # (B, 1, H/4, W/4)
        joined = torch.cat([self.disparity_features(small), self.rgb_stem(eyes[:, 0])], dim=1)
        p2, p3, p4 = (functional.relu(level) for level in self.backbone(joined))
        disparity = self._full(self.disparity_head, (p2, p3, p4))[:, 0].float()
        focal_baseline = stereo_focal_baseline(world_T_camera, K)
        return {
            "seg": self._full(self.seg_head, (p2, p3, p4)).float(),
            "disparity": disparity,
            "small_disparity": _QUARTER * small[:, 0],
            "focal_baseline": focal_baseline,
            "depth": focal_baseline[:, None, None] / disparity.clamp_min(MIN_DISPARITY),
            "heatmap": self._full(self.heatmap_head, (p2, p3, p4))[:, 0].float(),
            "vertex": self.vertex_head((p2, p3, p4)).float(),
            "z_centroid": self.z_centroid_head((p2, p3, p4))[:, 0].float(),
            "covariance": self.covariance_head((p2, p3, p4)).float(),
        }

    def _full(self, head: DenseHead, pyramid: Pyramid) -> Tensor:
        return head(pyramid) if self.released else upsample(head.at_quarter(pyramid), _QUARTER)


def stereo_focal_baseline(world_T_camera: Tensor, K: Tensor) -> Tensor:
    """Return the focal length times the baseline of stereo pairs, (B,) [px m]: disparity times depth."""
    baseline = (world_T_camera[:, 1, :3, 3] - world_T_camera[:, 0, :3, 3]).norm(dim=1)
    return K[:, 0, 0, 0] * baseline


def correlation(left: Tensor, right: Tensor, bins: int) -> Tensor:
    """Return the mean products of left(x) and right(x - i) over channels, (B, bins, h, w), of (B, C, h, w) each.

    Outside of the right image they are 0.
    """
    width = left.shape[-1]
    maps = []
    for shift in range(bins):
        inside = max(width - shift, 0)
        product = (left[..., width - inside :] * right[..., :inside]).mean(1)
        maps.append(functional.pad(product, (width - inside, 0)))
    return torch.stack(maps, dim=1)


class _Residual(nn.Module):
    def __init__(self, channels: int, dilation: int, *, activated: bool = False) -> None:
        super().__init__()
        first = nn.Conv2d(channels, channels, 3, padding=dilation, dilation=dilation)
        second = nn.Conv2d(channels, channels, 3, padding=dilation, dilation=dilation)
        self.inner = nn.Sequential(first if activated else _activated(first), _activated(second))

    def forward(self, x: Tensor) -> Tensor:
        return x + self.inner(x)


class _StereoFeatures(nn.Module):
    """An image, (B, 3, H, W), to features that are matched, (B, 16, H/4, W/4)."""

    def __init__(self) -> None:
        super().__init__()
        self.enter = nn.Sequential(nn.Conv2d(3, 32, 3, 2, 1), _activated(nn.Conv2d(32, 32, 3, 2, 1)))
        self.quarter = nn.Sequential(*(_Residual(32, 1) for _ in range(3)))
        self.eighth = nn.Sequential(_activated(nn.Conv2d(32, 64, 3, 2, 1)), *(_Residual(64, 1) for _ in range(4)))
        deep = (_Residual(128, dilation) for dilation in _DEEP)
        self.sixteenth = nn.Sequential(_activated(nn.Conv2d(64, 128, 3, 2, 1)), *deep)
        self.laterals = nn.ModuleList(_activated(nn.Conv2d(channels, _MATCHED, 1)) for channels in (32, 64, 128))

    def forward(self, image: Tensor) -> Tensor:
        quarter = self.quarter(self.enter(image))
        eighth = self.eighth(quarter)
        fine, middle, coarse = self.laterals
        merged = _doubled(coarse(self.sixteenth(eighth))) + middle(eighth)
        return _doubled(merged) + fine(quarter)


class _Cost(nn.Module):
    """The correlation, (B, n, h, w), to the coarse disparity, (B, 1, h, w) [px of the features], by a soft argmin."""

    def __init__(self, bins: int) -> None:
        super().__init__()
        layers = [_Residual(bins, dilation, activated=not number) for number, dilation in enumerate(_COST)]
        self.layers = nn.Sequential(*layers, _activated(nn.Conv2d(bins, bins, 1)))

    def forward(self, volume: Tensor) -> Tensor:
        probability = (-self.layers(volume).float()).softmax(dim=1)
        shifts = torch.arange(volume.shape[1], device=volume.device, dtype=probability.dtype)
        return torch.einsum("bdhw,d->bhw", probability, shifts)[:, None]


def _activated(conv: nn.Conv2d) -> nn.Sequential:
    return nn.Sequential(nn.BatchNorm2d(conv.in_channels), nn.LeakyReLU(_LEAK), conv)


def _doubled(x: Tensor) -> Tensor:
    return functional.interpolate(x, scale_factor=2, mode="bilinear", align_corners=True)
