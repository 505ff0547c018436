from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection
from scipy.spatial.transform import Rotation

from glassware.annotate.symmetries import ASYMMETRIC, BALL, Symmetry, motions_of
from glassware.learn.metrics.box_iou import box_intersection, box_iou, object_iou, symmetric_box_iou
from glassware.procedural.props.blocks import extrusion

#: Two exact methods in float64 differ by rounding alone; the planes that qhull merges make some 1e-10 of a side.
EXACT = 1e-7


def pose(rotation: Rotation, translation) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation.as_matrix(), translation
    return matrix


def random_box(rng, spread: float):
    rotation = Rotation.from_rotvec(rng.uniform(-3, 3, 3))
    return pose(rotation, rng.uniform(-spread, spread, 3)), rng.uniform(0.05, 0.4, 3)


def volume_by_half_spaces(pose_a, size_a, pose_b, size_b) -> float:
    """The same volume from the twelve half spaces of both boxes and a point inside all of them."""
    rows = []
    for box, size in ((pose_a, size_a), (pose_b, size_b)):
        for axis in range(3):
            for sign in (-1.0, 1.0):
                normal = sign * box[:3, axis]
                rows.append([*normal, -normal @ box[:3, 3] - size[axis] / 2.0])
    planes = np.array(rows)
    # The largest ball inside: its centre is where the intersection is looked for.
    found = linprog(
        [0, 0, 0, -1], A_ub=np.c_[planes[:, :3], np.ones(12)], b_ub=-planes[:, 3], bounds=[(None, None)] * 4
    )
    if not found.success or found.x[3] <= 1e-9:
        return 0.0
    return ConvexHull(HalfspaceIntersection(planes, found.x[:3]).intersections).volume


@pytest.mark.parametrize("spread", [0.02, 0.1, 0.25])
def test_the_volume_agrees_with_that_of_the_half_spaces(rng, spread):
    volumes = []
    for _ in range(100):
        boxes = (*random_box(rng, spread), *random_box(rng, spread))
        expected = volume_by_half_spaces(*boxes)
        assert box_intersection(*boxes) == pytest.approx(expected, abs=EXACT * 0.4**3)
        volumes.append(expected)
    assert max(volumes) > 0.0


def test_boxes_that_share_axes_have_the_iou_of_intervals(rng):
    for _ in range(50):
        size_a, size_b, shift = rng.uniform(0.1, 0.5, 3), rng.uniform(0.1, 0.5, 3), rng.uniform(-0.3, 0.3, 3)
        common = pose(Rotation.from_rotvec(rng.uniform(-3, 3, 3)), rng.uniform(-1, 1, 3))
        moved = common @ pose(Rotation.identity(), shift)
        low, high = np.maximum(-size_a / 2, shift - size_b / 2), np.minimum(size_a / 2, shift + size_b / 2)
        shared = np.prod(np.clip(high - low, 0.0, None))
        expected = shared / (np.prod(size_a) + np.prod(size_b) - shared)
        assert box_iou(common, size_a, moved, size_b) == pytest.approx(expected, abs=EXACT)


def test_a_cube_and_itself_turned_by_45_degrees_share_an_octagonal_prism():
    # Axis-aligned boxes of the corners, which the released code compares, would give 0.5.
    turned = pose(Rotation.from_euler("z", 45, degrees=True), [0, 0, 0])
    octagon = 2.0 * (np.sqrt(2.0) - 1.0)  # area inside both unit squares
    assert box_iou(np.eye(4), np.ones(3), turned, np.ones(3)) == pytest.approx(octagon / (2.0 - octagon), abs=EXACT)


def test_equal_touching_and_distant_boxes_have_the_iou_one_and_zero(rng):
    for _ in range(20):
        box = random_box(rng, 0.3)
        assert box_iou(*box, *box) == pytest.approx(1.0, abs=EXACT)
        for distance in (1.0, 2.0):
            moved = box[0] @ pose(Rotation.identity(), [distance * box[1][0], 0, 0])
            assert box_iou(*box, moved, box[1]) == pytest.approx(0.0, abs=EXACT)


def test_a_turn_about_the_axis_of_revolution_does_not_count(rng):
    for _ in range(20):
        matrix, size = random_box(rng, 0.3)
        size[1] = size[0]
        turned = matrix @ pose(Rotation.from_euler("z", rng.uniform(0, 360), degrees=True), [0, 0, 0])
        assert symmetric_box_iou(turned, size, matrix, size) == pytest.approx(1.0, abs=EXACT)
        # A tilt does: of a box three times as long as wide, a third lies in its tilted self.
        long, tilted = (
            size[0] * np.array([1, 1, 3]),
            matrix @ pose(Rotation.from_euler("x", 90, degrees=True), [0, 0, 0]),
        )
        assert symmetric_box_iou(tilted, long, matrix, long) == pytest.approx(1 / 5, abs=EXACT)


def test_boxes_of_objects_that_look_the_same_overlap_as_much_as_any_of_them(rng):
    """A triangular prism's box moves as it turns; a ball's may stand anyhow; half turns leave a box where it is."""
    turns = 2 * np.pi * np.arange(3) / 3
    mesh = extrusion("prism", 0.05 * np.stack([np.cos(turns), np.sin(turns)], axis=1), 0.08)[0]
    size = np.ptp(mesh.bounds, axis=0)
    kind = Symmetry(False, False, motions_of(mesh))
    assert len(kind.motions) == 6
    for _ in range(5):
        true, _ = random_box(rng, 0.2)
        for motion in kind.motions:
            assert object_iou(true @ motion, size, true, size, kind) == pytest.approx(1.0, abs=EXACT)
        assert object_iou(true @ kind.motions[-1], size, true, size, ASYMMETRIC) < 1.0
        other, _ = random_box(rng, 0.2)
        other[:3, 3] = true[:3, 3]
        cube = np.full(3, 0.1)
        assert object_iou(other, cube, true, cube, BALL) == pytest.approx(1.0, abs=EXACT)
        assert object_iou(other, cube, true, cube, ASYMMETRIC) < 1.0
        sides = rng.uniform(0.05, 0.1, 3)
        half = Symmetry(False, False, np.stack([np.eye(4), np.diag([1.0, -1.0, -1.0, 1.0])]))
        assert object_iou(other, sides, true, sides, half) == pytest.approx(box_iou(other, sides, true, sides))
