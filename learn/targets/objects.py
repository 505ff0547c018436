"""An object in a view as a network learns it: box, category, and one pose of all that look the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...annotate.boxes import CORNER_SIGNS
from ...annotate.symmetries import Symmetry

#: A camera nearer to the axis of an object than this fraction of its distance is on the axis: it sees all sides alike.
_ON_AXIS = 1e-6
#: Directions in the camera frame, x right, y down, z away.
_RIGHT, _UP, _AWAY = (np.array(axis) for axis in ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)))


@dataclass(frozen=True, eq=False)
class ViewObject:
    """An object in one view."""

    id: int  #: as in ``instances.png``
    category: str
    transparent: bool
    symmetry: Symmetry  #: motions under which it looks the same
    fill: float | None  #: fraction of a vessel's volume that is filled; None without liquid
    camera_T_object: np.ndarray  #: (4, 4) float64; the `canonical_pose`
    size: np.ndarray  #: (3,) float64 [m]; the box's centre is the object frame's origin
    visible: int  #: number of pixels where it is the first surface

    @property
    def corners(self) -> np.ndarray:
        """The box corners in the camera frame, (8, 3) float64 [m], numbered as in `annotate.boxes.CORNER_SIGNS`."""
        return box_points(self.camera_T_object, self.size)


def box_points(camera_T_object: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the corners of boxes in the camera frame, (..., 8, 3) [m], of poses, (..., 4, 4), and sizes, (..., 3)."""
    local = CORNER_SIGNS * (np.asarray(size)[..., None, :] / 2.0)
    return local @ np.swapaxes(camera_T_object[..., :3, :3], -1, -2) + camera_T_object[..., None, :3, 3]


def canonical_pose(camera_T_object: np.ndarray, symmetry: Symmetry) -> np.ndarray:
    """Return the pose that networks learn, of all poses that look the same.

    A network cannot know which of them a scene description has, and the mean of several is none of them. The canonical
    pose is the most upright in the image (z up), and of those the one whose x axis points most towards the camera; that
    of an object of revolution points to it as far as possible, and a ball is upright.

    Parameters
    ----------
    camera_T_object : (4, 4) float
        Any pose of the object.
    symmetry : Symmetry
        Motions under which the object looks the same.
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
    """Return the pose of an object of revolution, rotated about its z axis so that x points at the camera.

    For a camera on the axis, x points up in the image.
    """
    axis, centre = camera_T_object[:3, 2], camera_T_object[:3, 3]
    x = -centre + axis * (axis @ centre)
    if np.linalg.norm(x) < _ON_AXIS * np.linalg.norm(centre):
        x = _UP - axis * (axis @ _UP)
    x = x / np.linalg.norm(x)
    pose = camera_T_object.copy()
    pose[:3, :3] = np.stack([x, np.cross(axis, x), axis], axis=1)
    return pose
