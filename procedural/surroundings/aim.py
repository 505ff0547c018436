"""Frames that look somewhere: cameras and lamps."""

from __future__ import annotations

import math

import numpy as np


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
