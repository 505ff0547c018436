from __future__ import annotations

import numpy as np
import pytest
import torch

from glassware.learn.networks.fused_depth import CANDIDATES, EVIDENCE, PRIORS, fused_depths
from glassware.learn.networks.photometric import halved, local_contrast, local_deviation
from glassware.learn.networks.plane_sweep import plane_depths

from .walls import DEPTH, DISPARITY, wall_pair

#: 4.2 px of disparity apart, about as far as those of the weights `large`.
PLANES = plane_depths(torch.tensor([[0.4, 1.6]]), 10, "inverse")
STEP = (1.0 / 0.4 - 1.0 / 1.6) / 9
SEEN = slice(DISPARITY // 2 + 12, -8)


def fused(images, poses, K, inverse):
    contrast = local_contrast(halved(images.flatten(0, 1))).unflatten(0, images.shape[:2])
    return fused_depths(images, contrast, poses, K, PLANES, inverse, torch.full((1, 1, 1), STEP))


@pytest.mark.parametrize("wrong", [-0.9, -0.4, 0.0, 0.5, 0.9])
def test_with_texture_the_pictures_decide(rng, wrong):
    """The depth found so far is up to a plane off; each candidate is nearer to the wall."""
    images, poses, K = wall_pair(rng)
    found, _ = fused(images, poses, K, torch.full((1, 32, 64), 1.0 / DEPTH + wrong * STEP))
    error = (found - 1.0 / DEPTH).abs()[0, :, 4:-4, SEEN] / STEP
    for index, prior in enumerate((*PRIORS, "mean")):
        assert error[index].mean() < max(0.2, 0.75 * abs(wrong)), prior


def test_a_weak_prior_finds_what_is_far_from_the_depth_so_far(rng):
    images, poses, K = wall_pair(rng)
    found, _ = fused(images, poses, K, torch.full((1, 32, 64), 1.0 / DEPTH + 2.0 * STEP))
    error = (found - 1.0 / DEPTH).abs()[0, :, 4:-4, SEEN] / STEP
    assert (error[PRIORS.index((0.03, 2.0))] < 0.2).float().mean() > 0.95
    assert (error[PRIORS.index((0.3, 2.0))] < 0.2).float().mean() < 0.1


def test_without_texture_all_stay_at_the_depth_found_so_far(rng):
    _, poses, K = wall_pair(rng)
    grey = torch.full((1, 2, 3, 64, 128), 0.4)
    inverse = torch.full((1, 32, 64), 1.0 / DEPTH + 0.3 * STEP)
    found, evidence = fused(grey, poses, K, inverse)
    error = (found - inverse[:, None]).abs()[..., SEEN] / STEP
    assert (error < 0.25).all()
    # The last channel is the logarithm of the contrast, which is 0 here.
    torch.testing.assert_close(evidence[:, -1], torch.full_like(inverse, np.log(1e-3) / 3.0 + 1.0), atol=1e-4, rtol=0.0)


def test_outside_the_other_picture_all_stay_at_the_depth_found_so_far(rng):
    """Of planes far behind the wall those columns lie inside the other picture, and match there by chance."""
    images, poses, K = wall_pair(rng)
    inverse = torch.full((1, 32, 64), 1.0 / DEPTH + 0.3 * STEP)
    found, _ = fused(images, poses, K, inverse)
    error = (found - inverse[:, None]).abs()[0, :, 4:-4, : DISPARITY // 2 - 4] / STEP
    assert (error.mean((1, 2)) < 0.33).all()  # where planes outside cost as much as a mismatch it is 0.38 and more


def test_evidence_says_which_candidate_the_pictures_agree_with(rng):
    """Similarity at a candidate on the wall is greater than at the depth found so far, which is not on it."""
    images, poses, K = wall_pair(rng)
    found, evidence = fused(images, poses, K, torch.full((1, 32, 64), 1.0 / DEPTH + 1.5 * STEP))
    assert evidence.shape == (1, EVIDENCE, 32, 64)
    assert found.shape == (1, CANDIDATES, 32, 64)
    better = evidence[0, 3 * CANDIDATES + 1 : 4 * CANDIDATES + 1, 4:-4, SEEN]
    weakest = PRIORS.index((0.03, 2.0))
    assert (better[weakest] > 0.0).float().mean() > 0.95


def test_candidates_stay_in_front_of_the_camera(rng):
    """Far away, a step to the back would pass infinity."""
    images, poses, K = wall_pair(rng)
    found, evidence = fused(images, poses, K, torch.full((1, 32, 64), 0.02))
    assert torch.isfinite(evidence).all()
    assert torch.isfinite(found).all()


def test_the_deviation_of_colours_is_that_of_its_window(rng):
    images = torch.from_numpy(rng.uniform(size=(2, 3, 40, 48))).float()
    found = local_deviation(halved(images))
    half = torch.nn.functional.avg_pool2d(images, 3, 2, 1, count_include_pad=False)
    residual = half - torch.nn.functional.avg_pool2d(half, 5, 1, 2, count_include_pad=False)
    window = residual[1, :, 8:13, 10:15].square().mean()
    torch.testing.assert_close(found[1, 10, 12], window.sqrt())
