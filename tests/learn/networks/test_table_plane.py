from __future__ import annotations

import numpy as np
import pytest
import torch

from glassware.core.pose import look_at
from glassware.learn.networks.table_plane import table_plane

STEP = torch.full((1, 1, 1), 0.066)


@pytest.fixture
def table(rng):
    """The inverse depth of the plane z = 0 in a view from above, by ray casting, and of a box that stands on it."""
    pose = look_at(np.array([0.5, -0.3, 0.6]), np.zeros(3), 0.2)
    v, u = np.mgrid[:32, :40]
    rays = np.stack([(u - 20.0) / 50.0, (v - 16.0) / 50.0, np.ones_like(u, float)], -1) @ pose[:3, :3].T
    plane = -rays[..., 2] / pose[2, 3]  # the third coordinate of a ray with z = 1 in the camera falls to 0
    seen = plane.copy()
    seen[8:18, 10:24] += 0.35  # 15 cm in front of the table
    return torch.from_numpy(plane).float()[None], torch.from_numpy(seen).float()[None]


def test_what_stands_on_the_table_does_not_tilt_the_plane(table):
    plane, seen = table
    found, support = table_plane(seen, torch.ones_like(seen), STEP)
    torch.testing.assert_close(found, plane, rtol=0.0, atol=2e-4)
    assert float(support[0]) == pytest.approx(1.0 - 10 * 14 / (32 * 40), abs=0.01)


def test_a_plane_goes_on_where_nothing_was_matched(table):
    """Pixels without weight may have any value: a quarter of the picture, as at the side that one eye does not see."""
    plane, seen = table
    weight = torch.ones_like(seen)
    weight[..., :10] = 0.0
    wrong = seen.clone()
    wrong[..., :10] = 9.0
    found, _ = table_plane(wrong, weight, STEP)
    torch.testing.assert_close(found, plane, rtol=0.0, atol=5e-4)


def test_the_fit_is_that_of_least_squares_where_all_pixels_agree(table, rng):
    """Residuals of a thousandth of the scale do not change the weights; numpy solves the same problem."""
    plane, _ = table
    noisy = plane + torch.from_numpy(rng.normal(0.0, 5e-5, plane.shape)).float()
    found, _ = table_plane(noisy, torch.ones_like(plane), STEP)
    y, x = np.meshgrid(np.linspace(-1, 1, 32), np.linspace(-1, 1, 40), indexing="ij")
    A = np.stack([x, y, np.ones_like(x)], -1).reshape(-1, 3)
    expected = A @ np.linalg.lstsq(A, noisy.numpy().reshape(-1).astype(float), rcond=None)[0]
    np.testing.assert_allclose(found.numpy().ravel(), expected, atol=3e-5)


def test_without_a_table_the_plane_is_far_away_and_has_no_support(table):
    _, seen = table
    found, support = table_plane(seen, torch.zeros_like(seen), STEP)
    assert (found.abs() < 1e-3).all()
    assert float(support[0]) == 0.0


def test_each_sample_has_its_own_plane(table):
    plane, seen = table
    both = torch.cat([seen, 2.0 * seen])
    found, _ = table_plane(both, torch.ones_like(both), STEP.expand(2, 1, 1))
    torch.testing.assert_close(found[:1], plane, rtol=0.0, atol=2e-4)
    torch.testing.assert_close(found[1:], 2.0 * plane, rtol=0.0, atol=4e-4)
