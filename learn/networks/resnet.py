"""ResNet-18 and ResNet-50 with torchvision's state-dict names, so that ImageNet weights load from a file.

(He et al., "Deep Residual Learning for Image Recognition", CVPR 2016, table 1. As in torchvision, ResNet-50 has its
stride in the 3x3 convolution of a block.)
"""

from __future__ import annotations

from pathlib import Path

import torch
from torch import Tensor, nn

from ...core.errors import InputError
from .settings import Depth
from .weights_file import read_weights

#: Blocks in each of the four layers.
_BLOCKS = {"resnet18": (2, 2, 2, 2), "resnet50": (3, 4, 6, 3)}
#: Channels of the first layer in the published networks.
_WIDTH = 64


class _Basic(nn.Module):
    """A residual block of two 3x3 convolutions."""

    expansion = 1

    def __init__(self, inputs: int, width: int, stride: int, downsample: nn.Module | None) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, width, 3, stride, 1, bias=False)
        self.bn1 = nn.BatchNorm2d(width)
        self.conv2 = nn.Conv2d(width, width, 3, 1, 1, bias=False)
        self.bn2 = nn.BatchNorm2d(width)
        self.downsample = downsample

    def forward(self, x: Tensor) -> Tensor:
        inner = torch.relu(self.bn1(self.conv1(x)))
        shortcut = x if self.downsample is None else self.downsample(x)
        return torch.relu(self.bn2(self.conv2(inner)) + shortcut)


class _Bottleneck(nn.Module):
    """A residual block of a 3x3 convolution between two 1x1 convolutions."""

    expansion = 4

    def __init__(self, inputs: int, width: int, stride: int, downsample: nn.Module | None) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, width, 1, bias=False)
        self.bn1 = nn.BatchNorm2d(width)
        self.conv2 = nn.Conv2d(width, width, 3, stride, 1, bias=False)
        self.bn2 = nn.BatchNorm2d(width)
        self.conv3 = nn.Conv2d(width, 4 * width, 1, bias=False)
        self.bn3 = nn.BatchNorm2d(4 * width)
        self.downsample = downsample

    def forward(self, x: Tensor) -> Tensor:
        inner = torch.relu(self.bn1(self.conv1(x)))
        inner = torch.relu(self.bn2(self.conv2(inner)))
        shortcut = x if self.downsample is None else self.downsample(x)
        return torch.relu(self.bn3(self.conv3(inner)) + shortcut)


class ResNet(nn.Module):
    """A residual network without its classifier.

    Parameters
    ----------
    depth : str
        ``resnet18`` or ``resnet50``.
    stem : bool
        Whether it begins with the 7x7 convolution and max pooling, which reduce images to 1/4 of their size. Without,
        the input has the channels and the size of the first layer.
    classes : int
        Outputs of an unused classifier, which the released checkpoints contain; 0 for none.
    width : int
        Channels of the first layer.
    """

    def __init__(self, depth: Depth, *, stem: bool = True, classes: int = 0, width: int = _WIDTH) -> None:
        super().__init__()
        block = _Basic if depth == "resnet18" else _Bottleneck
        self.stem = stem
        if stem:
            self.conv1 = nn.Conv2d(3, width, 7, 2, 3, bias=False)
            self.bn1 = nn.BatchNorm2d(width)
            self.maxpool = nn.MaxPool2d(3, 2, 1)
        inputs = width
        for number, count in enumerate(_BLOCKS[depth]):
            channels = width << number
            blocks = []
            for index in range(count):
                stride = 2 if number and not index else 1
                outputs = channels * block.expansion
                blocks.append(block(inputs, channels, stride, _shortcut(inputs, outputs, stride)))
                inputs = outputs
            self.add_module(f"layer{number + 1}", nn.Sequential(*blocks))
        #: Output channels of the four layers.
        self.channels = tuple((width << number) * block.expansion for number in range(4))
        if classes:
            self.fc = nn.Linear(inputs, classes)

    def forward(self, x: Tensor) -> tuple[Tensor, ...]:
        """Return the outputs of the four layers, at 1/4, 1/8, 1/16 and 1/32 of the image size."""
        if self.stem:
            x = self.maxpool(torch.relu(self.bn1(self.conv1(x))))  # (B, width, H/4, W/4)
        outputs = []
        for number in range(1, 5):
            x = self.get_submodule(f"layer{number}")(x)
            outputs.append(x)
        return tuple(outputs)


def _shortcut(inputs: int, outputs: int, stride: int) -> nn.Sequential | None:
    if stride == 1 and inputs == outputs:
        return None
    return nn.Sequential(nn.Conv2d(inputs, outputs, 1, stride, bias=False), nn.BatchNorm2d(outputs))


def load_pretrained(net: ResNet, path: Path) -> None:
    """Load weights with torchvision's names from a file; layers that the network lacks (classifier, stem) are ignored.

    Raises
    ------
    InputError
        Where the file is no state dict, or a tensor of the network is missing or has another shape.
    """
    tensors = read_weights(path)
    state = net.state_dict()
    for name, value in state.items():
        if name.endswith("num_batches_tracked"):
            continue
        found = tensors.get(name)
        if found is None or found.shape != value.shape:
            raise InputError(path, f"{name} of shape {tuple(value.shape)}", "none" if found is None else found.shape)
    net.load_state_dict({name: tensors.get(name, value) for name, value in state.items()})
