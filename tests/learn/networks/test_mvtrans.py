from __future__ import annotations

import numpy as np
import pytest
import torch

from glassware.core.errors import InputError
from glassware.core.pose import look_at
from glassware.learn import NetworkSettings, build_network
from glassware.learn.networks.cost_volume import ConcatMatching, windowed_expectation
from glassware.learn.targets.encoding import CORRECTED, decoded_depth

OUTPUTS = {
    "seg": (4, 1),
    "depth": (None, 1),
    "heatmap": (None, 1),
    "small_depth": (None, 4),
    "vertex": (16, 8),
    "z_centroid": (None, 8),
    "covariance": (6, 8),
    "offset": (2, 1),
}


def batch(rng: np.random.Generator, samples: int, views: int, height: int, width: int):
    images = torch.from_numpy(rng.uniform(0, 1, (samples, views, 3, height, width))).float()
    eyes = np.array([0.0, -0.6, 0.6]) + rng.uniform(-0.1, 0.1, (samples, views, 3))
    poses = np.stack([[look_at(eye, np.zeros(3)) for eye in row] for row in eyes])
    K = np.zeros((samples, views, 3, 3))
    K[..., 0, 0] = K[..., 1, 1] = rng.uniform(0.8, 1.2, (samples, views)) * width
    K[..., 0, 2], K[..., 1, 2], K[..., 2, 2] = (width - 1) / 2, (height - 1) / 2, 1.0
    return images, torch.from_numpy(poses).float(), torch.from_numpy(K).float()


@pytest.mark.parametrize(
    ("views", "height", "width", "changes"),
    [
        (2, 96, 128, {}),
        (3, 32, 64, {"spacing": "inverse", "matching": "group"}),
        (5, 64, 32, {"fusion": "visibility", "readout": "windowed", "planes": 9}),
        (2, 64, 96, {"norm": "group", "head_norm": "batch", "matching": "group", "fusion": "visibility"}),
        (3, 64, 32, {"heads_see_context": True, "refinement": "half", "matching": "group"}),
        (2, 64, 128, {"heads_see_context": True, "refinement": "half", "matching": "group", "objects_at": "half"}),
        (2, 64, 32, {"refinement": "semi_global", "spacing": "inverse"}),
        (3, 128, 64, {"objects_at": "half", "recompute": "features"}),
    ],
)
def test_any_number_of_views_and_any_multiple_of_32_give_all_outputs(tiny, rng, views, height, width, changes):
    net = build_network(tiny.model_copy(update=changes))
    outputs = net(*batch(rng, 2, views, height, width))
    for name, (channels, stride) in OUTPUTS.items():
        expected = (2, *([] if channels is None else [channels]), height // stride, width // stride)
        assert outputs[name].shape == expected, name
        assert torch.isfinite(outputs[name]).all(), name
    near, far = tiny.depth_range
    assert (outputs["small_depth"] >= near - 1e-5).all()
    assert (outputs["small_depth"] <= far + 1e-5).all()


def test_each_sample_of_a_batch_has_its_own_cameras(tiny, rng):
    net = build_network(tiny).eval()
    whole = batch(rng, 3, 2, 64, 64)
    with torch.inference_mode():
        together = net(*whole)
        for index in range(3):
            alone = net(*(tensor[index : index + 1] for tensor in whole))
            for name in OUTPUTS:
                torch.testing.assert_close(together[name][index], alone[name][0], rtol=1e-3, atol=1e-4)


def test_a_new_network_expects_boxes_at_the_depth_that_it_matched(tiny, rng):
    whole = batch(rng, 2, 2, 64, 96)
    outputs = build_network(tiny)(*whole)
    coarse = outputs["small_depth"][:, ::2, ::2]
    torch.testing.assert_close(decoded_depth(outputs["z_centroid"], CORRECTED), coarse)
    absolute = build_network(tiny.model_copy(update={"box_depth": "absolute"}))(*whole)
    assert (decoded_depth(absolute["z_centroid"], CORRECTED) - coarse).abs().max() > 0.01


def test_the_order_of_the_sources_does_not_matter(tiny, rng):
    net = build_network(tiny.model_copy(update={"fusion": "visibility"})).eval()
    whole = batch(rng, 1, 4, 64, 64)
    with torch.inference_mode():
        one, other = net(*whole), net(*(tensor[:, [0, 3, 1, 2]] for tensor in whole))
    torch.testing.assert_close(one["small_depth"], other["small_depth"])


def test_every_weight_learns(tiny, rng):
    for changes in ({}, {"matching": "group", "fusion": "visibility", "readout": "windowed"}, {"objects_at": "half"}):
        net = build_network(tiny.model_copy(update=changes))
        # The last convolutions of these start at 0: before them nothing is learnt in the first step.
        for head in ("depth_head", "heatmap_head", "z_centroid_head"):
            torch.nn.init.normal_(net.get_parameter(f"{head}.predictor.weight"))
        outputs = net(*batch(rng, 2, 3, 64, 128))
        torch.stack([(outputs[name] ** 2).mean() for name in OUTPUTS]).sum().backward()
        dead = [name for name, p in net.named_parameters() if p.grad is None or not p.grad.abs().max() > 0]
        assert not dead


def test_objects_at_half_size_need_sizes_that_are_multiples_of_64(tiny, rng):
    net = build_network(tiny.model_copy(update={"objects_at": "half"}))
    with pytest.raises(InputError, match="multiples of 64 px, found 96 x 128"):
        net(*batch(rng, 1, 2, 96, 128))


def test_a_new_network_sees_no_heat(tiny, rng):
    """A random map would be most of the loss: its target is 0 nearly everywhere."""
    assert not build_network(tiny)(*batch(rng, 1, 2, 32, 64))["heatmap"].any()


@pytest.mark.parametrize("recompute", ["early", "features"])
def test_computing_features_again_changes_neither_gradients_nor_statistics(tiny, rng, recompute):
    plain = build_network(tiny.model_copy(update={"recompute": "nothing"}))
    again = build_network(tiny.model_copy(update={"recompute": recompute}))
    again.load_state_dict(plain.state_dict())
    inputs = batch(rng, 2, 2, 32, 64)
    for net in (plain, again):
        outputs = net(*inputs)
        torch.stack([(outputs[name] ** 2).mean() for name in OUTPUTS]).sum().backward()
    for (name, one), other in zip(plain.named_parameters(), again.parameters(), strict=True):
        assert one.grad is not None
        assert other.grad is not None
        assert torch.equal(one.grad, other.grad), name
    for name, value in plain.state_dict().items():
        assert torch.equal(value, again.state_dict()[name]), name


def test_a_samples_own_range_of_depth_wins(tiny, rng):
    net = build_network(tiny).eval()
    with torch.inference_mode():
        outputs = net(*batch(rng, 2, 2, 32, 32), torch.tensor([[0.2, 0.3], [2.0, 5.0]]))
    torch.testing.assert_close(outputs["planes"][:, [0, -1]], torch.tensor([[0.2, 0.3], [2.0, 5.0]]))
    assert (outputs["small_depth"][0] <= 0.3 + 1e-5).all()
    assert (outputs["small_depth"][1] >= 2.0 - 1e-5).all()


def test_the_split_convolution_is_that_of_both_features_side_by_side(tiny, rng):
    pair = ConcatMatching(tiny)
    reference, source = torch.from_numpy(rng.standard_normal((2, 1, 8, 5, 6))).float()
    left, right = pair.embeddings(reference, source[:, None])
    side_by_side = torch.cat([reference, source], dim=1)
    weight = torch.cat([pair.reference.weight, pair.source.weight], dim=1)
    torch.testing.assert_close(left + right[:, 0], torch.nn.functional.conv2d(side_by_side, weight))


def test_a_windowed_expectation_takes_one_of_two_matches():
    planes = torch.tensor([[0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1]])
    probability = torch.tensor([0.25, 0.25, 0.05, 0.01, 0.01, 0.4, 0.03])
    depth = windowed_expectation(probability.log()[None, :, None, None], planes, 1)
    expected = (0.01 * 0.9 + 0.4 * 1.0 + 0.03 * 1.1) / 0.44
    torch.testing.assert_close(depth, torch.tensor([[[expected]]]))


@pytest.fixture(scope="module")
def networks(tiny):
    """A network of each variant; do not change it."""
    return {name: build_network(tiny.model_copy(update={"variant": name})) for name in ("corrected", "reference")}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda i, T, K: (i[:, :1], T[:, :1], K[:, :1]), "images: expected two views or more, found 1"),
        (lambda i, T, K: (i[..., :-1], T, K), "images: expected a height and a width that are multiples of 32 px"),
        (lambda i, T, K: (i[0], T, K), "images: expected shape"),
        (lambda i, T, K: (i, T[:, :1], K), "world_T_camera: expected shape"),
        (lambda i, T, K: (i, T, K[:, 0]), "K: expected shape"),
    ],
)
@pytest.mark.parametrize("variant", ["corrected", "reference"])
def test_inputs_of_other_shapes_are_one_clear_line(networks, rng, change, message, variant):
    with pytest.raises(InputError, match=message):
        networks[variant](*change(*batch(rng, 1, 2, 32, 32)))


def test_settings_that_do_not_fit_are_one_clear_line(tiny):
    with pytest.raises(InputError, match="groups: expected a divisor of feature_channels"):
        build_network(tiny.model_copy(update={"matching": "group", "groups": 3}))
    with pytest.raises(InputError, match="depth_range: expected the depths"):
        build_network(NetworkSettings())
