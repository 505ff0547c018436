from __future__ import annotations

import numpy as np
import pytest
import torch

from glassware.learn.training.loss_weights import LossWeights
from glassware.learn.training.losses import losses, plane_loss, total_loss

H, W = 32, 64
REFINED = {"refinement": "half"}


def huber(error: np.ndarray) -> np.ndarray:
    """Huber's loss with its change at 1 m, written out."""
    return np.where(np.abs(error) < 1.0, 0.5 * error**2, np.abs(error) - 0.5)


@pytest.fixture
def pair(rng):
    """Outputs and targets of two samples."""

    def drawn(*shape):
        return torch.from_numpy(rng.standard_normal((2, *shape))).float()

    cells = (H // 8, W // 8)
    outputs = {
        "seg": drawn(4, H, W),
        "depth": drawn(H, W),
        "small_depth": drawn(H // 4, W // 4),
        "heatmap": drawn(H, W),
        "offset": drawn(2, H, W),
        "vertex": drawn(16, *cells),
        "z_centroid": drawn(*cells),
        "covariance": drawn(6, *cells),
    }
    targets = {
        name: drawn(*outputs[name].shape[1:]) for name in ("heatmap", "offset", "vertex", "z_centroid", "covariance")
    }
    targets["depth"] = torch.from_numpy(rng.uniform(0.2, 4.0, (2, H, W)) * (rng.uniform(size=(2, H, W)) < 0.8)).float()
    targets["seg"] = torch.from_numpy(rng.integers(0, 4, (2, H, W)))
    targets["object_mask"] = torch.from_numpy(rng.uniform(size=(2, H, W)) < 0.3)
    targets["cell_mask"] = torch.from_numpy(rng.uniform(size=(2, *cells)) < 0.3)
    return outputs, targets


def cross_entropy(logits: np.ndarray, classes: np.ndarray) -> float:
    logits = np.moveaxis(logits, 1, -1).reshape(-1, logits.shape[1]).astype(np.float64)
    return float((np.log(np.exp(logits).sum(1)) - logits[np.arange(len(logits)), classes.reshape(-1)]).mean())


def test_each_loss_is_its_formula_over_the_pixels_with_ground_truth(pair, tiny):
    outputs, targets = pair
    found = losses(outputs, targets, tiny)
    o, t = ({name: value.numpy() for name, value in part.items()} for part in pair)
    known, small = t["depth"] > 0, t["depth"][:, ::4, ::4]
    expected = {
        "seg": cross_entropy(o["seg"], t["seg"]),
        "depth": huber(o["depth"] - t["depth"])[known].mean(),
        "small_depth": huber(o["small_depth"] - small)[small > 0].mean(),
        "heatmap": ((o["heatmap"] - t["heatmap"]) ** 2).mean(),
        "offset": np.abs(o["offset"] - t["offset"]).sum(1)[t["object_mask"]].mean(),
        "vertex": np.abs(o["vertex"] - t["vertex"]).sum(1)[t["cell_mask"]].mean(),
        "z_centroid": np.abs(o["z_centroid"] - t["z_centroid"])[t["cell_mask"]].mean(),
        "covariance": np.abs(o["covariance"] - t["covariance"]).sum(1)[t["cell_mask"]].mean(),
    }
    assert {name: float(value) for name, value in found.items()} == pytest.approx(expected, rel=1e-5)
    refined = losses(outputs | {"unrefined_depth": 2.0 * outputs["depth"]}, targets, tiny.model_copy(update=REFINED))
    unrefined = huber(2.0 * o["depth"] - t["depth"])[known].mean()
    assert float(refined["unrefined_depth"]) == pytest.approx(unrefined, rel=1e-5)
    weights = LossWeights(heatmap=3.0, seg=0.0)
    total = sum(getattr(weights, name) * value for name, value in expected.items())
    assert float(total_loss(found, weights)) == pytest.approx(total, rel=1e-5)


def test_pixels_of_objects_can_count_more_in_the_depth_losses(pair, tiny):
    outputs, targets = pair
    found = losses(outputs, targets, tiny, object_pixels=5.0)
    error, known = huber((outputs["depth"] - targets["depth"]).numpy()), targets["depth"].numpy() > 0
    weight = np.where(targets["seg"].numpy() >= 2, 5.0, 1.0)  # transparent 2, opaque 3
    assert float(found["depth"]) == pytest.approx(np.average(error[known], weights=weight[known]), rel=1e-5)
    coarse = huber((outputs["small_depth"] - targets["depth"][:, ::4, ::4]).numpy())
    small, known = weight[:, ::4, ::4], known[:, ::4, ::4]
    assert float(found["small_depth"]) == pytest.approx(np.average(coarse[known], weights=small[known]), rel=1e-5)


def test_the_reference_learns_a_quarter_of_the_depth_and_leaves_out_no_pixel(pair, tiny):
    outputs, targets = pair
    outputs = outputs | {"seg": outputs["seg"][:, :3]}
    found = losses(outputs, targets, tiny.model_copy(update={"variant": "reference"}))
    o, t = outputs, targets
    depth = np.where(t["depth"].numpy() > 0, np.minimum(t["depth"].numpy(), 3.0), 3.0)
    assert float(found["depth"]) == pytest.approx(huber(o["depth"].numpy() - depth).mean(), rel=1e-5)
    small = huber(o["small_depth"].numpy() - 0.25 * depth[:, ::4, ::4]).mean() / 0.25
    assert float(found["small_depth"]) == pytest.approx(small, rel=1e-5)
    classes = np.minimum(t["seg"].numpy(), 2)
    assert float(found["seg"]) == pytest.approx(cross_entropy(o["seg"].numpy(), classes), rel=1e-5)
    assert "offset" not in found


def test_without_any_ground_truth_the_loss_is_zero_and_harmless(pair, tiny):
    outputs, targets = pair
    outputs["depth"].requires_grad_(True)
    nothing = targets | {"depth": torch.zeros(2, H, W), "cell_mask": torch.zeros_like(targets["cell_mask"])}
    found = losses(outputs, nothing, tiny)
    assert float(found["depth"].detach()) == float(found["vertex"]) == 0.0
    found["depth"].backward()
    assert not outputs["depth"].grad.any()


def test_cross_entropy_over_planes_is_least_where_the_expectation_is_the_target(rng):
    planes = torch.tensor([[0.5, 0.7, 1.0, 1.5], [0.6, 0.8, 1.1, 1.4]])
    target = torch.tensor([[[0.6, 1.1, 0.0]], [[0.95, 0.2, 9.0]]])
    shares = [[(0, 0.5), (1, 0.5)], [(2, 0.8), (3, 0.2)], None], [[(1, 0.5), (2, 0.5)], [(0, 1.0)], [(3, 1.0)]]
    logits = torch.from_numpy(rng.standard_normal((2, 4, 1, 3))).float()
    log_probability, terms = logits.log_softmax(1), []
    for sample, row in enumerate(shares):
        for column, parts in enumerate(row):
            if parts is not None:
                terms.append(-sum(share * float(log_probability[sample, k, 0, column]) for k, share in parts))
    assert float(plane_loss(logits, planes, target)) == pytest.approx(np.mean(terms), rel=1e-5)


def test_the_released_weights_are_the_default():
    released = {
        "depth": 1,
        "small_depth": 1,
        "seg": 1,
        "heatmap": 100,
        "vertex": 0.1,
        "z_centroid": 0.1,
        "covariance": 0.1,
    }
    assert {name: getattr(LossWeights(), name) for name in released} == released
