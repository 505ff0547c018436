from __future__ import annotations

import numpy as np
import pytest
import torch

from glassware.annotate.projection import inverse_pose, project
from glassware.core.pose import look_at
from glassware.learn.networks.cost_volume import CostVolume
from glassware.learn.networks.layers import convex_upsample, upsample
from glassware.learn.networks.plane_sweep import (
    feature_intrinsics,
    plane_depths,
    plane_sweep_grid,
    source_T_reference,
    warp,
)

HEIGHT, WIDTH = 24, 32
#: Image coordinates in float32 through matrices of condition 100 [px].
PIXELS = 1e-3


def cameras(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Poses around a place near the origin, and a K of its own for each."""
    eyes = [np.array([0.5, -0.3, 0.8]) + rng.uniform(-0.2, 0.2, 3) for _ in range(count)]
    poses = np.stack([look_at(eye, rng.uniform(-0.05, 0.05, 3), rng.uniform(0, 1)) for eye in eyes])
    K = np.stack(
        [[[f, 0.3, 15.0 + x], [0.0, 1.1 * f, 11.0], [0.0, 0.0, 1.0]] for f, x in rng.uniform(25, 40, (count, 2))]
    )
    return poses, K


def grid_of(poses: np.ndarray, K: np.ndarray, planes: torch.Tensor):
    relative = source_T_reference(torch.from_numpy(poses)[None]).float()
    intrinsics = torch.from_numpy(K).float()[None]
    return plane_sweep_grid(relative[:, 0], intrinsics[:, 0], intrinsics[:, 1], planes, (HEIGHT, WIDTH))


def test_planes_stand_at_equal_steps_of_depth_or_of_its_inverse():
    limits = torch.tensor([[0.5, 2.0], [1.0, 3.0]], dtype=torch.float64)
    linear = plane_depths(limits, 4, "linear")
    inverse = plane_depths(limits, 4, "inverse")
    torch.testing.assert_close(linear[0], torch.tensor([0.5, 1.0, 1.5, 2.0], dtype=torch.float64))
    torch.testing.assert_close(1.0 / inverse[0], torch.tensor([2.0, 1.5, 1.0, 0.5], dtype=torch.float64))
    torch.testing.assert_close(inverse[:, [0, -1]], limits)


def test_a_pixel_on_a_plane_appears_where_its_point_of_the_world_projects(rng):
    planes = torch.tensor([[0.6, 0.9, 1.3]])
    for _ in range(5):
        poses, K = cameras(rng, 2)
        pixels, seen = grid_of(poses, K, planes)
        for plane, depth in enumerate(planes[0].tolist()):
            for v, u in [(0, 0), (3, 30), (23, 31), (11, 16)]:
                ray = np.linalg.inv(K[0]) @ [u, v, 1.0]
                point = poses[0] @ [*(depth * ray), 1.0]
                (expected,), (Z,) = project(point[None, :3], K[1], poses[1])
                inside = Z > 0 and -0.5 <= expected[0] <= WIDTH - 0.5 and -0.5 <= expected[1] <= HEIGHT - 0.5
                assert bool(seen[0, plane, v, u]) == inside
                if Z > 0:
                    np.testing.assert_allclose(pixels[0, plane, v, u].numpy(), expected, atol=PIXELS)


def test_points_behind_a_camera_are_not_seen():
    reference = look_at(np.array([0.0, -1.0, 0.5]), np.zeros(3))
    away = look_at(np.array([0.0, -1.0, 0.5]), np.array([0.0, -2.0, 1.0]))
    K = np.array([[30.0, 0.0, 15.5], [0.0, 30.0, 11.5], [0.0, 0.0, 1.0]])
    pixels, seen = grid_of(np.stack([reference, away]), np.stack([K, K]), torch.tensor([[0.5, 1.0, 2.0]]))
    # The opposite direction goes through the same pixels: only the sign of depth tells.
    assert not seen.any()
    assert torch.isfinite(pixels).all()


def test_a_camera_sees_itself_without_a_shift(rng):
    pose, K = cameras(rng, 1)
    pixels, seen = grid_of(np.repeat(pose, 2, axis=0), np.repeat(K, 2, axis=0), torch.tensor([[0.4, 1.0]]))
    features = torch.from_numpy(rng.standard_normal((1, 3, HEIGHT, WIDTH))).float()
    warped = warp(features, pixels)
    # Rounding of the pixel's place, times the difference of two neighbours.
    torch.testing.assert_close(warped, features[:, :, None].expand_as(warped), atol=5e-4, rtol=0)
    assert seen.all()


def test_a_turned_and_moved_view_of_a_textured_plane_matches_at_its_depth():
    """What the released network cannot do: views 18 degrees apart agree at the true depth and at no other."""
    depth, size = 0.8, (96, 128)
    K = np.array([[120.0, 0.0, 63.5], [0.0, 120.0, 47.5], [0.0, 0.0, 1.0]])
    wall = look_at(np.array([0.0, 0.0, depth]), np.zeros(3))  # looks straight down at the plane z = 0
    orbit = np.radians(18.0)
    side = look_at(depth * np.array([np.sin(orbit), 0.0, np.cos(orbit)]), np.zeros(3))
    views = torch.stack([torch.from_numpy(_seen_texture(pose, K, size)) for pose in (wall, side)]).float()[None]
    planes = plane_depths(torch.tensor([[0.5, 1.1]]), 25, "linear")
    relative = source_T_reference(torch.from_numpy(np.stack([wall, side]))[None]).float()
    intrinsics = torch.from_numpy(K).float()[None]
    pixels, seen = plane_sweep_grid(relative[:, 0], intrinsics, intrinsics, planes, size)
    difference = (warp(views[:, 1], pixels) - views[:, :1, :, None].squeeze(1)).abs().mean(1)[0]
    middle = (slice(None), slice(24, 72), slice(32, 96))
    assert seen[0][middle][11:14].all()
    best = torch.where(seen[0], difference, torch.inf)[middle].argmin(0)
    # The true depth is plane 12 of 25.
    assert (best == 12).float().mean() > 0.9


def _seen_texture(pose: np.ndarray, K: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Three smooth patterns on the plane z = 0 as a camera sees them, (3, H, W)."""
    v, u = np.mgrid[: size[0], : size[1]].astype(np.float64)
    rays = np.stack([u, v, np.ones_like(u)], -1) @ np.linalg.inv(K).T @ pose[:3, :3].T
    points = pose[:3, 3] - rays * (pose[2, 3] / rays[..., 2:])
    x, y = points[..., 0], points[..., 1]
    return np.stack([np.sin(70 * x + 9 * y), np.sin(61 * y - 13 * x), np.sin(47 * x + 43 * y)])


def test_a_quarter_of_the_size_is_a_quarter_of_the_image_coordinates():
    K = torch.tensor([[600.0, 2.0, 319.5], [0.0, 610.0, 239.5], [0.0, 0.0, 1.0]])
    point = torch.tensor([0.1, -0.2, 1.3])
    full, small = K @ point, feature_intrinsics(K, 4) @ point
    torch.testing.assert_close(small[:2] / small[2], full[:2] / full[2] / 4.0)


def test_enlarging_keeps_every_value_at_its_place():
    x = torch.arange(6.0)[None, None, None].expand(1, 1, 4, 6)
    wide = upsample(x, 4)
    torch.testing.assert_close(wide[0, 0, 0, :21], torch.arange(21.0) / 4.0)
    torch.testing.assert_close(wide[..., ::4, ::4], x)


@pytest.mark.parametrize("matching", ["concat", "group"])
@pytest.mark.parametrize("fusion", ["mean", "visibility"])
def test_a_view_that_sees_nothing_changes_nothing(tiny, rng, matching, fusion):
    volume = CostVolume(tiny.model_copy(update={"matching": matching, "fusion": fusion})).eval()
    poses, K = cameras(rng, 3)
    poses[2] = inverse_pose(poses[2])  # somewhere else, turned away from all that the reference sees
    poses[2][:3, :3] = poses[0][:3, :3] @ np.diag([1.0, -1.0, -1.0])
    poses[2][:3, 3] = poses[0][:3, 3]
    features = torch.from_numpy(rng.standard_normal((1, 3, 8, 16, 16))).float()
    tensors = [torch.from_numpy(a).float()[None] for a in (poses, K)]
    planes = torch.linspace(0.5, 1.5, 8)[None]
    with torch.inference_mode():
        three = volume(features, *tensors, planes)
        two = volume(features[:, :2], *(t[:, :2] for t in tensors), planes)
    torch.testing.assert_close(three, two)
    assert two.abs().max() > 0


def test_convex_enlarging_is_a_mean_of_nine_with_the_weights_of_each_pixel(rng):
    values = torch.from_numpy(rng.standard_normal((1, 1, 3, 4)))
    logits = torch.from_numpy(rng.standard_normal((1, 9 * 4, 3, 4)))
    wide = convex_upsample(values, logits, 2)
    for y, x in np.ndindex(6, 8):
        row, column, place = y // 2, x // 2, 2 * (y % 2) + x % 2
        rows, columns = (np.clip(np.arange(k - 1, k + 2), 0, n - 1) for k, n in ((row, 3), (column, 4)))
        near = values[0, 0].numpy()[np.ix_(rows, columns)].reshape(-1)
        weight = np.exp(logits[0].numpy().reshape(9, 4, 3, 4)[:, place, row, column])
        assert float(wide[0, 0, y, x]) == pytest.approx((weight * near).sum() / weight.sum())
