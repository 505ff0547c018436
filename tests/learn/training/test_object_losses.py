"""The losses of KeyPose and DenseFusion, by closed forms."""

from __future__ import annotations

import pytest
import torch

from glassware.learn.training.object_losses import densefusion_losses, keypose_losses, model_distances

K = torch.tensor([[100.0, 0.0, 45.0], [0.0, 100.0, 30.0], [0.0, 0.0, 1.0]]).expand(1, 2, 3, 3)


def keypose_batch(known: bool = True) -> tuple[dict, dict]:
    """A keypoint 2 px from a disparity of 10 px at 1 m, exact for the second of two orders."""
    keypoints = torch.tensor([[[45.0, 30.0, 10.0], [55.0, 30.0, 10.0]]])
    points = torch.tensor([[[0.0, 0.0, 1.0], [0.1, 0.0, 1.0]]])
    both = torch.stack([keypoints, keypoints.flip(1)], dim=1)
    targets = {
        "keypoints": both,
        "points": torch.stack([points, points.flip(1)], dim=1),
        "baseline": torch.tensor([0.1]),
        "projections": torch.eye(3, 4).expand(1, 5, 3, 4),
        "projection_mask": torch.tensor([[known, False, False, False, False]]),
    }
    return {"keypoints": keypoints}, targets


def test_exact_keypoints_in_any_listed_order_cost_nothing():
    outputs, targets = keypose_batch()
    for shown in (outputs["keypoints"], outputs["keypoints"].flip(1)):
        terms = keypose_losses({"keypoints": shown}, targets, K, (60, 90), 1.0)
        assert terms["keypoint"].item() == 0.0
        assert terms["projection"].item() == pytest.approx(0.0, abs=1e-9)


def test_the_errors_are_those_of_the_paper():
    outputs, targets = keypose_batch()
    moved = {"keypoints": outputs["keypoints"] + torch.tensor([3.0, 0.0, 0.0])}
    terms = keypose_losses(moved, targets, K, (60, 90), 1.0)
    # Two keypoints, each off by 3 px of a window 90 px wide; in the other view by 3 % of the depth.
    assert terms["keypoint"].item() == pytest.approx(2 * (2 * 3 / 90) ** 2)
    assert terms["projection"].item() == pytest.approx(2 * 0.03**2, rel=1e-4)
    released = keypose_losses(moved, targets, K, (60, 90), 1.0, released=True)
    # The released code counts the four views that do not exist.
    assert released["projection"].item() == pytest.approx(2 * 0.03**2 / 5, rel=1e-4)


def test_an_error_of_the_disparity_counts_over_whole_windows_unless_asked_otherwise():
    outputs, targets = keypose_batch()
    moved = {"keypoints": outputs["keypoints"] + torch.tensor([0.0, 0.0, 3.0])}
    released = keypose_losses(moved, targets, K, (60, 90), 0.0)["keypoint"]
    heavy = keypose_losses(moved, targets, K, (60, 90), 0.0, disparity=4.0)["keypoint"]
    assert released.item() == pytest.approx(2 * (3 / 90) ** 2)
    assert heavy.item() == pytest.approx(16 * released.item())


def test_other_views_set_in_late():
    outputs, targets = keypose_batch()
    assert "projection" not in keypose_losses(outputs, targets, K, (60, 90), 0.05)
    moved = {"keypoints": outputs["keypoints"] + torch.tensor([3.0, 0.0, 0.0])}
    half, whole = (keypose_losses(moved, targets, K, (60, 90), at)["projection"] for at in (3 / 32, 0.5))
    assert half.item() == pytest.approx(whole.item() / 2, rel=1e-5)


def test_probability_far_from_a_keypoint_costs():
    outputs, targets = keypose_batch()
    near, far = torch.zeros(1, 2, 60, 90), torch.zeros(1, 2, 60, 90)
    near[0, 0, 30, 45] = near[0, 1, 30, 55] = 1.0
    far[0, :, 0, 0] = 1.0
    costs = [
        keypose_losses(outputs | {"probability": maps}, targets, K, (60, 90), 0.0)["probability"].item()
        for maps in (near, far)
    ]
    assert costs[0] == 0.0
    assert 1.9 < costs[1] < 2.0


def test_distances_of_models_are_those_of_their_points():
    model = torch.rand(1, 40, 3, generator=torch.Generator().manual_seed(1))
    shifted = torch.eye(4).repeat(1, 3, 1, 1)
    shifted[0, 1, 0, 3], shifted[0, 2, 2, 3] = 0.2, -0.5
    found = model_distances(shifted, model, model, torch.tensor([False]))
    torch.testing.assert_close(found, torch.tensor([[0.0, 0.2, 0.5]]))
    # A square looks the same after a quarter turn: its nearest corners are in place.
    square = torch.tensor([[[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]]])
    quarter = torch.eye(4)[None, None].clone()
    quarter[0, 0, :2, :2] = torch.tensor([[0.0, -1.0], [1.0, 0.0]])
    assert model_distances(quarter, square, square, torch.tensor([True])).item() == pytest.approx(0.0, abs=1e-6)
    assert model_distances(quarter, square, square, torch.tensor([False])).item() == pytest.approx(2.0)


def test_confidence_is_traded_for_distance_and_lost_objects_cost_nothing():
    model = torch.rand(2, 10, 3)
    targets = {
        "model": model,
        "pose": torch.eye(4).repeat(2, 1, 1),
        "symmetric": torch.tensor([False, False]),
        "lost": torch.tensor([False, True]),
    }
    poses = torch.eye(4).repeat(2, 4, 1, 1)
    poses[..., 0, 3] = 0.1
    outputs = {"poses": poses, "confidence": torch.full((2, 4), 0.5)}
    expected = 0.1 * 0.5 - 0.015 * torch.tensor(0.5).log().item()
    assert densefusion_losses(outputs, targets, 0.015)["distance"].item() == pytest.approx(expected, rel=1e-5)
    refined = densefusion_losses(outputs | {"refined": poses[:, :2]}, targets, 0.015)
    assert set(refined) == {"refined"}
    assert refined["refined"].item() == pytest.approx(0.1, rel=1e-5)
