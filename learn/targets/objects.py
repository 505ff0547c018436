"""An object as a network is asked to find it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...annotate.boxes import CORNER_SIGNS
from ...annotate.symmetries import Symmetry

#: Below this share of its distance a camera stands on the axis of an object: it sees no side of it more than another.
_ON_AXIS = 1e-6
#: Directions in the camera frame, x right, y down, z away.
_RIGHT, _UP, _AWAY = (np.array(axis) for axis in ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)))


@dataclass(frozen=True, eq=False)
class ViewObject:
    """An object in one view."""

    id: int  #: as in ``instances.png``
    category: str
    transparent: bool
    symmetry: Symmetry  #: how it may be moved and look the same
    fill: float | None  #: share of a vessel's brimful volume; None for what holds nothing
    camera_T_object: np.ndarray  #: (4, 4) float64; of all that look the same, `canonical_pose`
    size: np.ndarray  #: (3,) float64 [m]; the box's centre is the object frame's origin
    visible: int  #: pixels whose first surface it is

    @property
    def corners(self) -> np.ndarray:
        """The box's corners in the camera frame, (8, 3) float64 [m], numbered as `annotate.boxes.CORNER_SIGNS`."""
        return box_points(self.camera_T_object, self.size)


def box_points(camera_T_object: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the corners of boxes in the camera frame, (..., 8, 3) [m], of poses, (..., 4, 4), and sizes, (..., 3)."""
    local = CORNER_SIGNS * (np.asarray(size)[..., None, :] / 2.0)
    return local @ np.swapaxes(camera_T_object[..., :3, :3], -1, -2) + camera_T_object[..., None, :3, 3]


def canonical_pose(camera_T_object: np.ndarray, symmetry: Symmetry) -> np.ndarray:
    """Return the one of all poses that look the same which networks learn.

    A network cannot tell which of them a scene's description has, and the mean of several is none. Taken is the one
    that stands most upright in the picture (z up) and then looks most at the camera (along x); an object of revolution
    looks at it as much as it can, and a ball stands upright.

    Parameters
    ----------
    camera_T_object : (4, 4) float
        A pose.
    symmetry : Symmetry
        How the object may be moved and look the same.
    """
    poses = [camera_T_object @ motion for motion in symmetry.motions]
    if symmetry.ball:
        upright = camera_T_object.copy()
        upright[:3, :3] = np.stack([_RIGHT, _AWAY, _UP], axis=1)
        poses = [upright]
    if symmetry.turns:
        poses = [_turned_to_camera(pose) for pose in poses]
    return max(poses, key=_preference)


def _preference(pose: np.ndarray) -> float:
    towards = -pose[:3, 3] / np.linalg.norm(pose[:3, 3])
    return float(2.0 * (pose[:3, 2] @ _UP) + pose[:3, 0] @ towards)


def _turned_to_camera(camera_T_object: np.ndarray) -> np.ndarray:
    """Return the turn of an object of revolution about its z axis whose x axis points at the camera.

    From the camera on the axis itself, x points up in the picture.
    """
    axis, centre = camera_T_object[:3, 2], camera_T_object[:3, 3]
    x = -centre + axis * (axis @ centre)
    if np.linalg.norm(x) < _ON_AXIS * np.linalg.norm(centre):
        x = _UP - axis * (axis @ _UP)
    x = x / np.linalg.norm(x)
    pose = camera_T_object.copy()
    pose[:3, :3] = np.stack([x, np.cross(axis, x), axis], axis=1)
    return pose
