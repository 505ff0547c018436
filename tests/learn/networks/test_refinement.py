from __future__ import annotations

import pytest
import torch

from glassware.learn.networks.layers import initialise
from glassware.learn.networks.plane_sweep import plane_depths, plane_sweep_grid
from glassware.learn.networks.refinement import Refinement, planes_around

FOCAL, BASELINE, DISPARITY = 200.0, 0.1, 24
DEPTH = FOCAL * BASELINE / DISPARITY


@pytest.fixture
def pair(rng):
    """A rectified pair of a wall with a disparity of 24 px: images, poses, K."""
    wall = torch.from_numpy(rng.normal(size=(3, 64, 128 + DISPARITY))).float()
    images = torch.stack([wall[..., :128], wall[..., DISPARITY:]])[None]
    poses = torch.eye(4).repeat(1, 2, 1, 1)
    poses[0, 1, 0, 3] = BASELINE
    K = torch.tensor([[FOCAL, 0.0, 64.0], [0.0, FOCAL, 32.0], [0.0, 0.0, 1.0]]).repeat(1, 2, 1, 1)
    return images, poses, K


def test_a_new_refinement_changes_nothing(tiny, pair, rng):
    net = Refinement(tiny)
    initialise(net)
    net.start_at_zero()
    planes = plane_depths(torch.tensor([[0.4, 1.6]]), 8, "inverse")
    depth = torch.from_numpy(rng.uniform(0.3, 2.0, (1, 64, 128))).float()
    finest = torch.from_numpy(rng.normal(size=(1, tiny.pyramid_channels, 16, 32))).float()
    torch.testing.assert_close(net(*pair, planes, depth, finest), depth, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("wrong", [-1.0, -0.25, 0.0, 0.5, 1.25])
def test_the_planes_around_a_wrong_depth_match_best_at_the_surface(tiny, pair, wrong):
    """Products of features are largest where both views show the same point, whatever the features are."""
    net = Refinement(tiny).eval()
    images, poses, K = pair
    step = torch.full((1, 1, 1), 0.25)  # 1/m: 5 px of disparity
    inverse = torch.full((1, 32, 64), 1.0 / DEPTH) + wrong * step
    depths = planes_around(inverse, step)
    with torch.no_grad():
        features = net.features(images.flatten(0, 1)).unflatten(0, (1, 2))
        volume = net.matching(features, poses, K, depths)  # (1, G, 13, 32, 64)
    best = volume.sum(1)[0, :, :, 20:].mean((1, 2)).argmax()  # the left columns are not seen by the right camera
    assert float(1.0 / depths[0, best, 0, 30]) == pytest.approx(1.0 / DEPTH, abs=1e-3)


def test_planes_stay_in_front_of_the_camera():
    """Far away, a step to the back would pass infinity."""
    depths = planes_around(torch.full((1, 2, 2), 0.1), torch.full((1, 1, 1), 0.5))
    assert (depths > 0.0).all()
    assert torch.isfinite(depths).all()


def test_a_plane_that_bends_is_swept_at_the_depth_of_each_pixel(pair, rng):
    """As many flat planes, one for each pixel's depth, agree at that pixel."""
    _, poses, K = pair
    bent = torch.from_numpy(rng.uniform(0.5, 1.5, (1, 1, 3, 4))).float()
    pixels, visible = plane_sweep_grid(poses[:, 0], K[:, 0], K[:, 1], bent, (3, 4))
    flat, seen = plane_sweep_grid(poses[:, 0], K[:, 0], K[:, 1], bent.flatten()[None], (3, 4))
    rows, columns = torch.meshgrid(torch.arange(3), torch.arange(4), indexing="ij")
    index = torch.arange(12).reshape(3, 4)
    torch.testing.assert_close(pixels[0, 0], flat[0, index, rows, columns])
    assert torch.equal(visible[0, 0], seen[0, index, rows, columns])
