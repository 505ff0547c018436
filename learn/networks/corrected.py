"""MVTrans as its paper describes it (Wang et al., "MVTrans: Multi-View Perception of Transparent Objects", ICRA 2023).

Features are matched between the views on planes over the data's own range of depth, with each sample's own cameras; the
rough depth that follows and the features of the reference go through a feature pyramid to the heads.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from ...core.errors import InputError
from .context import ContextDecoder
from .heads import DenseHead, FieldHead, Pyramid
from .inputs import check_inputs
from .layers import convex_enlarged, enlarged, initialise, soft_argmin
from .matching import MatchingVolume
from .matching_features import MatchingFeatures
from .pyramid import FeaturePyramid
from .recompute import recomputed
from .regularisation import Regularisation, windowed_expectation
from .resnet import ResNet
from .settings import NetworkSettings
from .sweep import plane_depths

#: Mean and standard deviation of ImageNet's pictures in [0, 1], which torchvision's weights were trained with.
_MEAN, _DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
#: Nothing, table, transparent object, opaque object.
CLASSES = 4
#: Pixels of a side of the square that one feature of the last map stands for.
_QUARTER = 4
#: Where the vertex field of an object of no size at its own pixel lies: 100 times a half (`targets.encoding`).
_VERTEX_CENTRE = 50.0


class CorrectedNetwork(nn.Module):
    """The corrected MVTrans.

    Parameters
    ----------
    settings : NetworkSettings
        With a `depth_range`.
    """

    mean: Tensor
    deviation: Tensor

    def __init__(self, settings: NetworkSettings) -> None:
        super().__init__()
        if settings.depth_range is None:
            raise InputError("depth_range", "the depths of the first and the last plane", "none")
        self.depth_range = settings.depth_range
        self.settings = settings
        self.features = MatchingFeatures(
            settings.feature_channels, settings.feature_width, settings.feature_blocks, settings.norm
        )
        self.matching = MatchingVolume(settings)
        self.context = ResNet(settings.context, width=settings.context_width)
        self.decoder = ContextDecoder(self.context.channels, settings.planes, settings.decoder_width, settings.norm)
        self.regularisation = Regularisation(self.matching.channels, settings.volume_channels, settings.norm)
        self.pyramid = FeaturePyramid(
            settings.feature_channels + 1, settings.pyramid_channels, settings.backbone_width, settings.norm
        )
        sizes = {"inputs": settings.pyramid_channels, "width": settings.head_channels, "kind": settings.head_norm}
        detail = _QUARTER**2
        self.seg_head, self.depth_head = DenseHead(CLASSES * detail, **sizes), DenseHead(10 * detail, **sizes)
        self.offset_head, self.heatmap_head = DenseHead(2, **sizes), DenseHead(1, **sizes)
        self.vertex_head, self.covariance_head = FieldHead(16, **sizes), FieldHead(6, **sizes)
        self.z_centroid_head = FieldHead(1, **sizes)
        self.register_buffer("mean", torch.tensor(_MEAN)[:, None, None], persistent=False)
        self.register_buffer("deviation", torch.tensor(_DEVIATION)[:, None, None], persistent=False)
        initialise(self)
        # The fine depth starts as a mean of the rough one; the field starts where its values lie.
        nn.init.zeros_(self.depth_head.predictor.weight)
        self.vertex_head.start(_VERTEX_CENTRE)

    def forward(
        self, images: Tensor, world_T_camera: Tensor, K: Tensor, depth_range: Tensor | None = None
    ) -> dict[str, Tensor]:
        """Return what the network sees.

        Parameters
        ----------
        images : (B, V, 3, H, W) Tensor
            Pictures in [0, 1]; the first of the V >= 2 views is the reference. H and W are multiples of 32.
        world_T_camera : (B, V, 4, 4) Tensor
            Poses [m].
        K : (B, V, 3, 3) Tensor
            Intrinsic matrices at full size [px].
        depth_range : (B, 2) Tensor, optional
            First and last plane of each sample [m], instead of the settings'.

        Returns
        -------
        dict of Tensor
            ``seg`` (B, 4, H, W), ``depth`` and ``heatmap`` (B, H, W), ``small_depth`` (B, H/4, W/4), ``vertex``
            (B, 16, H/8, W/8), ``z_centroid`` (B, H/8, W/8), ``covariance`` (B, 6, H/8, W/8), in the units of
            `targets.encoding`; ``offset`` (B, 2, H, W), from each pixel to its object's peak (right, down) over the
            picture's height; ``plane_logits`` (B, D, H/4, W/4) and ``planes`` (B, D) [m].
        """
        check_inputs(images, world_T_camera, K)
        pictures = ((images - self.mean) / self.deviation).contiguous()
        features = self._features(pictures.flatten(0, 1)).unflatten(0, images.shape[:2])
        planes = self._planes(images, depth_range)
        with torch.autocast(images.device.type, enabled=False):  # geometry keeps 32 bits
            volume = self.matching(features.float(), world_T_camera.float(), K.float(), planes)
        context = self.decoder.context(self.context(pictures[:, 0]))
        logits = self.regularisation(volume, context).float()
        small = self._depth(logits, planes)
        middle, half = planes.mean(1)[:, None, None, None], (planes[:, -1] - planes[:, 0])[:, None, None, None] / 2.0
        rough = (small[:, None] - middle) / half
        pyramid = self.pyramid(torch.cat([features[:, 0], rough.to(features)], dim=1))
        return {"small_depth": small, "plane_logits": logits, "planes": planes, **self._heads(pyramid, small)}

    def _features(self, pictures: Tensor) -> Tensor:
        if self.settings.recompute == "features":
            return recomputed(self.features, pictures)
        return self.features(pictures, self.settings.recompute == "early")

    def _planes(self, images: Tensor, depth_range: Tensor | None) -> Tensor:
        if depth_range is None:
            depth_range = torch.tensor(self.depth_range, device=images.device).expand(len(images), 2)
        return plane_depths(depth_range.float(), self.settings.planes, self.settings.spacing)

    def _depth(self, logits: Tensor, planes: Tensor) -> Tensor:
        if self.settings.readout == "soft":
            return soft_argmin(logits, planes)
        return windowed_expectation(logits, planes, self.settings.window)

    def _heads(self, pyramid: Pyramid, small: Tensor) -> dict[str, Tensor]:
        weights, finer = self.depth_head.quarter(pyramid).float().split((9 * _QUARTER**2, _QUARTER**2), dim=1)
        depth = convex_enlarged(small[:, None], weights, _QUARTER) + functional.pixel_shuffle(finer, _QUARTER)
        return {
            "seg": functional.pixel_shuffle(self.seg_head.quarter(pyramid), _QUARTER).float(),
            "depth": depth[:, 0],
            "heatmap": enlarged(self.heatmap_head.quarter(pyramid).float(), _QUARTER)[:, 0],
            "offset": enlarged(self.offset_head.quarter(pyramid).float(), _QUARTER),
            "vertex": self.vertex_head(pyramid).float(),
            "z_centroid": self.z_centroid_head(pyramid)[:, 0].float(),
            "covariance": self.covariance_head(pyramid).float(),
        }
