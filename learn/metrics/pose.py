"""Errors of poses, and of the points of an object that a pose puts somewhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...annotate.symmetries import Symmetry
from .box_iou import turn_about_z

#: Where the curve of accuracy ends, and the distance of the share of good points [m] (Liu et al., "KeyPose", CVPR 2020,
#: section 5.1; Xiang et al., "PoseCNN", RSS 2018, section V-B).
AUC_END, NEAR = 0.10, 0.02


@dataclass(frozen=True)
class PoseErrors:
    """Of one object that was found."""

    translation: float  #: distance of the boxes' middles [m]
    rotation: float  #: angle between the poses [rad]; of an object of revolution, between its axes
    add: float  #: mean distance of the object's points under both poses [m]
    add_s: float  #: mean distance of each point to the nearest one under the other pose [m]
    points: tuple[float, ...]  #: distance of each point [m]


def pose_errors(found: np.ndarray, true: np.ndarray, points: np.ndarray, symmetry: Symmetry) -> PoseErrors:
    """Return the errors of a pose, against the one of all true poses that look the same with the least ADD.

    ADD is Hinterstoisser et al.'s (ACCV 2012, eq. 9), ADD-S Xiang et al.'s ("PoseCNN", eq. 6), over the given points;
    the least over symmetries is BOP's (Hodan et al., "BOP", ECCV 2018, section 3.3). An object of revolution may stand
    at any turn: the found pose is first turned about its axis to be as near to the true one as it can.

    Parameters
    ----------
    found, true : (4, 4) float
        ``camera_T_object`` [m].
    points : (n, 3) float
        Points of the object in its frame [m].
    symmetry : Symmetry
        How the object may be moved and look the same.
    """
    errors = [_errors(found, true @ motion, points, symmetry) for motion in symmetry.motions]
    return min(errors, key=lambda error: error.add)


def _errors(found: np.ndarray, true: np.ndarray, points: np.ndarray, symmetry: Symmetry) -> PoseErrors:
    turned = found.copy()
    if symmetry.ball:
        turned[:3, :3] = true[:3, :3]
    elif symmetry.turns:
        turned = nearest_turn(found, true)
    ours, theirs = (points @ pose[:3, :3].T + pose[:3, 3] for pose in (turned, true))
    distances = np.linalg.norm(ours - theirs, axis=1)
    nearest = np.linalg.norm(ours[None] - theirs[:, None], axis=2).min(axis=1)
    return PoseErrors(
        translation=float(np.linalg.norm(found[:3, 3] - true[:3, 3])),
        rotation=rotation_angle(turned[:3, :3], true[:3, :3]),
        add=float(distances.mean()),
        add_s=float(nearest.mean()),
        points=tuple(distances.tolist()),
    )


def nearest_turn(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Return a pose turned about its own z axis so that its rotation is as near to another's as it can be."""
    relative = found[:3, :3].T @ true[:3, :3]
    angle = np.arctan2(relative[1, 0] - relative[0, 1], relative[0, 0] + relative[1, 1])
    turned = found.copy()
    turned[:3, :3] = found[:3, :3] @ turn_about_z(angle)
    return turned


def rotation_angle(a: np.ndarray, b: np.ndarray) -> float:
    """Return the angle of the rotation between two, (3, 3) [rad], exact for small ones as well.

    2 asin(|A - B|_F / sqrt(8)): the arccosine of the trace loses half of the digits near 0.
    """
    return float(2.0 * np.arcsin(np.clip(np.linalg.norm(a - b) / np.sqrt(8.0), 0.0, 1.0)))


def area_under_curve(distances: Sequence[float], missed: int) -> float:
    """Return the area under the curve of accuracy over thresholds from 0 to `AUC_END`, over its greatest value.

    Accuracy at a threshold is the share of distances below it, so the area is exactly the mean of max(0, 1 - d / end).

    Parameters
    ----------
    distances : sequence of float
        [m]
    missed : int
        How many were not found: they are right at no threshold.
    """
    if not len(distances) + missed:
        return float("nan")
    return float(np.clip(1.0 - np.asarray(distances, float) / AUC_END, 0.0, None).sum() / (len(distances) + missed))


def share_near(distances: Sequence[float], missed: int) -> float:
    """Return the share of distances below `NEAR`, with the missed ones counted as far."""
    if not len(distances) + missed:
        return float("nan")
    return float((np.asarray(distances, float) < NEAR).sum() / (len(distances) + missed))
