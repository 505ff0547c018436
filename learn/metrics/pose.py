"""Pose errors: translation, rotation, ADD, ADD-S, and the accuracy of keypoints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...annotate.symmetries import Symmetry
from .box_iou import turn_about_z

#: Greatest threshold of the accuracy curve, and the distance below which a keypoint is near [m] (Liu et al., "KeyPose",
#: CVPR 2020, section 5.1; Xiang et al., "PoseCNN", RSS 2018, section V-B).
AUC_LIMIT, NEAR = 0.10, 0.02


@dataclass(frozen=True)
class PoseErrors:
    """Pose errors of one detected object."""

    translation: float  #: distance of the box centres [m]
    rotation: float  #: angle between the poses [rad]; between the axes for an object of revolution
    add: float  #: mean distance between the points of the surface under both poses [m]
    add_s: float  #: mean distance of each point to the nearest point under the other pose [m]
    points: tuple[float, ...]  #: distance of each keypoint under both poses [m]


def pose_errors(
    found: np.ndarray, true: np.ndarray, points: np.ndarray, symmetry: Symmetry, surface: np.ndarray | None = None
) -> PoseErrors:
    """Return the errors of a pose; of all true poses that look the same, the one with the least ADD is taken.

    ADD is that of Hinterstoisser et al. (ACCV 2012, eq. 9), ADD-S that of Xiang et al. ("PoseCNN", eq. 6), over points
    of the surface: with few of them the nearest point is far away, and over 8 keypoints ADD-S is about twice that over
    2,000 points. The minimum over symmetries is that of Hodan et al. ("BOP", ECCV 2018, section 3.3). The pose of an
    object of revolution is first rotated about its axis to be as near to the true one as possible.

    Parameters
    ----------
    found, true : (4, 4) float
        ``camera_T_object`` [m].
    points : (n, 3) float
        Keypoints of the object in its frame [m].
    symmetry : Symmetry
        Motions under which the object looks the same.
    surface : (m, 3) float, optional
        Points of its surface in its frame, over which ADD and ADD-S are taken [m]; by default the keypoints.
    """
    dense = points if surface is None else surface
    errors = [_errors(found, true @ motion, points, symmetry, dense) for motion in symmetry.motions]
    return min(errors, key=lambda error: error.add)


def _errors(
    found: np.ndarray, true: np.ndarray, points: np.ndarray, symmetry: Symmetry, surface: np.ndarray
) -> PoseErrors:
    turned = found.copy()
    if symmetry.ball:
        turned[:3, :3] = true[:3, :3]
    elif symmetry.turns:
        turned = nearest_turn(found, true)
    dense_found, dense_true = (_moved(surface, pose) for pose in (turned, true))
    return PoseErrors(
        translation=float(np.linalg.norm(found[:3, 3] - true[:3, 3])),
        rotation=rotation_angle(turned[:3, :3], true[:3, :3]),
        add=float(np.linalg.norm(dense_found - dense_true, axis=1).mean()),
        add_s=float(cKDTree(dense_found).query(dense_true)[0].mean()),
        points=tuple(np.linalg.norm(_moved(points, turned) - _moved(points, true), axis=1).tolist()),
    )


def _moved(points: np.ndarray, pose: np.ndarray) -> np.ndarray:
    return points @ pose[:3, :3].T + pose[:3, 3]


def nearest_turn(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Return a pose rotated about its own z axis so that its rotation is as near to another as possible."""
    relative = found[:3, :3].T @ true[:3, :3]
    angle = np.arctan2(relative[1, 0] - relative[0, 1], relative[0, 0] + relative[1, 1])
    turned = found.copy()
    turned[:3, :3] = found[:3, :3] @ turn_about_z(angle)
    return turned


def rotation_angle(a: np.ndarray, b: np.ndarray) -> float:
    """Return the angle between two rotations, (3, 3) [rad], exact for small angles as well.

    2 asin(|A - B|_F / sqrt(8)): the arccosine of the trace would lose half of the digits near 0.
    """
    return float(2.0 * np.arcsin(np.clip(np.linalg.norm(a - b) / np.sqrt(8.0), 0.0, 1.0)))


def area_under_curve(distances: Sequence[float], missed: int) -> float:
    """Return the area under the accuracy curve (AUC) over thresholds from 0 to `AUC_LIMIT`, normalised to 0 to 1.

    Accuracy is the fraction of distances below a threshold, so the area is exactly the mean of max(0, 1 - d / limit).

    Parameters
    ----------
    distances : sequence of float
        Distances of keypoints [m].
    missed : int
        Number of keypoints of missed objects, which are below no threshold.
    """
    if not len(distances) + missed:
        return float("nan")
    return float(np.clip(1.0 - np.asarray(distances, float) / AUC_LIMIT, 0.0, None).sum() / (len(distances) + missed))


def fraction_near(distances: Sequence[float], missed: int) -> float:
    """Return the fraction of distances below `NEAR`, with those of missed objects above it."""
    if not len(distances) + missed:
        return float("nan")
    return float((np.asarray(distances, float) < NEAR).sum() / (len(distances) + missed))
