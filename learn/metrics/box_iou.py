"""Exact intersection over union (IoU) of oriented 3D boxes."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ...annotate.boxes import CORNER_SIGNS, EDGES
from ...annotate.symmetries import Symmetry
from ..targets.objects import box_points

#: Tolerance of points on the surface of a box, as a fraction of its half side: rounding of float64 products.
_ON_SURFACE = 1e-9
#: Turns of a box about its axis of revolution that are tried, from the one that aligns both boxes [rad]: one every 3
#: degrees, over the 90 degrees after which a square box repeats.
_TURNS = np.radians(np.arange(0.0, 90.0, 3.0))


def box_intersection(pose_a: np.ndarray, size_a: np.ndarray, pose_b: np.ndarray, size_b: np.ndarray) -> float:
    """Return the volume of the intersection of two oriented boxes [m^3].

    The intersection of convex bodies is convex. Its corners are the corners of each body inside the other and the
    points where an edge of one crosses a face of the other; its volume is that of their convex hull. (As in Ahmadyan et
    al., "Objectron", CVPR 2021, section 5.2.)

    Parameters
    ----------
    pose_a, pose_b : (4, 4) float
        ``camera_T_object``; the origin is the centre of the box [m].
    size_a, size_b : (3,) float
        Sides [m].
    """
    if _spheres_are_apart(pose_a, size_a, pose_b, size_b):
        return 0.0
    b_T_a = np.linalg.inv(pose_b) @ pose_a
    corners_a = box_points(b_T_a, size_a)  # all in the frame of b
    corners_b = box_points(np.eye(4), size_b)
    a_T_b = np.linalg.inv(b_T_a)
    points = [corners_a[_inside(corners_a, size_b)]]
    points += [corners_b[_inside(_transformed(a_T_b, corners_b), size_a)]]
    points += [_crossings(corners_a, size_b)]
    points += [_transformed(b_T_a, _crossings(_transformed(a_T_b, corners_b), size_a))]
    return _hull_volume(np.concatenate(points))


def box_iou(pose_a: np.ndarray, size_a: np.ndarray, pose_b: np.ndarray, size_b: np.ndarray) -> float:
    """Return intersection over union, 0 to 1; the parameters are those of `box_intersection`."""
    intersection = box_intersection(pose_a, size_a, pose_b, size_b)
    union = float(np.prod(size_a) + np.prod(size_b)) - intersection
    return float(np.clip(intersection / union, 0.0, 1.0))


def symmetric_box_iou(pose_a: np.ndarray, size_a: np.ndarray, pose_b: np.ndarray, size_b: np.ndarray) -> float:
    """Return the greatest `box_iou` over all turns of box b about its z axis: for an object of revolution.

    Objectron, section 5.2, tries 100 turns. Here the first turn aligns the x axes as well as possible, and the others
    are `_TURNS` from there.
    """
    if _spheres_are_apart(pose_a, size_a, pose_b, size_b):  # at any turn; true of most pairs of an image
        return 0.0
    relative = pose_b[:3, :3].T @ pose_a[:3, :3]
    # The turn that maximises the trace of Rz^T relative.
    start = np.arctan2(relative[1, 0] - relative[0, 1], relative[0, 0] + relative[1, 1])
    best = 0.0
    for turn in start + _TURNS:
        turned = pose_b.copy()
        turned[:3, :3] = pose_b[:3, :3] @ turn_about_z(turn)
        best = max(best, box_iou(pose_a, size_a, turned, size_b))
    return best


def object_iou(
    pose_a: np.ndarray, size_a: np.ndarray, pose_b: np.ndarray, size_b: np.ndarray, symmetry: Symmetry
) -> float:
    """Return the greatest `box_iou` over all poses of object b that look the same (its symmetry).

    Parameters
    ----------
    pose_a, size_a, pose_b, size_b
        As in `box_intersection`.
    symmetry : Symmetry
        Of object b.
    """
    if symmetry.ball:
        turned = pose_b.copy()
        turned[:3, :3] = pose_a[:3, :3]
        return box_iou(pose_a, size_a, turned, size_b)
    overlap = symmetric_box_iou if symmetry.turns else box_iou
    moved = [motion for motion in symmetry.motions[1:] if not _same_box(motion, size_b)]
    return max(overlap(pose_a, size_a, pose_b @ motion, size_b) for motion in [np.eye(4), *moved])


def _same_box(motion: np.ndarray, size: np.ndarray) -> bool:
    """Return whether a motion maps a box around the origin to itself."""
    sides = np.abs(motion[:3, :3])
    upright = np.abs(sides - sides.round()).max() < _ON_SURFACE
    return bool(upright and np.allclose(sides @ size, size, rtol=_ON_SURFACE, atol=0.0) and not motion[:3, 3].any())


def turn_about_z(angle: float) -> np.ndarray:
    """Return the rotation by an angle [rad] about z, (3, 3)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _spheres_are_apart(pose_a: np.ndarray, size_a: np.ndarray, pose_b: np.ndarray, size_b: np.ndarray) -> bool:
    """Return whether the bounding spheres of two boxes are disjoint."""
    distance = np.linalg.norm(pose_a[:3, 3] - pose_b[:3, 3])
    return bool(distance > (np.linalg.norm(size_a) + np.linalg.norm(size_b)) / 2.0)


def _transformed(a_T_b: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ a_T_b[:3, :3].T + a_T_b[:3, 3]


def _inside(points: np.ndarray, size: np.ndarray) -> np.ndarray:
    within = np.abs(points) <= np.asarray(size) / 2.0 * (1.0 + _ON_SURFACE)
    return np.logical_and.reduce(within, axis=1)


def _crossings(corners: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return where the edges of a box, given by its corners, cross the faces of one around the origin, (n, 3)."""
    half = np.asarray(size) / 2.0
    start = corners[[a for a, _ in EDGES]]
    along = corners[[b for _, b in EDGES]] - start
    found = []
    for axis in range(3):
        for side in (-half[axis], half[axis]):
            moves = np.abs(along[:, axis]) > 1e-15 * half[axis]
            fraction = (side - start[moves, axis]) / along[moves, axis]
            points = start[moves] + fraction[:, None] * along[moves]
            others = [other for other in range(3) if other != axis]
            within = (np.abs(points[:, others]) <= half[others] * (1.0 + _ON_SURFACE)).all(axis=1)
            found.append(points[(fraction >= 0.0) & (fraction <= 1.0) & within])
    return np.concatenate(found)


def _hull_volume(points: np.ndarray) -> float:
    if len(points) < len(CORNER_SIGNS) // 2:
        return 0.0
    try:
        return float(ConvexHull(points).volume)
    except QhullError:  # all points in one plane: the boxes only touch
        return 0.0
