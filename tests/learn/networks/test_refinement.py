from __future__ import annotations

import pytest
import torch

from glassware.learn.networks.layers import initialise
from glassware.learn.networks.plane_sweep import plane_depths, plane_sweep_grid
from glassware.learn.networks.refinement import Refinement, candidates, planes_around

from .walls import DEPTH, DISPARITY, wall_pair

PLANES = plane_depths(torch.tensor([[0.4, 1.6]]), 8, "inverse")
#: Distance of the planes: 5.4 px of disparity.
STEP = (1.0 / 0.4 - 1.0 / 1.6) / 7
#: Candidates: 13 planes around the depth, 4 further away, the most similar depth of two windows, the table's plane.
NEAR, SEARCHED, TABLE = slice(0, 13), slice(17, 19), 19


@pytest.fixture
def pair(rng):
    return wall_pair(rng)


def test_a_new_refinement_changes_nothing_that_matters(tiny, pair, rng):
    """It prefers the depth found so far by e^5; the others, half of them nearer and half farther, hardly count."""
    net = Refinement(tiny, 4)
    initialise(net)
    net.keep_depth()
    depth = torch.from_numpy(rng.uniform(0.5, 1.4, (1, 64, 128))).float()
    finest = torch.from_numpy(rng.normal(size=(1, tiny.pyramid_channels, 16, 32))).float()
    images, *cameras = pair
    refined = net(images, images, *cameras, PLANES, depth, finest, torch.zeros(1, 4, 64, 128))
    # The others have a tenth of the probability; a tenth of a step of the planes, which is some 20 cm at 0.9 m.
    assert (refined - depth).abs().mean() < 0.02


@pytest.mark.parametrize("wrong", [-1.4, -0.6, 0.0, 0.25, 1.2])
def test_among_the_candidates_is_the_depth_of_the_surface(pair, wrong):
    """However wrong the depth so far is, one plane around it or the search over the range is within half a step."""
    images, poses, K = pair
    inverse = torch.full((1, 32, 64), 1.0 / DEPTH + wrong * STEP)
    found = candidates(images, poses, K, PLANES, inverse, torch.zeros_like(inverse))
    seen = slice(DISPARITY // 2 + 12, -8)
    error = (found.inverse - 1.0 / DEPTH).abs()[0, :, 4:-4, seen]
    assert (error[NEAR].min(0).values <= 0.126 * STEP).all()
    spacing = (1.0 / 0.4 - 1.0 / 1.6) / 63
    assert (error[SEARCHED] <= 0.51 * spacing).float().mean() > 0.99


def test_the_plane_that_is_most_alike_is_the_one_on_the_surface(pair):
    images, poses, K = pair
    inverse = torch.full((1, 32, 64), 1.0 / DEPTH + 0.5 * STEP)
    found = candidates(images, poses, K, PLANES, inverse, torch.zeros_like(inverse))
    alike = found.evidence[0, 13:26, 4:-4, DISPARITY // 2 + 12 : -8]  # averaged over the wider window
    best = found.inverse[0, NEAR][alike.argmax(0), 10, 30]
    torch.testing.assert_close(best, torch.full_like(best, 1.0 / DEPTH))


def test_the_table_is_a_candidate_where_the_other_eye_sees_nothing(pair):
    """The depth so far is wrong at the left side, which only one eye sees; the wall is said to be the table."""
    images, poses, K = pair
    inverse = torch.full((1, 32, 64), 1.0 / DEPTH)
    inverse[..., : DISPARITY // 2 - 2] *= 0.8  # so far away that the disparity is less
    table = torch.ones_like(inverse)
    found = candidates(images, poses, K, PLANES, inverse, table)
    torch.testing.assert_close(found.inverse[:, TABLE], torch.full_like(inverse, 1.0 / DEPTH), rtol=0.02, atol=0.0)


def test_a_refinement_learns_to_prefer_the_depth_at_which_pictures_are_alike(tiny, rng):
    """Sixty steps on walls at one depth, each with a wrong depth of its own; tried on walls that it has not seen."""
    torch.manual_seed(0)
    net = Refinement(tiny, 4)
    initialise(net)
    net.keep_depth()
    optimiser = torch.optim.Adam(net.parameters(), lr=3e-3)
    finest, seg = torch.zeros(1, tiny.pyramid_channels, 16, 32), torch.zeros(1, 4, 64, 128)

    def errors():
        images, *cameras = wall_pair(rng)
        wrong = float(rng.uniform(-1.4, 1.4)) * STEP
        depth = torch.full((1, 64, 128), 1.0 / (1.0 / DEPTH + wrong))
        refined = net(images, images, *cameras, PLANES, depth, finest, seg)
        seen = slice(DISPARITY + 16, -16)
        return (refined - DEPTH).abs()[..., seen].mean(), (depth - DEPTH).abs().mean()

    for _ in range(60):
        optimiser.zero_grad()
        errors()[0].backward()
        optimiser.step()
    with torch.no_grad():
        after, before = (torch.stack(x).mean() for x in zip(*(errors() for _ in range(8)), strict=True))
    assert after < 0.5 * before


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
