"""An object as a network is asked to find it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..annotate.boxes import CORNER_SIGNS

#: Below this share of its distance a camera stands on the axis of an object: it sees no side of it more than another.
_ON_AXIS = 1e-6


@dataclass(frozen=True, eq=False)
class ViewObject:
    """An object in one view."""

    id: int  #: as in ``instances.png``
    category: str
    transparent: bool
    symmetric: bool  #: the same under every turn about its z axis
    fill: float | None  #: share of a vessel's brimful volume; None for what holds nothing
    camera_T_object: np.ndarray  #: (4, 4) float64; `canonical_pose` of what is symmetric
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


def canonical_pose(camera_T_object: np.ndarray) -> np.ndarray:
    """Return the one of all poses of an object of revolution whose x axis points at the camera.

    A turn about its axis changes nothing that can be seen, so a network cannot tell which turn a scene's description
    has. From the camera on the axis itself, x points up in the picture.

    Parameters
    ----------
    camera_T_object : (4, 4) float
        A pose; the axis of revolution is the object's z axis, through its origin.
    """
    axis, centre = camera_T_object[:3, 2], camera_T_object[:3, 3]
    x = -centre + axis * (axis @ centre)
    if np.linalg.norm(x) < _ON_AXIS * np.linalg.norm(centre):
        up = np.array([0.0, -1.0, 0.0])
        x = up - axis * (axis @ up)
    x = x / np.linalg.norm(x)
    pose = camera_T_object.copy()
    pose[:3, :3] = np.stack([x, np.cross(axis, x), axis], axis=1)
    return pose
