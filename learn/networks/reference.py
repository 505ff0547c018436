"""MVTrans as its authors released it, faults included, so that its checkpoints run and the difference can be measured.

The faults with the largest effect, each marked below:

1. Intrinsics are scaled by 1/4 twice before features at 1/4 of the image size are warped with them.
2. Images in [0, 1] are divided by 255 again.
3. Warped coordinates are normalised for one convention of `grid_sample` and sampled with the other, so features are up
   to half a pixel off; points behind a camera are projected like those in front of it.
4. Planes are 0.159 m apart, from 0.01 to 10 m, for every scene.
5. The intrinsics of the first sample are used for the whole batch.

Modules have the released names. Unused modules are kept, because checkpoints contain them.
"""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor, nn
from torch.nn import functional

from ...core.errors import InputError
from .cost_volume import soft_argmin
from .decoders import ContextDecoder, DenseHead, FieldHead, UpConv
from .layers import check_inputs, conv_norm_3d, initialise
from .matching_features import MatchingFeatures
from .reference_backbone import ReferenceBackbone
from .resnet import ResNet

#: Number of planes, and the depth of the first and the last [m] (fault 4).
PLANES, FIRST_PLANE, LAST_PLANE = 64, 0.01, 10.0
#: Channels of the matching features and of the cost volume.
CHANNELS = 32
#: Prefix that Lightning adds to every name of a released checkpoint.
_PREFIX = "model."
#: Smallest longer side at which the widest pooling gives two values an image, which batch norm needs in training [px].
_MIN_TRAINING_SIDE = 256
#: Keeps the division by depth finite [m].
_EPSILON = 1e-8


class _Semantic(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.encoder = ResNet("resnet50", classes=1000)


class _Regularisation(ContextDecoder):
    """Cost volume and context to the coarse depth; `key_layer`, `stereo_head0` and six other layers are unused."""

    def __init__(self) -> None:
        super().__init__((256, 512, 1024, 2048), PLANES)
        self.upconv_1_0, self.upconv_1_1 = UpConv(128, 32), UpConv(96, 32)
        self.upconv_0_0, self.upconv_0_1 = UpConv(32, 16), UpConv(16, 16)
        self.dispconv_1, self.dispconv_0 = nn.Conv2d(32, 1, 3, padding=1), nn.Conv2d(16, 1, 3, padding=1)
        self.dres0 = nn.Sequential(_conv(CHANNELS, CHANNELS), _conv(CHANNELS, CHANNELS))
        self.dres1 = nn.Sequential(_conv(CHANNELS, CHANNELS), _conv(CHANNELS, CHANNELS))
        self.dres2 = nn.Sequential(_conv(CHANNELS + 1, CHANNELS + 1))
        self.key_layer = nn.Sequential(conv_norm_3d(CHANNELS + 1, 16), nn.ReLU())
        self.value_layer = nn.Sequential(conv_norm_3d(CHANNELS + 1, 16), nn.Tanh())
        self.stereo_head0 = nn.Sequential(_conv(16, 16), nn.Conv3d(16, 1, 1))
        self.stereo_head1 = nn.Sequential(_conv(16, 16), nn.Conv3d(16, 1, 1))

    def forward(self, volume: Tensor, features: tuple[Tensor, ...], planes: Tensor) -> Tensor:
        """Return the coarse depth, (B, H/4, W/4) [m]."""
        context = self.context(features)[:, None]  # (B, 1, D, H/4, W/4)
        joined = torch.cat([context, self.dres1(self.dres0(volume))], dim=1)  # (B, 33, D, H/4, W/4)
        logits = self.stereo_head1(self.value_layer(self.dres2(joined)))[:, 0]  # (B, D, H/4, W/4)
        return soft_argmin(logits, planes.expand(len(logits), -1))


class _Head(nn.Module):
    def __init__(self, outputs: int) -> None:
        super().__init__()
        self.head = DenseHead(outputs)

    def forward(self, pyramid: tuple[Tensor, Tensor, Tensor]) -> Tensor:
        return self.head(pyramid)


class _PoseHead(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.heatmap_head = DenseHead(1)
        self.vertex_head, self.z_centroid_head, self.rotation_head = FieldHead(16), FieldHead(1), FieldHead(6)


class ReferenceMVTrans(nn.Module):
    """The released MVTrans: 49,749,487 parameters.

    Its fields have the released units: vertices times 100, covariance times 1000, and 100 (z - 1) for the negative
    depth z of the box centre [m].
    """

    planes: Tensor  #: (64,) [m]

    def __init__(self) -> None:
        super().__init__()
        self.matchingFeature = MatchingFeatures(CHANNELS, 32, (3, 16, 3, 3))
        self.semanticFeature = _Semantic()
        self.pre0 = conv_norm_3d(2 * CHANNELS, CHANNELS, 1)
        self.pre1 = _conv(CHANNELS, CHANNELS)
        self.pre2 = conv_norm_3d(CHANNELS, CHANNELS)
        self.CostRegNet = _Regularisation()
        self.multiviewBackbone = ReferenceBackbone()
        self.depth_head, self.seg_head, self.pose_head = _Head(1), _Head(3), _PoseHead()
        self.register_buffer("planes", torch.linspace(FIRST_PLANE, LAST_PLANE, PLANES), persistent=False)
        initialise(self)

    def forward(self, images: Tensor, world_T_camera: Tensor, K: Tensor) -> dict[str, Tensor]:
        """Return the released network's outputs.

        Parameters
        ----------
        images : (B, V, 3, H, W) Tensor
            Images in [0, 1]; the first of the V views is the reference. H and W are multiples of 32.
        world_T_camera : (B, V, 4, 4) Tensor
            Poses [m].
        K : (B, V, 3, 3) Tensor
            Intrinsic matrices at full size [px]; only that of the first sample and view is used.

        Returns
        -------
        dict of Tensor
            ``seg`` (B, 3, H, W), ``depth`` and ``heatmap`` (B, H, W), ``small_depth`` (B, H/4, W/4), ``vertex``
            (B, 16, H/8, W/8), ``z_centroid`` (B, H/8, W/8), ``covariance`` (B, 6, H/8, W/8).
        """
        check_inputs(images, world_T_camera, K)
        if self.training and len(images) == 1 and max(images.shape[-2:]) < _MIN_TRAINING_SIDE:
            found = f"one of {images.shape[-2]} x {images.shape[-1]} px"
            expected = f"two samples, or images of {_MIN_TRAINING_SIDE} px, to train the released network"
            raise InputError("images", expected, found)
        scaled = (2.0 * (images / 255.0) - 1.0).contiguous()  # fault 2
        features = [self.matchingFeature(view) for view in scaled.unbind(1)]  # V times (B, 32, H/4, W/4)
        with torch.autocast(images.device.type, enabled=False):  # geometry needs 32 bits
            projection = _projections(world_T_camera.float(), K[0, 0].float())
            warped = [
                _warp(source.float(), projection[:, view], self.planes)
                for view, source in enumerate(features[1:], start=1)
            ]
        volumes = [self._pair_volume(features[0], other) for other in warped]
        volume = torch.stack(volumes).mean(0)  # (B, 32, D, H/4, W/4)
        context = self.semanticFeature.encoder(scaled[:, 0])
        coarse = self.CostRegNet(volume, context, self.planes)  # (B, H/4, W/4)
        pyramid = self.multiviewBackbone(context[0], coarse[:, None])
        return {"small_depth": coarse, **self._heads(tuple(functional.relu(p) for p in pyramid))}

    def _pair_volume(self, reference: Tensor, warped: Tensor) -> Tensor:
        repeated = reference[:, :, None].expand_as(warped)  # (B, C, D, H/4, W/4)
        joined = self.pre0(torch.cat([repeated, warped], dim=1))
        return joined + self.pre2(self.pre1(joined))

    def _heads(self, pyramid: tuple[Tensor, ...]) -> dict[str, Tensor]:
        pose = self.pose_head
        return {
            "seg": self.seg_head(pyramid),
            "depth": self.depth_head(pyramid)[:, 0],
            "heatmap": pose.heatmap_head(pyramid)[:, 0],
            "vertex": pose.vertex_head(pyramid),
            "z_centroid": pose.z_centroid_head(pyramid)[:, 0],
            "covariance": pose.rotation_head(pyramid),
        }


def _conv(inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(*conv_norm_3d(inputs, outputs), nn.ReLU())


def _projections(world_T_camera: Tensor, K: Tensor) -> Tensor:
    """Return the matrices from homogeneous reference pixels times depth to the pixels of each view, (B, V, 4, 4)."""
    scaled = torch.eye(4, dtype=K.dtype, device=K.device)
    scaled[:3, :3] = K
    scaled[:2, :3] = K[:2] / 16.0  # faults 1 and 5: features are at 1/4 of the size
    pixel_T_world = scaled @ torch.linalg.inv(world_T_camera)
    return pixel_T_world @ torch.linalg.inv(pixel_T_world[:, :1])


def _warp(source: Tensor, projection: Tensor, planes: Tensor) -> Tensor:
    """Return the features of a source, (B, C, h, w), warped to the reference on each plane, (B, C, D, h, w)."""
    (batch, channels, height, width), count = source.shape, len(planes)
    with torch.no_grad():
        y, x = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
        pixels = torch.stack([x, y, torch.ones_like(x)]).reshape(1, 3, -1).to(source)
        rays = projection[:, :3, :3] @ pixels
        points = rays[:, :, None] * planes[:, None] + projection[:, :3, 3, None, None]  # (B, 3, D, h w)
        # Fault 3: the sign of depth is not tested, and -1 and 1 are computed as pixel centres but sampled as edges.
        u = points[:, 0] / (points[:, 2] + _EPSILON) / ((width - 1) / 2.0) - 1.0
        v = points[:, 1] / (points[:, 2] + _EPSILON) / ((height - 1) / 2.0) - 1.0
        u, v = (torch.where(value.abs() > 1.0, 2.0, value) for value in (u, v))
        grid = torch.stack([u, v], dim=-1).reshape(batch, count * height, width, 2)
    sampled = functional.grid_sample(source, grid, mode="bilinear", padding_mode="zeros", align_corners=False)
    return sampled.reshape(batch, channels, count, height, width)


def load_reference(state_dict: Mapping[str, Tensor], where: str = "state dict") -> ReferenceMVTrans:
    """Return the released network with the weights of a released checkpoint's state dict.

    Parameters
    ----------
    state_dict : mapping
        Names and tensors, with or without the checkpoints' prefix ``model.``.
    where : str
        Its source, for error messages.

    Returns
    -------
    ReferenceMVTrans
        In evaluation mode.

    Raises
    ------
    InputError
        Where a name or a shape differs from that of the released network.
    """
    given = {name.removeprefix(_PREFIX): value for name, value in state_dict.items()}
    network = ReferenceMVTrans()
    own = network.state_dict()
    for name in sorted(own.keys() | given.keys()):
        expected = tuple(own[name].shape) if name in own else "no such tensor"
        found = tuple(given[name].shape) if name in given else "none"
        if expected != found:
            raise InputError(f"{where}: {name}", f"{expected}", found)
    network.load_state_dict(given)
    return network.eval()
