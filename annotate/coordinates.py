"""Object coordinates: where each pixel is on its object, in the object's own frame and scaled to a unit cube.

The normalised coordinates of Wang et al., "Normalized Object Coordinate Space for Category-Level 6D Object Pose and
Size Estimation", CVPR 2019, section 3: the bounding box stands in the middle of the unit cube, and its diagonal has the
length 1.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..render.frame import Layers
from .labels import ObjectLabel
from .projection import inverse_pose, transformed, unproject


def object_coordinates(Z: np.ndarray, ids: np.ndarray, objects: Iterable[ObjectLabel], K: np.ndarray) -> np.ndarray:
    """Return the normalised object coordinates of points, ``0.5 + p / |size|`` for a point p in the object's frame.

    Parameters
    ----------
    Z : (H, W) float
        Planar depth of the points [m]; +inf for none.
    ids : (H, W) integer
        The object that each point is on.
    objects : iterable of ObjectLabel
        The objects, with their poses in the camera's frame and their boxes.
    K : (3, 3) float
        Intrinsic matrix [px].

    Returns
    -------
    (H, W, 3) float32
        Coordinates in [0, 1] (beyond by rounding); NaN where there is no object.
    """
    points, found = unproject(Z, K), np.full((*Z.shape, 3), np.nan, np.float32)
    for item in objects:
        on = (ids == item.id) & np.isfinite(Z)
        if on.any():
            local = transformed(inverse_pose(np.asarray(item.camera_T_object)), points[on])
            found[on] = 0.5 + local / box_diagonal(item)
    return found


def box_diagonal(item: ObjectLabel) -> float:
    """Return the length of the diagonal of an object's bounding box [m]."""
    corners = np.asarray(item.box3d)
    return float(np.linalg.norm(corners[7] - corners[0]))


def back_wall(layers: Layers, ids: np.ndarray) -> np.ndarray:
    """Return the planar depth of the last surface of each pixel's own object along its straight ray.

    For a vessel that is the back wall's outside: what a hand would touch behind it. Where something opaque is inside or
    in front, or the ray has more surfaces than there are layers, it is the last of those that are recorded.

    Parameters
    ----------
    layers : Layers
        Surfaces along the rays.
    ids : (H, W) integer
        Instance ids of the first surface; 0 and 1 (nothing and the table) have no back wall.

    Returns
    -------
    (H, W) float32
        Depth [m]; +inf for none.
    """
    own = (layers.id == ids) & np.isfinite(layers.Z) & (ids > 1)
    depth = np.where(own, layers.Z, -np.inf).max(axis=0, initial=-np.inf)
    return np.where(np.isfinite(depth), depth, np.inf).astype(np.float32)
