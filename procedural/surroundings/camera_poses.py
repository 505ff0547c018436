"""The paper's grid of stereo cameras on the upper half sphere.

Syn-TODD has 57 views: the zenith and 4 rings of 14 azimuths (Wang et al., "MVTrans", 2023). The elevations of the
rings are not published; the lowest is called parallel to the table. Here the rings follow in equal steps from the
zenith down to `CameraSettings.lowest_elevation`, by default at 70, 50, 30 and 10 degrees: 10 degrees still looks over
the table's edge, and the camera stays above it. Rings are aligned in azimuth, and view 1 + 14 k lies at azimuth 0.
"""

from __future__ import annotations

import math

import numpy as np

from ...core.errors import InputError
from ...core.pose import look_at
from ..description.camera import Camera
from .settings import CameraSettings

RINGS, RING_VIEWS = 4, 14
GRID_VIEWS = 1 + RINGS * RING_VIEWS
#: Picture width that `CameraSettings.focal` is given for [px].
FOCAL_WIDTH = 640


def draw_cameras(
    rng: np.random.Generator,
    settings: CameraSettings,
    workspace_centre: np.ndarray,
    workspace_radius: float,
    exposure: float,
) -> tuple[Camera, ...]:
    """Draw the stereo views of a scene.

    All views of a scene have one distance, drawn so that the workspace sphere lies inside every picture, left and
    right. With 57 views they come in the grid's order; fewer come in the order of `spread_order`, so that the first
    five of ten are the five of five.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws; their number does not depend on the number of views.
    settings : CameraSettings
        Ranges of the draws.
    workspace_centre : (3,) float
        Centre of the objects' bounding sphere, world frame [m].
    workspace_radius : float
        Its radius [m].
    exposure : float
        Factor from radiance to the linear value that sRGB encodes.

    Returns
    -------
    tuple of Camera
        ``settings.views`` of them.

    Raises
    ------
    InputError
        If ``min_height`` is out of reach at the drawn distance.
    """
    distance = rng.uniform(*settings.slack) * _fit_distance(settings, workspace_radius)
    order = spread_order(settings, int(rng.integers(GRID_VIEWS)))
    jitter = rng.uniform(-1.0, 1.0, size=(GRID_VIEWS, 6))
    chosen = range(GRID_VIEWS) if settings.views == GRID_VIEWS else order[: settings.views]
    return tuple(
        _camera(settings, index, jitter[index], np.asarray(workspace_centre, float), distance, exposure)
        for index in map(int, chosen)
    )


def reach(settings: CameraSettings, workspace_centre: np.ndarray, workspace_radius: float) -> float:
    """Return an upper bound of the distance of all cameras, left and right, from the world's origin [m].

    It holds for every draw with these settings, so lights can be placed before the cameras are.
    """
    distance = settings.slack[1] * _fit_distance(settings, workspace_radius)
    target = float(np.linalg.norm(workspace_centre)) + math.sqrt(3.0) * settings.target_jitter
    return target + math.hypot(distance, settings.baseline)


def grid_directions(lowest_elevation: float) -> np.ndarray:
    """Return the directions from the target to the 57 eyes, (57, 3) float64, zenith first, then ring by ring."""
    elevation, azimuth = _grid_angles(lowest_elevation)
    return _directions(elevation, azimuth)


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


def fit_distance(width: int, height: int, focal: float, baseline: float, radius: float) -> float:
    """Return the shortest distance at which a sphere lies inside both pictures of a stereo pair.

    The left camera looks at the sphere's centre. The sphere is inside where its centre is at least ``radius`` away
    from each side plane of the view. For the left camera this is d sin(a) >= r with the half angles a of view; the
    right camera sees the centre ``baseline`` to the left of its axis: d sin(a) - b cos(a) >= r.

    Parameters
    ----------
    width, height : int
        Size of the picture [px]; the principal point is its middle.
    focal : float
        Focal length [px].
    baseline : float
        Distance between the cameras [m].
    radius : float
        Radius of the sphere [m].

    Returns
    -------
    float
        Distance from the left eye to the sphere's centre [m].
    """
    across, up = math.atan(0.5 * width / focal), math.atan(0.5 * height / focal)
    return max((radius + baseline * math.cos(across)) / math.sin(across), radius / math.sin(up))


def _camera(
    settings: CameraSettings,
    index: int,
    jitter: np.ndarray,
    centre: np.ndarray,
    distance: float,
    exposure: float,
) -> Camera:
    elevations, azimuths = _grid_angles(settings.lowest_elevation)
    target = centre + jitter[:3] * settings.target_jitter
    elevation = elevations[index] + jitter[3] * settings.angle_jitter
    elevation = max(elevation, _lowest(settings, target[2], distance))
    azimuth = azimuths[index] + jitter[4] * settings.angle_jitter
    eye = target + distance * _directions(elevation, azimuth)
    return Camera(
        width=settings.width,
        height=settings.height,
        focal=_focal(settings),
        centre=((settings.width - 1) / 2, (settings.height - 1) / 2),
        world_T_camera=look_at(eye, target, jitter[5] * settings.roll),
        baseline=settings.baseline,
        exposure=exposure,
        grid_index=index,
    )


def _lowest(settings: CameraSettings, target_height: float, distance: float) -> float:
    """Return the lowest elevation that keeps the eye `min_height` over the table [rad]."""
    sine = (settings.min_height - target_height) / distance
    if sine > 1.0:
        highest = target_height + distance
        raise InputError("cameras.min_height", f"at most {highest:.3f} m at this distance", settings.min_height)
    return math.asin(max(sine, -1.0))


def _fit_distance(settings: CameraSettings, radius: float) -> float:
    # A sphere around a jittered target that contains the workspace: larger by the diagonal of the jitter.
    radius = radius + math.sqrt(3.0) * settings.target_jitter
    fit = fit_distance(settings.width, settings.height, _focal(settings), settings.baseline, radius)
    return max(fit, settings.min_distance)


def _focal(settings: CameraSettings) -> float:
    return settings.focal * settings.width / FOCAL_WIDTH


def _grid_angles(lowest_elevation: float) -> tuple[np.ndarray, np.ndarray]:
    rings = np.linspace(math.pi / 2, lowest_elevation, RINGS + 1)[1:]
    turns = 2.0 * math.pi * np.arange(RING_VIEWS) / RING_VIEWS
    elevation = np.concatenate([[math.pi / 2], np.repeat(rings, RING_VIEWS)])
    return elevation, np.concatenate([[0.0], np.tile(turns, RINGS)])


def _directions(elevation: np.ndarray | float, azimuth: np.ndarray | float) -> np.ndarray:
    flat = np.cos(elevation)
    return np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=-1)
