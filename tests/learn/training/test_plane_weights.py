"""Weights of a network that gets other depth planes."""

from __future__ import annotations

import pytest
import torch
from torch.nn import functional

from glassware.learn.networks.build import build_network
from glassware.learn.networks.mvtrans import MVTrans
from glassware.learn.networks.settings import NetworkSettings
from glassware.learn.training.plane_weights import on_planes


def built(settings: NetworkSettings) -> MVTrans:
    network = build_network(settings)
    assert isinstance(network, MVTrans)
    return network.eval()


@pytest.fixture
def network_settings(tiny) -> NetworkSettings:
    """Planes at 1 / depth of 2.5, 2.25, ... 0.75 per metre; all heads see the context."""
    planes = {"depth_range": (1 / 2.5, 1 / 0.75), "planes": 8, "spacing": "inverse", "heads_see_context": True}
    return tiny.model_copy(update=planes)


def test_the_same_planes_have_the_same_weights(network_settings):
    weights = built(network_settings).state_dict()
    for same in (network_settings, network_settings.model_copy(update={"refinement": "half"})):
        found = on_planes(weights, network_settings, same)
        assert all(torch.equal(found[name], value) for name, value in weights.items())


def test_context_follows_the_depth_of_its_plane_and_what_sees_it_finds_the_same(network_settings, rng):
    torch.manual_seed(3)
    before = built(network_settings)
    # Three nearer planes and one farther one, as far from each other.
    longer = network_settings.model_copy(update={"depth_range": (1 / 3.25, 1 / 0.5), "planes": 12})
    after = built(longer)
    after.load_state_dict(on_planes(before.state_dict(), network_settings, longer))
    picture = torch.from_numpy(rng.uniform(-1.0, 1.0, (1, 3, 64, 96))).float()
    with torch.inference_mode():
        old, new = (one.decoder.context(one.context(picture)) for one in (before, after))
        torch.testing.assert_close(new[:, 3:11], old)
        torch.testing.assert_close(new[:, [0, 1, 2, 11]], old[:, [0, 0, 0, 7]])
        features = torch.from_numpy(rng.uniform(-1.0, 1.0, (1, network_settings.feature_channels, 16, 24))).float()
        coarse = 0.5 + torch.from_numpy(rng.uniform(size=(1, 1, 16, 24))).float()
        stems = [
            functional.conv2d(
                torch.cat([features, coarse / reach, maps], 1), one.get_parameter("pyramid.stem.0.0.weight")
            )
            for one, maps, reach in ((before, old, 1 / 0.75 - 1 / 2.5), (after, new, 1 / 0.5 - 1 / 3.25))
        ]
    torch.testing.assert_close(*stems, rtol=1e-4, atol=1e-5)


def test_without_context_in_the_heads_only_depth_keeps_its_scale(network_settings):
    plain = network_settings.model_copy(update={"heads_see_context": False})
    longer = plain.model_copy(update={"depth_range": (1 / 3.25, 1 / 0.5), "planes": 12})
    weights, network = built(plain).state_dict(), built(longer)
    found = on_planes(weights, plain, longer)
    network.load_state_dict(found)
    stem, count = "pyramid.stem.0.0.weight", plain.feature_channels
    assert torch.equal(found[stem][:, :count], weights[stem][:, :count])
    stretch = (1 / 0.5 - 1 / 3.25) / (1 / 0.75 - 1 / 2.5)
    torch.testing.assert_close(found[stem][:, count], stretch * weights[stem][:, count])
