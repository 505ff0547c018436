"""The stereo cameras of a scene: on the paper's grid, in ranges (`camera_ranges`), or at poses from a file.

Syn-TODD has 57 views: the zenith and 4 rings of 14 azimuths (Wang et al., "MVTrans", 2023). The elevations of the
rings are not published; the lowest is called parallel to the table. Here the rings follow in equal steps from the
zenith down to `CameraSettings.lowest_elevation`, by default at 70, 50, 30 and 10 degrees: 10 degrees still looks over
the table's edge, and the camera stays above it. Rings are aligned in azimuth, and view 1 + 14 k lies at azimuth 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...core.errors import InputError
from ..description.camera import Camera
from .camera_ranges import (
    Workspace,
    aimed_camera,
    directions,
    draw_in_ranges,
    farthest_distance,
    lowest_elevation,
    shortest_distance,
)
from .camera_settings import GRID_VIEWS, CameraSettings
from .pose_files import FilePose, read_poses

RINGS, RING_VIEWS = 4, 14
assert GRID_VIEWS == 1 + RINGS * RING_VIEWS


def draw_cameras(
    rng: np.random.Generator,
    settings: CameraSettings,
    workspace: Workspace,
    exposure: float,
    poses: Sequence[FilePose] = (),
) -> tuple[Camera, ...]:
    """Draw the stereo views of a scene.

    On the grid all views of a scene have one distance, drawn so that the workspace sphere lies inside every picture,
    left and right. With 57 views they come in the grid's order; fewer come in the order of `spread_order`, so that the
    first five of ten are the five of five.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws; their number does not depend on the number of views.
    settings : CameraSettings
        Ranges of the draws.
    workspace : Workspace
        What the cameras look at.
    exposure : float
        Factor from radiance to the linear value that sRGB encodes.
    poses : sequence of FilePose
        Those of ``settings.poses``; each scene takes ``settings.views`` of them at random, all in their order.

    Returns
    -------
    tuple of Camera
        ``settings.views`` of them.

    Raises
    ------
    InputError
        If ``min_height`` is out of reach at the drawn distance, no camera in the ranges has an object in its pictures,
        or a pose of the file is inside a body.
    """
    if settings.poses is not None:
        return _at_poses(rng, settings, workspace, exposure, poses)
    if settings.in_ranges:
        return draw_in_ranges(rng, settings, workspace, exposure)
    distance = rng.uniform(*settings.slack) * shortest_distance(settings, workspace.radius)
    order = spread_order(settings, int(rng.integers(GRID_VIEWS)))
    jitter = rng.uniform(-1.0, 1.0, size=(GRID_VIEWS, 6))
    look = rng.random((GRID_VIEWS, 2))
    chosen = range(GRID_VIEWS) if settings.views == GRID_VIEWS else order[: settings.views]
    return tuple(
        _on_grid(settings, index, jitter[index], look[index], workspace.centre, distance, exposure)
        for index in map(int, chosen)
    )


def reach(settings: CameraSettings, workspace: Workspace, poses: Sequence[FilePose] = ()) -> float:
    """Return an upper bound of the distance of all cameras, left and right, from the world's origin [m].

    It holds for every draw with these settings, so lights can be placed before the cameras are.
    """
    if settings.poses is not None:
        return max(float(np.linalg.norm(pose.world_T_camera[:3, 3])) for pose in poses) + settings.baseline
    distance = farthest_distance(settings, workspace.radius)
    target = float(np.linalg.norm(workspace.centre)) + math.sqrt(3.0) * settings.target_jitter
    return target + math.hypot(distance, settings.baseline)


def poses_of(settings: CameraSettings) -> tuple[FilePose, ...]:
    """Return the poses of the settings' file, at least as many as views; none without a file.

    Raises
    ------
    InputError
        Where the file cannot be used (`pose_files.read_poses`), or has fewer poses than there are to be views.
    """
    if settings.poses is None:
        return ()
    poses = read_poses(settings.poses, settings.world_T_poses)
    if settings.views > len(poses):
        raise InputError("cameras.views", f"at most {len(poses)}, the poses in {settings.poses}", settings.views)
    return poses


def _at_poses(
    rng: np.random.Generator,
    settings: CameraSettings,
    workspace: Workspace,
    exposure: float,
    poses: Sequence[FilePose],
) -> tuple[Camera, ...]:
    order = rng.permutation(len(poses))[: settings.views] if settings.views < len(poses) else range(len(poses))
    lens, cameras = settings.intrinsics(), []
    for pose in (poses[index] for index in map(int, order)):
        camera = lens.camera(pose.world_T_camera, settings.baseline, exposure)
        blocked = workspace.blocked(camera)
        if blocked is not None:
            raise InputError(pose.where, f"a place in the air, such as z above {blocked.top:.3f} m", blocked.found)
        cameras.append(camera)
    if not any(workspace.shown(camera) for camera in cameras):
        where = f"{settings.poses} (cameras.poses)"
        expected = "poses with an object in the picture (world_T_camera, OpenCV axes, metres from the table's middle)"
        raise InputError(where, expected, f"none of {len(cameras)}")
    return tuple(cameras)


def grid_directions(lowest_elevation: float) -> np.ndarray:
    """Return the directions from the target to the 57 eyes, (57, 3) float64, zenith first, then ring by ring."""
    elevation, azimuth = _grid_angles(lowest_elevation)
    return directions(elevation, azimuth)


def spread_order(settings: CameraSettings, start: int) -> np.ndarray:
    """Return the grid's 57 indices in greedy farthest-point order from one of them, (57,) int.

    Each next view is the one whose nearest chosen view is farthest away on the sphere; the lower index wins ties.
    """
    directions = grid_directions(settings.lowest_elevation)
    # Rounded, so that views at equal angles tie on every machine.
    closeness = np.round(directions @ directions.T, 9)
    order, nearest = [start], closeness[start].copy()
    while len(order) < GRID_VIEWS:
        nearest[order] = np.inf
        order.append(int(np.argmin(nearest)))
        nearest = np.maximum(nearest, closeness[order[-1]])
    return np.array(order)


def _on_grid(
    settings: CameraSettings,
    index: int,
    jitter: np.ndarray,
    look: np.ndarray,
    centre: np.ndarray,
    distance: float,
    exposure: float,
) -> Camera:
    elevations, azimuths = _grid_angles(settings.lowest_elevation)
    target = centre + jitter[:3] * settings.target_jitter
    elevation = elevations[index] + jitter[3] * settings.angle_jitter
    lowest = lowest_elevation(settings, target[2], distance)
    if lowest is None:
        highest = target[2] + distance
        raise InputError("cameras.min_height", f"at most {highest:.3f} m at this distance", settings.min_height)
    azimuth = azimuths[index] + jitter[4] * settings.angle_jitter
    eye = target + distance * directions(max(elevation, lowest), azimuth)
    return aimed_camera(settings, eye, target, jitter[5] * settings.roll, look, exposure, index)


def _grid_angles(lowest_elevation: float) -> tuple[np.ndarray, np.ndarray]:
    rings = np.linspace(math.pi / 2, lowest_elevation, RINGS + 1)[1:]
    turns = 2.0 * math.pi * np.arange(RING_VIEWS) / RING_VIEWS
    elevation = np.concatenate([[math.pi / 2], np.repeat(rings, RING_VIEWS)])
    return elevation, np.concatenate([[0.0], np.tile(turns, RINGS)])
