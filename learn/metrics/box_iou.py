"""Intersection over union of oriented boxes, exact."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ...annotate.boxes import CORNER_SIGNS, EDGES
from ...annotate.symmetries import Symmetry
from ..targets.objects import box_points

#: A point this far outside a box, as a share of its half side, is still on its surface: rounding of float64 products.
_ON_SURFACE = 1e-9
#: Turns of a box about its axis of revolution that are tried beside the one that lines both boxes up: over the 90
#: degrees after which a square box repeats, one every 3 degrees.
_TURNS = np.radians(np.arange(0.0, 90.0, 3.0))


def box_intersection(pose_a: np.ndarray, size_a: np.ndarray, pose_b: np.ndarray, size_b: np.ndarray) -> float:
    """Return the volume that two oriented boxes share [m^3].

    The intersection of convex bodies is convex, and its corners are the corners of each body inside the other and the
    points where an edge of one passes through a face of the other. The volume is that of their hull. (As in Ahmadyan et
    al., "Objectron", CVPR 2021, section 5.2, with other bookkeeping.)

    Parameters
    ----------
    pose_a, pose_b : (4, 4) float
        ``camera_T_object``; the origin is the box's middle [m].
    size_a, size_b : (3,) float
        Sides [m].
    """
    if _apart(pose_a, size_a, pose_b, size_b):
        return 0.0
    b_T_a = np.linalg.inv(pose_b) @ pose_a
    corners_a = box_points(b_T_a, size_a)  # all in the frame of b
    corners_b = box_points(np.eye(4), size_b)
    a_T_b = np.linalg.inv(b_T_a)
    points = [corners_a[_inside(corners_a, size_b)]]
    points += [corners_b[_inside(_moved(a_T_b, corners_b), size_a)]]
    points += [_crossings(corners_a, size_b)]
    points += [_moved(b_T_a, _crossings(_moved(a_T_b, corners_b), size_a))]
    return _hull_volume(np.concatenate(points))


def box_iou(pose_a: np.ndarray, size_a: np.ndarray, pose_b: np.ndarray, size_b: np.ndarray) -> float:
    """Return intersection over union, 0 to 1; the parameters are those of `box_intersection`."""
    shared = box_intersection(pose_a, size_a, pose_b, size_b)
    union = float(np.prod(size_a) + np.prod(size_b)) - shared
    return float(np.clip(shared / union, 0.0, 1.0))


def symmetric_box_iou(pose_a: np.ndarray, size_a: np.ndarray, pose_b: np.ndarray, size_b: np.ndarray) -> float:
    """Return the greatest `box_iou` over all turns of box b about its z axis.

    For an object of revolution, whose box may stand at any turn. (Objectron, section 5.2, tries 100 turns.) Tried are
    the turn that brings the x axes nearest to each other and `_TURNS` from there.
    """
    if _apart(pose_a, size_a, pose_b, size_b):  # whatever the turn: most pairs of a picture
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
    """Return the greatest `box_iou` over all poses of object b that look the same.

    Parameters
    ----------
    pose_a, size_a, pose_b, size_b
        As of `box_intersection`.
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
    """Tell whether a motion takes a box about the origin to itself."""
    sides = np.abs(motion[:3, :3])
    upright = np.abs(sides - sides.round()).max() < _ON_SURFACE
    return bool(upright and np.allclose(sides @ size, size, rtol=_ON_SURFACE, atol=0.0) and not motion[:3, 3].any())


def turn_about_z(angle: float) -> np.ndarray:
    """Return the rotation by an angle [rad] about z, (3, 3)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _apart(pose_a: np.ndarray, size_a: np.ndarray, pose_b: np.ndarray, size_b: np.ndarray) -> bool:
    """Tell whether the spheres round two boxes share nothing."""
    away = np.linalg.norm(pose_a[:3, 3] - pose_b[:3, 3])
    return bool(away > (np.linalg.norm(size_a) + np.linalg.norm(size_b)) / 2.0)


def _moved(a_T_b: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ a_T_b[:3, :3].T + a_T_b[:3, 3]


def _inside(points: np.ndarray, size: np.ndarray) -> np.ndarray:
    within = np.abs(points) <= np.asarray(size) / 2.0 * (1.0 + _ON_SURFACE)
    return np.logical_and.reduce(within, axis=1)


def _crossings(corners: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return where the edges of a box, by its corners, pass through the faces of one about the origin, (n, 3)."""
    half = np.asarray(size) / 2.0
    start = corners[[a for a, _ in EDGES]]
    along = corners[[b for _, b in EDGES]] - start
    found = []
    for axis in range(3):
        for side in (-half[axis], half[axis]):
            moves = np.abs(along[:, axis]) > 1e-15 * half[axis]
            share = (side - start[moves, axis]) / along[moves, axis]
            points = start[moves] + share[:, None] * along[moves]
            others = [other for other in range(3) if other != axis]
            within = (np.abs(points[:, others]) <= half[others] * (1.0 + _ON_SURFACE)).all(axis=1)
            found.append(points[(share >= 0.0) & (share <= 1.0) & within])
    return np.concatenate(found)


def _hull_volume(points: np.ndarray) -> float:
    if len(points) < len(CORNER_SIGNS) // 2:
        return 0.0
    try:
        return float(ConvexHull(points).volume)
    except QhullError:  # all points in one plane: the boxes only touch
        return 0.0
