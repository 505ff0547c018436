"""Cameras of a user's own images that are suspicious: another unit, other axes, a K of another size, no baseline.

Each would give depths and boxes that look like a network's failure. The checks need no image, only the poses and K.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ..data.views import CameraView

#: Middle part of a picture in which its principal point lies [fraction of the side]. Lenses are off by some percent;
#: the K of a picture of half or twice the size has it at 1/4 or at the edge.
_MIDDLE = (0.3, 0.7)
#: Distances between cameras that look at one table [m]: nearer ones see no parallax, farther ones are in another unit.
_LEAST_BASELINE, _MOST_BASELINE = 1e-3, 5.0
#: A baseline of stereo cameras and of neighbouring views [m]: 0.03 to 0.3.
_USUAL_BASELINE = 0.1
#: Turn, and distance beside the x axis over the baseline, up to which a pair counts as rectified: half a pixel at a
#: focal length of 500 px.
_RECTIFIED = 1e-3
#: Cosine beyond which an axis counts as upward [1]: 6 degrees above the horizon.
_UPWARD = 0.1
#: Angle between optical axes from which the place where they meet is well known [rad]: 6 degrees.
_LEAST_ANGLE = 0.1


def check_cameras(views: Sequence[CameraView], paths: Sequence[Path]) -> None:
    """Refuse views of one scene whose cameras are suspicious.

    Parameters
    ----------
    views : sequence of CameraView
        The images as they were read, at their full size, with their cameras; the first is the reference.
    paths : sequence of Path
        Their files, for the message.

    Raises
    ------
    InputError
        Saying what is suspicious, and what it probably is.
    """
    for view, path in zip(views, paths, strict=True):
        _check_centre(view, path)
    _check_baselines(views, paths)
    _check_axes(views, paths)


def check_rectified(views: Sequence[CameraView], paths: Sequence[Path]) -> None:
    """Refuse views that are not the left and the right eye of a rectified stereo pair, which SimNet takes.

    Raises
    ------
    InputError
        Where there are not two, or the second is turned, lies elsewhere than to the right, or has another K.
    """
    if len(views) != 2:
        raise InputError("pictures", "the two eyes of a stereo pair", len(views))
    left, right = (view.world_T_camera for view in views)
    relative = np.linalg.inv(left) @ right
    baseline = float(relative[0, 3])
    expected = "the right eye of a rectified pair: the same axes, to the right along x"
    turned = float(np.abs(relative[:3, :3] - np.eye(3)).max())
    if turned > _RECTIFIED or np.abs(relative[1:3, 3]).max() > _RECTIFIED * abs(baseline) + 1e-6 or baseline <= 0.0:
        found = f"a turn of {turned:.2g} and the place {np.round(relative[:3, 3], 5).tolist()} m"
        raise InputError(f"{paths[1]}: world_T_camera", expected, found)
    if np.abs(views[0].K - views[1].K).max() > _RECTIFIED * views[0].K[0, 0]:
        raise InputError(f"{paths[1]}: K", "that of the left eye", "another")


def _check_centre(view: CameraView, path: Path) -> None:
    height, width = view.picture.shape[:2]
    x, y = float(view.K[0, 2]), float(view.K[1, 2])
    if all(_MIDDLE[0] <= (at + 0.5) / side <= _MIDDLE[1] for at, side in ((x, width), (y, height))):
        return
    meant = f"{round(2 * x + 1)} x {round(2 * y + 1)}"
    expected = f"a principal point near the middle of a picture of {width} x {height} px"
    raise InputError(f"{path}: K", expected, f"({x:g}, {y:g}), as of a picture of {meant} px")


def _check_baselines(views: Sequence[CameraView], paths: Sequence[Path]) -> None:
    places = np.stack([view.world_T_camera[:3, 3] for view in views])
    away = np.linalg.norm(places[1:] - places[0], axis=1)
    where = f"{paths[0]}: world_T_camera"
    if away.max() < _LEAST_BASELINE:
        found = f"a baseline of {1e3 * away.max():.3g} mm, so no parallax (are both images from one view?)"
        raise InputError(where, f"another camera at least {1e3 * _LEAST_BASELINE:g} mm away", found)
    if away.max() > _MOST_BASELINE:
        units = {"centimetres": 1e-2, "millimetres": 1e-3}
        unit = min(units, key=lambda name: abs(np.log(away.max() * units[name] / _USUAL_BASELINE)))
        found = f"a baseline of {away.max():.4g} m (in {unit} it would be {away.max() * units[unit]:.3g} m)"
        raise InputError(where, f"poses in metres, cameras at most {_MOST_BASELINE:g} m apart", found)


def _check_axes(views: Sequence[CameraView], paths: Sequence[Path]) -> None:
    """Refuse cameras that look away from what they share, or upside down at the sky above a table."""
    poses = np.stack([view.world_T_camera for view in views])
    meeting = [depths for pose in poses[1:] if (depths := _meeting_depths(poses[0], pose)) is not None]
    behind = bool(meeting) and all(first < 0.0 and second < 0.0 for first, second in meeting)
    down, ahead, height = poses[:, 2, 1], poses[:, 2, 2], poses[:, 2, 3]
    sky = bool(((down > _UPWARD) & (ahead > _UPWARD) & (height > 0.0)).all())
    if behind or sky:
        found = "cameras whose axes meet behind them" if behind else "cameras that look up from above, upside down"
        expected = "OpenCV's axes (x right, y down, z ahead)"
        hint = "as with OpenGL's or Blender's axes: negate the second and the third column"
        raise InputError(f"{paths[0]}: world_T_camera", expected, f"{found}, {hint}")


def _meeting_depths(first: np.ndarray, second: np.ndarray) -> tuple[float, float] | None:
    """Return the depths at which two optical axes are nearest to each other [m]; None where they are parallel."""
    a, b, between = first[:3, 2], second[:3, 2], second[:3, 3] - first[:3, 3]
    cos = float(a @ b)
    sine = 1.0 - cos * cos
    if sine < np.sin(_LEAST_ANGLE) ** 2:
        return None
    along_a, along_b = float(a @ between), float(b @ between)
    return (along_a - cos * along_b) / sine, (cos * along_a - along_b) / sine
