"""Stereo cameras in ranges of elevation, azimuth and distance, and what every drawn camera has: an aim and a height."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...core.errors import InputError
from ...core.pose import look_at
from ...core.units import degrees
from ..description.camera import Camera
from .camera_settings import CameraSettings
from .intrinsics import fit_distance

#: Draws for each view before its ranges are said to have no place for it. Where one camera in five can be used, one
#: view in a thousand fails.
TRIES = 32
#: Steps of the search for a distance that works [fraction], and its end [m], the largest distance of the settings.
_STEP, _FARTHEST = 1.05, 20.0


@dataclass(frozen=True)
class Blocked:
    """Why a camera cannot stand where it does: one of its eyes is inside a body."""

    found: str  #: the place and the body
    top: float  #: height of the body's highest point [m]


def _nowhere(_camera: Camera) -> Blocked | None:
    return None


def _always(_camera: Camera) -> bool:
    return True


@dataclass(frozen=True, eq=False)
class Workspace:
    """What the cameras of a scene look at: a ball around all objects, and the objects themselves."""

    centre: np.ndarray  #: of the ball, (3,) float64, world frame [m]
    radius: float  #: of the ball [m]
    #: Camera -> what one of its eyes is in, or None.
    blocked: Callable[[Camera], Blocked | None] = _nowhere
    #: Camera -> whether the middle of a vessel (without vessels: of a prop or the table) is in both its pictures.
    shown: Callable[[Camera], bool] = _always


def draw_in_ranges(
    rng: np.random.Generator, settings: CameraSettings, workspace: Workspace, exposure: float
) -> tuple[Camera, ...]:
    """Draw cameras in the ranges of the settings, each with a direction and a distance of its own.

    Angles and distances are uniform in their ranges. A draw that stands in a body, lower than ``min_height``, or has no
    vessel in its pictures, is replaced by the view's next one. One more view changes no other.

    Raises
    ------
    InputError
        Naming the setting and the nearest value that works, where none of `TRIES` draws of a view can be used.
    """
    draws = rng.random((settings.views, TRIES, 9))
    return tuple(_first_usable(settings, view, rows, workspace, exposure) for view, rows in enumerate(draws))


def shortest_distance(settings: CameraSettings, radius: float) -> float:
    """Return the distance from which a ball of that radius [m] is in both pictures, also with jitter [m]."""
    # A sphere around a jittered target that contains the workspace: larger by the diagonal of the jitter.
    radius = radius + math.sqrt(3.0) * settings.target_jitter
    fit = fit_distance(settings.intrinsics(), settings.baseline, radius, settings.look_jitter)
    return max(fit, settings.min_distance)


def farthest_distance(settings: CameraSettings, radius: float) -> float:
    """Return the largest distance to the point looked at that is drawn [m]."""
    if settings.distance is not None:
        return settings.distance[1]
    return settings.slack[1] * shortest_distance(settings, radius)


def lowest_elevation(settings: CameraSettings, target_height: float, distance: float) -> float | None:
    """Return the lowest elevation that keeps the eye `min_height` over the table [rad]; None where none does."""
    sine = (settings.min_height - target_height) / distance
    return None if sine > 1.0 else math.asin(max(sine, -1.0))


def directions(elevation: np.ndarray | float, azimuth: np.ndarray | float) -> np.ndarray:
    """Return unit vectors (..., 3) from the target to the eye for angles in radians."""
    flat = np.cos(elevation)
    return np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=-1)


def aimed_camera(
    settings: CameraSettings,
    eye: np.ndarray,
    target: np.ndarray,
    roll: float,
    look: np.ndarray,
    exposure: float,
    grid_index: int | None = None,
) -> Camera:
    """Return the camera at a place that looks at a point, turned away from it by `look_jitter`.

    Parameters
    ----------
    settings : CameraSettings
        Intrinsics, baseline and the largest turn.
    eye, target : (3,) float
        World frame [m].
    roll : float
        Turn about the optical axis [rad].
    look : (2,) float
        Two numbers in [0, 1): how far, uniform over the disc, and where the looking direction turns.
    exposure, grid_index : float, int
        Of the camera.
    """
    pose = look_at(eye, target, roll)
    if settings.look_jitter > 0.0:
        pose[:3, :3] = pose[:3, :3] @ _tilt(settings.look_jitter * math.sqrt(look[0]), 2.0 * math.pi * look[1])
    return settings.intrinsics().camera(pose, settings.baseline, exposure, grid_index)


def _tilt(angle: float, azimuth: float) -> np.ndarray:
    """Return the rotation (3, 3) of a camera by an angle about an axis across its optical axis (Rodrigues)."""
    x, y = math.cos(azimuth), math.sin(azimuth)
    cross = np.array([[0.0, 0.0, y], [0.0, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)


def _first_usable(
    settings: CameraSettings, view: int, rows: np.ndarray, workspace: Workspace, exposure: float
) -> Camera:
    for row in rows:
        distance = _distance(settings, row[0], workspace.radius)
        camera = _camera(settings, row, distance, workspace, exposure)
        if camera is not None and workspace.blocked(camera) is None and workspace.shown(camera):
            return camera
    raise _no_place(settings, view, rows, workspace, exposure)


def _distance(settings: CameraSettings, u: float, radius: float) -> float:
    if settings.distance is not None:
        return _between(settings.distance, u)
    return _between(settings.slack, u) * shortest_distance(settings, radius)


def _camera(
    settings: CameraSettings, row: np.ndarray, distance: float, workspace: Workspace, exposure: float
) -> Camera | None:
    """Return the camera of a row of random numbers in [0, 1); None where it cannot stand high enough."""
    low, high = _elevations(settings)
    target = workspace.centre + (2.0 * row[1:4] - 1.0) * settings.target_jitter
    lowest = lowest_elevation(settings, target[2], distance)
    if lowest is None or lowest > high:
        return None
    elevation = _between((max(low, lowest), high), row[4])
    azimuth = _between((0.0, 2.0 * math.pi) if settings.azimuth is None else settings.azimuth, row[5])
    eye = target + distance * directions(elevation, azimuth)
    return aimed_camera(settings, eye, target, (2.0 * row[6] - 1.0) * settings.roll, row[7:9], exposure)


def _elevations(settings: CameraSettings) -> tuple[float, float]:
    return (settings.lowest_elevation, math.pi / 2) if settings.elevation is None else settings.elevation


def _between(limits: tuple[float, float], u: float) -> float:
    return float(limits[0] + u * (limits[1] - limits[0]))


def _no_place(
    settings: CameraSettings, view: int, rows: np.ndarray, workspace: Workspace, exposure: float
) -> InputError:
    """Return the error of a view without a usable draw: what stands in the way, and the nearest value that works."""
    distance = farthest_distance(settings, workspace.radius)
    highest, height = _elevations(settings)[1], float(workspace.centre[2])
    lowest = lowest_elevation(settings, height - settings.target_jitter, distance)
    if lowest is None:
        most = height + distance
        return InputError("cameras.min_height", f"at most {most:.3f} m at this distance", f"{settings.min_height:g} m")
    if lowest > highest:
        room = f"{settings.min_height:g} m over the table"
        expected = f"up to {degrees(lowest + 0.002)} or more, so that cameras stay {room}"
        return InputError("cameras.elevation", expected, f"up to {degrees(highest)}")
    if settings.distance is None:
        return InputError("cameras.look_jitter", "0, as no direction shows an object", degrees(settings.look_jitter))
    nearest = _working_distance(settings, rows, workspace, exposure)
    low, high = settings.distance
    expected = "another range" if nearest is None else f"a range from {nearest:.2f} m"
    found = f"{low:g} to {high:g} m, where view {view} has no vessel in both pictures or is inside a body"
    return InputError("cameras.distance", expected, found)


def _working_distance(
    settings: CameraSettings, rows: np.ndarray, workspace: Workspace, exposure: float
) -> float | None:
    """Return the smallest distance above the range, in whole centimetres, at which a draw of a view is usable [m]."""
    distance = farthest_distance(settings, workspace.radius)
    while distance * _STEP < _FARTHEST:
        distance = math.ceil(100.0 * distance * _STEP) / 100.0
        for row in rows:
            camera = _camera(settings, row, distance, workspace, exposure)
            if camera is not None and workspace.blocked(camera) is None and workspace.shown(camera):
                return distance
    return None
