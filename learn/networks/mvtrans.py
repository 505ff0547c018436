"""MVTrans as its paper describes it (Wang et al., "MVTrans: Multi-View Perception of Transparent Objects", ICRA 2023).

1. `matching_features`: features of every view, (B, V, C, H/4, W/4).
2. `plane_sweep`, `cost_volume`: features of the sources, warped over planes of the data's depth range with each
   sample's own cameras and fused to a cost volume, (B, C, D, H/4, W/4).
3. `resnet`, `decoders.ContextDecoder`: context of the reference image, (B, D, H/4, W/4).
4. `cost_volume.Regularisation`: plane logits, (B, D, H/4, W/4), and from them the coarse depth, (B, H/4, W/4).
5. `decoders.FeaturePyramid`: reference features, coarse depth (and context, where asked for) to features at 1/4, 1/8
   and 1/16.
6. `refinement`: where it is asked for, the full-size depth is matched once more, at 1/2 of the image size.
7. `decoders.DenseHead`, `decoders.FieldHead`: depth, classes, heatmap, offsets, vertices, centre depth, covariance.

Where objects are found at half size (`objects_at`), steps 3, 5 and the heads see the reference image at half of its
size: a pixel of disparity is half as far then, while things look as large to the heads as before. Step 5 has features
of its own, and depth is upsampled by those of matching. Outputs have the same sizes.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from ...core.errors import InputError
from .cost_volume import CostVolume, Regularisation, soft_argmin, windowed_expectation
from .decoders import ContextDecoder, DenseHead, FeaturePyramid, FieldHead, Pyramid, UpsamplingHead
from .efficientnet import EfficientNet
from .layers import check_inputs, convex_upsample, half_size, initialise, upsample
from .matching_features import MatchingFeatures, recompute
from .plane_sweep import plane_depths
from .refinement import Refinement
from .resnet import ResNet
from .settings import SIZE_MULTIPLE, NetworkSettings

#: Mean and standard deviation of ImageNet's images in [0, 1], with which torchvision's weights were trained.
_MEAN, _STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
#: Background, table, transparent object, opaque object.
CLASSES = 4
#: Features of the finest level are at 1/4 of the image size.
_QUARTER = 4
#: Value of the vertex field where a corner lies at the pixel itself: 100 times a half (`targets.encoding`).
_VERTEX_CENTRE = 50.0
#: The depth z of a box centre is encoded as 100 (z - 1 m) (`targets.encoding`).
_Z_SCALE, _Z_MIDDLE = 100.0, 1.0


class MVTrans(nn.Module):
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
        self.features = _features_of(settings)
        self.matching = CostVolume(settings)
        if settings.context == "efficientnet-lite0":
            self.context = EfficientNet()
        else:
            self.context = ResNet(settings.context, width=settings.context_width)
        self.decoder = ContextDecoder(self.context.channels, settings.planes, settings.decoder_width, settings.norm)
        self.regularisation = Regularisation(self.matching.channels, settings.volume_channels, settings.norm)
        at_half = settings.objects_at == "half"
        self.scale = 2 if at_half else 1  # of the images, over that of those in which objects are found
        self.object_features = _features_of(settings) if at_half else None
        seen = settings.feature_channels + 1 + (settings.planes if settings.heads_see_context else 0)
        self.pyramid = FeaturePyramid(seen, settings.pyramid_channels, settings.backbone_width, settings.norm)
        sizes = {"inputs": settings.pyramid_channels, "width": settings.head_channels, "kind": settings.head_norm}
        detail = _QUARTER**2
        self.seg_head = DenseHead(CLASSES * detail, **sizes)
        if at_half:
            sees = settings.feature_channels + 1 + settings.pyramid_channels
            self.depth_head = UpsamplingHead(sees, 10 * detail, settings.head_channels, settings.head_norm)
        else:
            self.depth_head = DenseHead(10 * detail, **sizes)
        self.offset_head, self.heatmap_head = DenseHead(2, **sizes), DenseHead(1, **sizes)
        self.vertex_head, self.covariance_head = FieldHead(16, **sizes), FieldHead(6, **sizes)
        self.z_centroid_head = FieldHead(1, **sizes)
        self.refinement = Refinement(settings, CLASSES) if settings.refinement != "none" else None
        self.register_buffer("mean", torch.tensor(_MEAN)[:, None, None], persistent=False)
        self.register_buffer("deviation", torch.tensor(_STD)[:, None, None], persistent=False)
        initialise(self)
        # At first the fine depth is the mean of the coarse depth around it, vertices lie at their own pixel, and there
        # is no heat: nearly all of its target is 0, and a random map would be most of the loss for many steps. The
        # centre of a box lies where its surface does.
        nn.init.zeros_(self.depth_head.predictor.weight)
        nn.init.zeros_(self.heatmap_head.predictor.weight)
        if settings.box_depth == "coarse":
            nn.init.zeros_(self.z_centroid_head.predictor.weight)
        if self.refinement is not None:
            self.refinement.keep_depth()
        self.vertex_head.set_initial_output(_VERTEX_CENTRE)

    def forward(
        self, images: Tensor, world_T_camera: Tensor, K: Tensor, depth_range: Tensor | None = None
    ) -> dict[str, Tensor]:
        """Return the predictions for the reference view.

        Parameters
        ----------
        images : (B, V, 3, H, W) Tensor
            Images in [0, 1]; the first of the V >= 2 views is the reference. H and W are multiples of 32, of 64 where
            objects are found at half size.
        world_T_camera : (B, V, 4, 4) Tensor
            Poses [m].
        K : (B, V, 3, 3) Tensor
            Intrinsic matrices at full size [px].
        depth_range : (B, 2) Tensor, optional
            First and last plane of each sample [m]; by default that of the settings.

        Returns
        -------
        dict of Tensor
            ``seg`` (B, 4, H, W) logits, ``depth`` and ``heatmap`` (B, H, W), ``small_depth`` (B, H/4, W/4), ``vertex``
            (B, 16, H/8, W/8), ``z_centroid`` (B, H/8, W/8), ``covariance`` (B, 6, H/8, W/8), in the units of
            `targets.encoding`; ``offset`` (B, 2, H, W), from each pixel to the peak of its object (right, down),
            divided by the image height; ``plane_logits`` (B, D, H/4, W/4) and ``planes`` (B, D) [m]; with
            refinement, also ``unrefined_depth`` (B, H, W).
        """
        check_inputs(images, world_T_camera, K, self.scale * SIZE_MULTIPLE)
        normalised = ((images - self.mean) / self.deviation).contiguous()  # (B, V, 3, H, W)
        # Views are part of the batch here: (B V, 3, H, W) to (B V, C, H/4, W/4), and back to (B, V, C, H/4, W/4).
        features = self._features(normalised.flatten(0, 1)).unflatten(0, images.shape[:2])
        planes = self._planes(images, depth_range)  # (B, D)
        with torch.autocast(images.device.type, enabled=False):  # geometry needs 32 bits
            volume = self.matching(features.float(), world_T_camera.float(), K.float(), planes)  # (B, C, D, H/4, W/4)
        reference = normalised[:, 0] if self.scale == 1 else half_size(normalised[:, 0])
        context = self.decoder.context(self.context(reference))  # (B, D, h, w): H/4, W/4 over the scale
        logits = self.regularisation(volume, self._at_full(context)).float()  # (B, D, H/4, W/4)
        coarse = self._coarse_depth(logits, planes)  # (B, H/4, W/4)
        # The coarse depth enters the pyramid as one more channel, in [-1, 1] over the range of the planes.
        middle, half = planes.mean(1)[:, None, None, None], (planes[:, -1] - planes[:, 0])[:, None, None, None] / 2.0
        relative = ((coarse[:, None] - middle) / half).to(features)  # (B, 1, H/4, W/4)
        pyramid = self._pyramid(features[:, 0], reference, relative, context)
        finest = self._at_full(pyramid[0])  # (B, C, H/4, W/4)
        depth, surface = self._fine_depth(pyramid, finest, features[:, 0], relative, coarse), coarse
        seg = self._classes(pyramid)
        found = {"small_depth": coarse, "plane_logits": logits, "planes": planes, "depth": depth, "seg": seg}
        if self.refinement is not None:
            views = images, normalised, world_T_camera, K
            refined = self.refinement(*views, planes, depth, finest, seg)
            found |= {"depth": refined, "unrefined_depth": depth}
            surface = refined[..., ::_QUARTER, ::_QUARTER]
        return found | self._heads(pyramid, surface)

    def _at_full(self, maps: Tensor) -> Tensor:
        """Return maps of the size at which objects are found, upsampled to that of matching."""
        return maps if self.scale == 1 else upsample(maps, self.scale)

    def _features(self, images: Tensor, network: MatchingFeatures | None = None) -> Tensor:
        network = network or self.features
        if self.settings.recompute == "features":
            return recompute(network, images)
        return network(images, self.settings.recompute == "early")

    def _pyramid(self, features: Tensor, reference: Tensor, relative: Tensor, context: Tensor) -> Pyramid:
        """Return what the heads see, of matching features, (B, C, H/4, W/4), and the image in which objects are."""
        if self.object_features is not None:
            features = self._features(reference, self.object_features)
        seen = [features, relative[..., :: self.scale, :: self.scale]]
        if self.settings.heads_see_context:
            seen.append(context.to(features))
        return self.pyramid(torch.cat(seen, dim=1))

    def _planes(self, images: Tensor, depth_range: Tensor | None) -> Tensor:
        if depth_range is None:
            depth_range = torch.tensor(self.depth_range, device=images.device).expand(len(images), 2)
        return plane_depths(depth_range.float(), self.settings.planes, self.settings.spacing)

    def _coarse_depth(self, logits: Tensor, planes: Tensor) -> Tensor:
        if self.settings.readout == "soft":
            return soft_argmin(logits, planes)
        return windowed_expectation(logits, planes, self.settings.window)

    def _fine_depth(
        self, pyramid: Pyramid, finest: Tensor, features: Tensor, relative: Tensor, coarse: Tensor
    ) -> Tensor:
        """Return the depth at full size, (B, H, W) [m], of the coarse one, (B, H/4, W/4)."""
        # (B, 160, H/4, W/4): for each of the 16 pixels of a cell, 9 weights of convex upsampling and a residual.
        if isinstance(self.depth_head, UpsamplingHead):
            maps = self.depth_head(torch.cat([features, relative, finest.to(features)], dim=1))
        else:
            maps = self.depth_head.at_quarter(pyramid)
        weights, residual = maps.float().split((9 * _QUARTER**2, _QUARTER**2), dim=1)
        depth = convex_upsample(coarse[:, None], weights, _QUARTER) + functional.pixel_shuffle(residual, _QUARTER)
        return depth[:, 0]

    def _classes(self, pyramid: Pyramid) -> Tensor:
        """Return the logits of the semantic classes, (B, 4, H, W)."""
        # (B, 4 x 16, H/4, W/4) to (B, 4, H, W): sub-pixel convolution.
        return self._at_full(functional.pixel_shuffle(self.seg_head.at_quarter(pyramid), _QUARTER).float())

    def _heads(self, pyramid: Pyramid, surface: Tensor) -> dict[str, Tensor]:
        """Return what heads find, but depth and classes; `surface` is the depth known best, (B, H/4, W/4) [m]."""
        cell = _QUARTER * self.scale
        return {
            "heatmap": upsample(self.heatmap_head.at_quarter(pyramid).float(), cell)[:, 0],
            "offset": upsample(self.offset_head.at_quarter(pyramid).float(), cell),
            "vertex": self._at_full(self.vertex_head(pyramid).float()),
            "z_centroid": self._box_depth(self._at_full(self.z_centroid_head(pyramid).float())[:, 0], surface),
            "covariance": self._at_full(self.covariance_head(pyramid).float()),
        }

    def _box_depth(self, found: Tensor, surface: Tensor) -> Tensor:
        """Return the encoded depth of box centres, (B, H/8, W/8).

        A box's centre lies within a few centimetres of its surface, whose depth was found by matching. What is learnt
        here does not change that depth.
        """
        if self.settings.box_depth == "absolute":
            return found
        return found + _Z_SCALE * (surface[..., ::2, ::2].detach() - _Z_MIDDLE)


def _features_of(settings: NetworkSettings) -> MatchingFeatures:
    blocks = settings.feature_blocks
    return MatchingFeatures(settings.feature_channels, settings.feature_width, blocks, settings.norm)
