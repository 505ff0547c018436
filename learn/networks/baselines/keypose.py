"""KeyPose: 3D keypoints of an object in a window of a rectified stereo pair.

(Liu et al., "KeyPose: Multi-View 3D Labeling and Keypoint Estimation for Transparent Objects", CVPR 2020.) Both eyes
are stacked to six channels. Fourteen 3x3 convolutions with dilations see 257 pixels at full size; a head gives the
position of each keypoint in the left window, and its disparity.

What the released network does and the corrected one does not: it takes blue for red; and its batch norm keeps 0.999 of
its averages a step, so that after 1,000 steps a third of them is what it began with.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from ....core.errors import InputError
from ..layers import initialise
from .settings import KeyPoseSettings

#: Dilations of the convolutions.
DILATIONS = (1, 1, 2, 4, 8, 16, 32, 1, 2, 4, 8, 16, 32, 1)
#: Pixels of the picture that one output sees, in each direction.
RECEPTIVE_FIELD = 1 + 2 * sum(DILATIONS)
#: Channels of the regression head.
_HEAD = 64
#: Slope of the leaky rectifier, and what keeps the batch norm finite (released code).
_LEAK, _EPSILON = 0.1, 1e-8
#: Fraction of its averages that the released batch norm replaces in a step, and torch's default.
_RELEASED_MOMENTUM, _MOMENTUM = 0.001, 0.1
#: Mean and standard deviation of ImageNet's images in [0, 1].
_MEAN, _STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)


class KeyPose(nn.Module):
    """KeyPose: 280,323 parameters with the regression head and one keypoint, 195 more for each further one.

    Parameters
    ----------
    settings : KeyPoseSettings
        With `count`.
    released : bool
        Whether it is the released network, faults included.
    """

    mean: Tensor
    deviation: Tensor

    def __init__(self, settings: KeyPoseSettings, *, released: bool = False) -> None:
        super().__init__()
        if settings.count is None:
            raise InputError("network.keypose.count", "a number of keypoints", "none")
        self.count, self.released, filters = settings.count, released, settings.filters
        momentum = _RELEASED_MOMENTUM if released else _MOMENTUM
        layers = []
        for number, rate in enumerate(DILATIONS):
            conv = nn.Conv2d(6 if number == 0 else filters, filters, 3, padding=rate, dilation=rate, bias=False)
            layers += [conv, _OffsetNorm(filters, momentum), nn.LeakyReLU(_LEAK)]
        self.features = nn.Sequential(*layers)
        if settings.head == "regression":
            head = []
            for inputs in (filters, _HEAD):
                norm = _OffsetNorm(_HEAD, momentum)
                head += [nn.Conv2d(inputs, _HEAD, 1, bias=False), norm, nn.LeakyReLU(_LEAK)]
            self.head = nn.Sequential(*head, nn.Conv2d(_HEAD, 3 * self.count, 1))
        else:
            self.heat, self.disparity = (nn.Conv2d(filters, self.count, 3, padding=1) for _ in range(2))
        self.integral = settings.head == "integral"
        self.register_buffer("mean", torch.tensor(_MEAN)[:, None, None], persistent=False)
        self.register_buffer("deviation", torch.tensor(_STD)[:, None, None], persistent=False)
        initialise(self)

    def forward(self, images: Tensor) -> dict[str, Tensor]:
        """Return the keypoints of windows.

        Parameters
        ----------
        images : (B, 2, 3, h, w) Tensor
            Windows of the left and the right eye, in [0, 1].

        Returns
        -------
        dict of Tensor
            ``keypoints`` (B, K, 3): column and row in the left window [px], and how much farther left it is in the
            right window [px]. With the integral head also ``probability`` (B, K, h, w).
        """
        if images.ndim != 5 or images.shape[1:3] != (2, 3):
            raise InputError("images", "windows of shape (B, 2, 3, h, w)", tuple(images.shape))
        colours = images.flip(2) if self.released else images
        features = self.features(((colours - self.mean) / self.deviation).flatten(1, 2).contiguous())
        height, width = images.shape[-2:]
        if self.integral:
            return self._expected(features)
        # (B, 3K): of [-1, 1] over the window, and fractions of its width.
        u, v, d = self.head(features).float().mean((2, 3)).unflatten(1, (self.count, 3)).unbind(2)
        keypoints = torch.stack([(u + 1.0) * width / 2.0 - 0.5, (v + 1.0) * height / 2.0 - 0.5, d * width], dim=2)
        return {"keypoints": keypoints}

    def _expected(self, features: Tensor) -> dict[str, Tensor]:
        logits, disparity = self.heat(features).float(), self.disparity(features).float()
        height, width = logits.shape[-2:]
        probability = logits.flatten(2).softmax(2).unflatten(2, (height, width))
        u = torch.einsum("bkhw,w->bk", probability, torch.arange(width, device=logits.device).float())
        v = torch.einsum("bkhw,h->bk", probability, torch.arange(height, device=logits.device).float())
        d = width * (probability * disparity).sum((2, 3))
        return {"keypoints": torch.stack([u, v, d], dim=2), "probability": probability}


class _OffsetNorm(nn.Module):
    """Batch norm with a learnt offset and no learnt scale."""

    def __init__(self, channels: int, momentum: float) -> None:
        super().__init__()
        self.norm = nn.BatchNorm2d(channels, eps=_EPSILON, momentum=momentum, affine=False)
        self.offset = nn.Parameter(torch.zeros(channels))

    def forward(self, x: Tensor) -> Tensor:
        return self.norm(x) + self.offset[:, None, None]


def receptive_field(net: KeyPose, size: int) -> int:
    """Return the width of the square of input pixels that the middle of the features depends on.

    Parameters
    ----------
    net : KeyPose
        In evaluation mode.
    size : int
        Side of the picture that is tried [px]; larger than the field.
    """
    image = torch.rand(1, 6, size, size, requires_grad=True)
    (gradient,) = torch.autograd.grad(net.features(image)[0, :, size // 2, size // 2].sum(), image)
    columns = gradient.abs().sum((0, 1, 2)).nonzero()
    return int(columns.max() - columns.min()) + 1
