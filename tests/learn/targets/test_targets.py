from __future__ import annotations

import numpy as np
import pytest
import torch
import trimesh
from scipy.spatial.transform import Rotation
from scipy.stats import multivariate_normal

from glassware.annotate.heatmap import MIN_PIXELS, Gaussian, gaussian_of, heatmap
from glassware.annotate.projection import project_camera
from glassware.annotate.symmetries import ASYMMETRIC, BALL, REVOLUTION, Symmetry, motions_of
from glassware.core.mesh import Mesh
from glassware.learn.targets.encoding import (
    CORRECTED,
    REFERENCE,
    decoded_covariance,
    decoded_depth,
    decoded_vertices,
    encoded_covariance,
    encoded_depth,
    encoded_vertices,
)
from glassware.learn.targets.fields import STRIDE, box_covariance, cell_owners
from glassware.learn.targets.objects import ViewObject, box_points, canonical_pose
from glassware.learn.targets.view import detectable, view_targets

HEIGHT, WIDTH = 96, 128
#: Heat in float32.
HEAT = 1e-5
K = np.array([[130.0, 0.0, 61.0], [0.0, 133.0, 50.0], [0.0, 0.0, 1.0]])


def test_the_heat_is_the_density_over_its_peak(rng):
    masks = np.zeros((2, HEIGHT, WIDTH), bool)
    masks[0, 20:50, 30:41], masks[1, 60:70, 50:100] = True, True
    masks[1] &= rng.uniform(size=(HEIGHT, WIDTH)) < 0.7
    maps = []
    for mask in masks:
        y, x = np.nonzero(mask)
        spread = 0.8 * (np.cov(np.stack([x, y]), bias=True) + np.eye(2) / 12.0)
        density = multivariate_normal([x.mean(), y.mean()], spread)
        grid = np.stack(np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT)), axis=-1)
        maps.append(density.pdf(grid) / density.pdf(density.mean))
    found = heatmap([gaussian_of(mask) for mask in masks], (HEIGHT, WIDTH))
    np.testing.assert_allclose(found, np.maximum(*maps), atol=HEAT)


@pytest.mark.parametrize("pixels", [[(5, 5)], [(5, x) for x in range(3, 30)]])
def test_a_point_or_a_row_of_pixels_has_a_peak_as_well(pixels):
    mask = np.zeros((HEIGHT, WIDTH), bool)
    for y, x in pixels:
        mask[y, x] = True
    heat = heatmap([gaussian_of(mask)], (HEIGHT, WIDTH))
    assert np.isfinite(heat).all()
    assert np.unravel_index(heat.argmax(), heat.shape) == (5, int(np.mean([x for _, x in pixels])))


def test_a_cell_belongs_to_the_hottest_object_and_the_one_read_at_a_peak_to_its_own():
    small, large = (
        Gaussian(np.array([20.0, 20.0]), 4.0 * np.eye(2)),
        Gaussian(np.array([40.0, 24.0]), 400.0 * np.eye(2)),
    )
    owner, cell_mask = cell_owners([small, large], (HEIGHT, WIDTH))
    assert owner[24 // STRIDE, 40 // STRIDE] == 1
    # At pixel (16, 16) the large one is hotter, 1.3 deviations from its middle against 2.8. But (20, 20) is read there.
    assert owner[2, 2] == 0
    assert cell_mask[2, 2]
    assert owner[8, 8] == 1
    assert not cell_mask[11, 15]


def test_of_two_peaks_in_a_cell_the_nearer_to_its_pixel_is_kept():
    first, second = (Gaussian(np.array([17.0 + d, 16.0]), 9.0 * np.eye(2)) for d in (0.0, 2.0))
    assert cell_owners([first, second], (HEIGHT, WIDTH))[0][2, 2] == 0
    assert cell_owners([second, first], (HEIGHT, WIDTH))[0][2, 2] == 1


BLENDER = ["---", "--+", "-++", "-+-", "+--", "+-+", "+++", "++-"]


@pytest.mark.parametrize(("encoding", "names"), [(REFERENCE, BLENDER), (CORRECTED, None)])
def test_vertex_channels_follow_the_formula_in_their_order(rng, encoding, names):
    size, pose = np.array([0.1, 0.2, 0.3]), np.eye(4)
    corners = box_points(pose, size)
    for stored, name in enumerate(names or []):
        signs = [1 if sign == "+" else -1 for sign in name]
        np.testing.assert_allclose(corners[encoding.corners[stored]], size / 2 * signs)
    vertices, at = rng.uniform(-50, 150, (4, 8, 2)), rng.integers(0, 90, (4, 2)).astype(float)
    values = encoded_vertices(vertices, at, (HEIGHT, WIDTH), encoding)
    for row in range(4):
        for stored in range(8):
            u, v = vertices[row, encoding.corners[stored]]
            x, y = at[row]
            assert values[row, 2 * stored] == pytest.approx(100 * (1 - ((y - v) + HEIGHT) / (2 * HEIGHT)))
            assert values[row, 2 * stored + 1] == pytest.approx(100 * (1 - ((x - u) + WIDTH) / (2 * WIDTH)))
    back = decoded_vertices(torch.from_numpy(values), torch.from_numpy(at), (HEIGHT, WIDTH), encoding)
    np.testing.assert_allclose(back.numpy(), vertices)


def test_depth_and_covariance_are_in_the_axes_of_their_network(rng):
    """The released network's camera is Blender's: y up, z backwards."""
    z, points = np.array([0.7, 1.4]), rng.standard_normal((2, 3, 500)) * [[[0.1], [0.2], [0.05]]]
    points = Rotation.from_rotvec([0.3, 0.5, -0.2]).as_matrix() @ points
    for encoding, axes in ((CORRECTED, np.eye(3)), (REFERENCE, np.diag([1.0, -1.0, -1.0]))):
        expected = 100 * (axes[2, 2] * z - 1.0)
        np.testing.assert_allclose(encoded_depth(z, encoding), expected)
        np.testing.assert_allclose(decoded_depth(torch.from_numpy(expected), encoding).numpy(), z)
        covariance = np.stack([np.cov(cloud) for cloud in points])
        turned = np.stack([np.cov(axes @ cloud) for cloud in points])
        channels = 1000 * np.stack([turned[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))], 1)
        np.testing.assert_allclose(encoded_covariance(covariance, encoding), channels)
        np.testing.assert_allclose(decoded_covariance(torch.from_numpy(channels), encoding).numpy(), covariance)


def test_the_covariance_is_that_of_points_all_over_the_box(rng):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec([0.3, -1.0, 0.7]).as_matrix()
    size, count = np.array([0.1, 0.3, 0.2]), 200_000
    points = (rng.uniform(-0.5, 0.5, (count, 3)) * size) @ pose[:3, :3].T
    # The deviation of a sample covariance is at most sqrt(2 / n) of the largest variance; five of them.
    np.testing.assert_allclose(box_covariance(pose, size), np.cov(points.T), atol=5 * np.sqrt(2 / count) * 0.3**2 / 12)


def item(number: int, pose: np.ndarray, size: np.ndarray, ids: np.ndarray, transparent: bool = True) -> ViewObject:
    return ViewObject(number, "box", transparent, ASYMMETRIC, None, pose, size, int((ids == number).sum()))


def at(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def test_a_views_targets_say_what_its_labels_do():
    ids = np.ones((HEIGHT, WIDTH), np.uint16)
    ids[:20], ids[40:60, 40:60], ids[50:58, 70:90] = 0, 2, 3
    Z = np.where(ids == 0, np.inf, 1.0).astype(np.float32)
    Z[ids == 2], Z[ids == 3] = 0.8, 0.7
    objects = [
        item(2, at(-0.07, 0.0, 0.9), np.full(3, 0.1), ids),
        item(3, at(0.1, 0.02, 0.75), np.ones(3) / 9, ids, False),
    ]
    targets = view_targets(ids, Z, objects, K, CORRECTED)
    np.testing.assert_array_equal(targets["seg"], ids.astype(int))
    np.testing.assert_array_equal(targets["depth"], np.where(ids == 0, 0.0, Z))
    np.testing.assert_array_equal(targets["object_mask"], ids >= 2)
    for number, middle in ((2, (49.5, 49.5)), (3, (79.5, 53.5))):
        y, x = np.nonzero(ids == number)
        lead = np.stack([x, y]) + HEIGHT * targets["offset"][:, y, x]
        np.testing.assert_allclose(lead, np.array([middle] * len(x)).T, atol=1e-4)
    for number, (row, column) in ((2, (6, 6)), (3, (7, 10))):
        box = objects[number - 2]
        assert targets["cell_mask"][row, column]
        vertices = project_camera(box.corners, K)[0]
        cell = np.array([[8.0 * column, 8.0 * row]])
        expected = encoded_vertices(vertices[None], cell, (HEIGHT, WIDTH), CORRECTED)[0]
        np.testing.assert_allclose(targets["vertex"][:, row, column], expected, rtol=1e-6)
        assert targets["z_centroid"][row, column] == pytest.approx(100 * (box.camera_T_object[2, 3] - 1.0), rel=1e-6)


def test_a_speck_and_what_reaches_behind_the_camera_are_not_to_be_found():
    ids = np.zeros((HEIGHT, WIDTH), np.uint16)
    ids[10, : MIN_PIXELS - 1], ids[20, :MIN_PIXELS], ids[40:60, 40:60] = 2, 3, 4
    objects = [item(n, at(0, 0, 0.9), np.full(3, 0.1), ids) for n in (2, 3)] + [
        item(4, at(0, 0, 0.9), np.full(3, 2.0), ids)
    ]
    assert [found.id for found in detectable(objects)] == [3]
    targets = view_targets(ids, np.ones((HEIGHT, WIDTH), np.float32), objects, K, CORRECTED)
    np.testing.assert_array_equal(targets["object_mask"], ids == 3)
    # The classes are of all pixels.
    assert (targets["seg"][ids >= 2] == 2).all()


def test_the_pose_of_an_object_of_revolution_does_not_depend_on_its_turn(rng):
    for _ in range(20):
        pose = np.eye(4)
        pose[:3, :3] = Rotation.random(random_state=rng).as_matrix()
        pose[:3, 3] = rng.uniform([-0.2, -0.2, 0.8], [0.2, 0.2, 1.2])
        found = canonical_pose(pose, REVOLUTION)
        np.testing.assert_allclose(found[:3, :3].T @ found[:3, :3], np.eye(3), atol=1e-12)
        assert np.linalg.det(found[:3, :3]) == pytest.approx(1.0)
        np.testing.assert_allclose(found[:, 2:], pose[:, 2:])
        # The camera lies in the half plane of z and +x.
        camera = np.linalg.inv(found)[:3, 3]
        assert camera[1] == pytest.approx(0.0, abs=1e-9)
        assert camera[0] > 0
        turned = pose.copy()
        turned[:3, :3] = pose[:3, :3] @ Rotation.from_euler("z", rng.uniform(0, 6)).as_matrix()
        np.testing.assert_allclose(canonical_pose(turned, REVOLUTION), found, atol=1e-9)


def test_from_the_axis_itself_x_points_up_in_the_picture():
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = 0, 0, 0.8
    np.testing.assert_allclose(canonical_pose(pose, REVOLUTION)[:3, 0], [0, -1, 0])


def test_poses_that_look_the_same_have_one_that_is_learnt(rng):
    """A block with a square section has eight; a ball has all."""
    box = trimesh.creation.box((1.0, 1.0, 3.0))
    kind = Symmetry(False, False, motions_of(Mesh("block", box.vertices, box.faces)))
    assert len(kind.motions) == 8
    for _ in range(20):
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = Rotation.random(random_state=rng).as_matrix(), (0.1, -0.1, 0.9)
        found = canonical_pose(pose, kind)
        for motion in kind.motions:
            np.testing.assert_allclose(canonical_pose(pose @ motion, kind), found, atol=1e-9)
        assert any(np.allclose(pose @ motion, found) for motion in kind.motions)
        # No other stands more upright and looks more at the camera.
        assert found[:3, 2] @ [0, -1, 0] >= -1e-9
        ball = canonical_pose(pose, BALL)
        np.testing.assert_allclose(ball[:3, 2], [0, -1, 0], atol=1e-12)
        turned = pose.copy()
        turned[:3, :3] = Rotation.random(random_state=rng).as_matrix()
        np.testing.assert_allclose(canonical_pose(turned, BALL), ball, atol=1e-12)
