"""Weights that a run begins with, where its network has more than they know: a size, or candidates for depth."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

from glassware.core.errors import InputError
from glassware.learn.networks.build import build_network
from glassware.learn.networks.fused_depth import CANDIDATES
from glassware.learn.networks.layers import half_size, upsample
from glassware.learn.networks.mvtrans import MVTrans
from glassware.learn.networks.refinement import APPEARANCE, EVIDENCE
from glassware.learn.training.checkpoint import TrainedWeights
from glassware.learn.training.initial_weights import load_initial_weights
from glassware.learn.training.train_state import with_network_of

WHERE = Path("weights")


@pytest.fixture
def plain(tiny):
    return tiny.model_copy(update={"heads_see_context": True, "box_depth": "absolute"})


def built(settings) -> MVTrans:
    network = build_network(settings)
    assert isinstance(network, MVTrans)
    return network.eval()


def test_objects_are_those_that_were_found_in_the_picture_at_half_its_size(plain, settings, rng):
    """But for what heads make of the depth, whose weights are 0 here: it is matched in finer pictures now."""
    before, trained = built(plain), settings.model_copy(update={"network": plain})
    with torch.no_grad():
        before.get_parameter("pyramid.stem.0.0.weight")[:, plain.feature_channels] = 0.0
        torch.nn.init.normal_(before.get_parameter("heatmap_head.predictor.weight"))
    asked = settings.model_copy(update={"network": plain.model_copy(update={"objects_at": "half"})})
    network = with_network_of(asked, trained, WHERE).network
    assert network.objects_at == "half"
    after = built(network)
    load_initial_weights(after, TrainedWeights(trained, before.state_dict(), None), WHERE)
    images = torch.from_numpy(rng.uniform(size=(1, 2, 3, 128, 192))).float()
    poses = torch.eye(4).repeat(1, 2, 1, 1)
    poses[0, 1, 0, 3] = 0.05
    K = torch.tensor([[160.0, 0.0, 96.0], [0.0, 160.0, 64.0], [0.0, 0.0, 1.0]]).repeat(1, 2, 1, 1)
    small, halved = half_size(images[0])[None], K.clone()
    halved[..., :2, :] /= 2.0
    with torch.inference_mode():
        expected, found = before(small, poses, halved), after(images, poses, K)
    for name in ("seg", "offset", "vertex", "covariance"):
        torch.testing.assert_close(found[name], upsample(expected[name], 2), rtol=1e-4, atol=1e-4)
    torch.testing.assert_close(found["z_centroid"], upsample(expected["z_centroid"][:, None], 2)[:, 0])
    # Heat is upsampled once, by 8, not twice.
    torch.testing.assert_close(found["heatmap"][:, ::8, ::8], expected["heatmap"][:, ::4, ::4], rtol=1e-4, atol=1e-4)
    assert expected["heatmap"].std() > 0.01


def test_a_refinement_with_more_candidates_begins_with_the_weights_for_those_it_had(plain, settings, rng):
    """Where the new ones are out of the question it finds what it found before, but for what it saw of the image."""
    old = plain.model_copy(update={"refinement": "half"})
    before, trained = built(old), settings.model_copy(update={"network": old})
    torch.nn.init.normal_(before.get_parameter("refinement.choice.weight"), std=1e-4)
    with torch.no_grad():
        before.get_parameter("refinement.enter.0.0.weight")[:, EVIDENCE : EVIDENCE + APPEARANCE] = 0.0
    asked = settings.model_copy(update={"network": plain.model_copy(update={"refinement": "semi_global"})})
    network = with_network_of(asked, trained, WHERE).network
    assert network.refinement == "semi_global"
    after = built(network)
    load_initial_weights(after, TrainedWeights(trained, before.state_dict(), None), WHERE)
    images = torch.from_numpy(rng.uniform(size=(1, 2, 3, 64, 96))).float()
    poses = torch.eye(4).repeat(1, 2, 1, 1)
    poses[0, 1, 0, 3] = 0.05
    K = torch.tensor([[80.0, 0.0, 48.0], [0.0, 80.0, 32.0], [0.0, 0.0, 1.0]]).repeat(1, 2, 1, 1)
    with torch.inference_mode():
        expected, first = before(images, poses, K), after(images, poses, K)["depth"]
        after.get_parameter("refinement.choice.bias")[-CANDIDATES:] = -1e4
        found = after(images, poses, K)
    for name, value in expected.items():
        torch.testing.assert_close(found[name], value, msg=name)
    assert (first - expected["depth"]).abs().mean() > 1e-3
    # A run that leaves it open keeps it; one that asks for fewer candidates is refused.
    wide = trained.model_copy(update={"network": network})
    assert with_network_of(settings.model_copy(update={"network": plain}), wide, WHERE).network == network
    with pytest.raises(InputError, match=r"network\.refinement: expected half, as the settings say, found semi_global"):
        with_network_of(trained, wide, WHERE)


def test_weights_for_half_size_stay_as_they_are(plain, settings):
    network = plain.model_copy(update={"objects_at": "half"})
    trained = settings.model_copy(update={"network": network})
    before, after = built(network), built(network)
    load_initial_weights(after, TrainedWeights(trained, before.state_dict(), None), WHERE)
    for name, value in before.state_dict().items():
        assert torch.equal(after.state_dict()[name], value), name
    # A run that leaves it open keeps it.
    assert with_network_of(settings.model_copy(update={"network": plain}), trained, WHERE).network == network
