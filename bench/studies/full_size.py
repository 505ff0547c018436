"""What training at the paper's size would take on accelerators: computed from multiplications and additions, not run.

python bench/studies/full_size.py

Counts the multiplications and additions of a forward pass of each network at its published size. A training step takes
three times as many, of ResNet-50 as well, so the ratio of the passes is that of the steps: with the pictures per
second that ResNet-50 reaches in training on the same accelerator it gives the time. The lower bound takes mixed
precision, the upper one TF32 (MVTrans's matching is in 32 bits).
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import torch
from torch import nn
from torch.utils.flop_counter import FlopCounterMode

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from command import Output, run
from table import Row, report

from glassware.learn import NetworkSettings, build_network
from glassware.learn.training.methods import outputs_of
from learn import BATCHES, published_settings

#: Multiplications and additions of ResNet-50 for a picture of 224 x 224 [1e9] (He et al., CVPR 2016: 3.8; with the
#: stride of v1.5 4.1).
RESNET50 = 4.1
#: Pictures per second in training of ResNet-50 v1.5 on one A100 80 GB, in mixed precision and in TF32, and the part of
#: eight times that speed which eight reach (NVIDIA, DeepLearningExamples, PyTorch 21.03: 2,470, 938, and 16,621 with
#: eight in mixed precision).
A100_MIXED, A100_TF32, SCALING = 2470.0, 938.0, 16_621.0 / (8.0 * 2470.0)
#: Memory bandwidths of A100 80 GB SXM and H100 SXM [TB/s] (NVIDIA's data sheets). Convolutions of few channels are
#: bound by it, so their ratio stands for that of the speeds.
A100_BANDWIDTH, H100_BANDWIDTH = 2.039, 3.35
#: Samples that the paper's networks see: 400,000 steps of 5.
SAMPLES = 2_000_000
#: List prices of an hour, from and to [US dollars] (offers compared by pricegpu.pages.dev, early 2026).
A100_PRICE, H100_PRICE = (1.49, 2.49), (2.49, 3.99)


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """Where to write."""


def main(given: Options) -> int:
    """Print samples per second, hours and prices of each network."""
    rows = [row for name, gmac in _costs().items() for row in _rows(name, gmac)]
    return report("training of 2,000,000 samples, computed", rows, given.json_file, torch=torch.__version__)


def _rows(name: str, gmac: float) -> list[Row]:
    fast, slow = (rate * RESNET50 / gmac for rate in (A100_MIXED, A100_TF32))
    four, one = 4.0 * SCALING, H100_BANDWIDTH / A100_BANDWIDTH
    rows = [Row(f"{name}: samples on one A100", fast, "1/s", note=f"{slow:.0f} in TF32; {gmac:.0f} GMAC a pass")]
    for title, factor, devices, price in (("four A100", four, 4, A100_PRICE), ("one H100", one, 1, H100_PRICE)):
        least, most = (SAMPLES / (rate * factor) / 3600.0 for rate in (fast, slow))
        dollars = f"{least * devices * price[0]:.0f} to {most * devices * price[1]:.0f} US dollars"
        rows.append(Row(f"{name}: {title}", least, "h", note=f"to {most:.1f} h; {dollars}"))
    return rows


def _costs() -> dict[str, float]:
    """Return the multiplications and additions of a forward pass of one sample by network [1e9]."""
    found = {}
    for views in (2, 3, 5):
        found[f"MVTrans, {views} views"] = _mvtrans_cost(NetworkSettings(depth_range=(0.25, 3.0)), views)
    released = NetworkSettings.model_validate({"variant": "reference"})
    found["MVTrans as released, 2 views"] = _mvtrans_cost(released, 2)
    for name in BATCHES:
        settings = published_settings(name)
        network, batch = build_network(settings.network).eval(), BATCHES[name]()
        found[name] = _count(network, lambda net, batch=batch, own=settings: outputs_of(net, batch, own.network))
    return found


def _mvtrans_cost(settings: NetworkSettings, views: int) -> float:
    poses, K = torch.eye(4).repeat(1, views, 1, 1), torch.eye(3).repeat(1, views, 1, 1)
    images = torch.zeros(1, views, 3, 480, 640)
    return _count(build_network(settings).eval(), lambda network: network(images, poses, K))


def _count(network: nn.Module, forward) -> float:
    with torch.inference_mode(), FlopCounterMode(display=False) as counter:
        forward(network)
    return counter.get_total_flops() / 2e9


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
