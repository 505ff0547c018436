"""Poses of frames that point at something, such as cameras and lamps."""

from __future__ import annotations

import math

import numpy as np

from .arguments import number, point
from .errors import InputError

#: Horizontal offset below which the camera stands at the zenith [fraction of the distance]: it is rounding error.
_AT_ZENITH = 1e-9
#: Largest error of a rotation's entries, and of its rows' products [1]. Poses typed with seven digits pass; the error
#: moves a point one metre away by a micrometre.
RIGID_TOLERANCE = 1e-6


def aimed_frame(position: np.ndarray, ahead: np.ndarray, sideways: np.ndarray, turn: float) -> np.ndarray:
    """Return the pose of a frame whose z axis points ahead.

    Parameters
    ----------
    position : (3,) float
        Origin of the frame, world frame [m].
    ahead : (3,) float
        Unit direction of its z axis.
    sideways : (3,) float
        Direction of its x axis before the turn, across `ahead`; any length.
    turn : float
        Turn about the z axis, from x towards y [rad].

    Returns
    -------
    (4, 4) float64
        ``world_T_frame``.
    """
    x = sideways / np.linalg.norm(sideways)
    y = np.cross(ahead, x)
    pose = np.eye(4)
    pose[:3, 0] = math.cos(turn) * x + math.sin(turn) * y
    pose[:3, 1] = math.cos(turn) * y - math.sin(turn) * x
    pose[:3, 2] = ahead
    pose[:3, 3] = position
    return pose


def look_at(eye: np.ndarray, target: np.ndarray, roll: float = 0.0) -> np.ndarray:
    """Return the pose of a camera that looks at a point, with +z up in the picture.

    Straight above or below the target, where +z has no direction in the picture, up is -x: the limit of a camera that
    climbs (above: from azimuth 0) to the zenith.

    Parameters
    ----------
    eye, target : (3,) float
        World frame [m], at different places; InputError otherwise.
    roll : float
        Turn of the camera about its optical axis, clockwise as the camera sees it [rad].

    Returns
    -------
    (4, 4) float64
        ``world_T_camera``, OpenCV axes: x right, y down, z forward.
    """
    place, aim = point("look_at: eye", eye), point("look_at: target", target)
    offset = aim - place
    distance = np.linalg.norm(offset)
    if not distance > 0.0:
        raise InputError("look_at: target", "a point away from the eye", aim.tolist())
    forward = offset / distance
    above = math.hypot(forward[0], forward[1]) < _AT_ZENITH
    right = np.cross(forward, (-1.0, 0.0, 0.0) if above else (0.0, 0.0, 1.0))
    return aimed_frame(place, forward, right, number("look_at: roll", roll, -math.inf, math.inf, "rad"))


def check_rigid(where: str, matrix: np.ndarray) -> None:
    """Refuse a (4, 4) matrix that is not a rotation and a shift; InputError says how it fails."""
    expected = "a rigid pose"
    if np.abs(matrix[3] - [0.0, 0.0, 0.0, 1.0]).max() > 0.0:
        raise InputError(where, f"{expected}, last row 0 0 0 1", matrix[3].tolist())
    rotation = matrix[:3, :3]
    error = float(np.abs(rotation.T @ rotation - np.eye(3)).max())
    # Written so that NaN is refused as well.
    if not error <= RIGID_TOLERANCE:
        raise InputError(where, f"{expected}, axes at right angles and of length 1", f"them off by {error:.3g}")
    if np.linalg.det(rotation) < 0.0:
        raise InputError(where, f"{expected}, right-handed", "a mirrored one")
