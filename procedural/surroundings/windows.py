"""Windows and lamps of a room: what shines through a rectangle on a wall, and the view outside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..description.surroundings import RoomEnvironment, Window
from ..materials.noise import fractal_value_noise
from .colour import luminance
from .outside_view import bake_outside
from .room_geometry import in_rectangle

#: Width of a mullion and of a window's frame [m], and reflectance of their paint.
BAR_WIDTH, BAR_REFLECTANCE = 0.05, 0.6
#: Fraction of a lamp's shorter side over which its diffuser fades at the rim.
LAMP_RIM = 0.08
# Luminance of the land outside over the sky's: about the reflectance of vegetation and paving, 0.1 to 0.3.
_LAND = 0.22
# Rows of the view outside: 0.7 degrees each; leaves are 0.6 degrees wide, and the skyline is softened over 1 degree.
_OUTSIDE_ROWS = 256
# Highest houses and trees outside: 0.2 rad or 11 degrees; lattice cells per radian along the skyline.
_SKYLINE_HEIGHT, _SKYLINE_CELLS = 0.2, 4.0
# Softness of the skyline [rad], 1 degree: the glass and the air blur what is far.
_SKYLINE_SOFTNESS = 0.0175
# Luminance of the sky falls by this fraction from the horizon to the elevation below [rad].
_ZENITH_DIMMING, _ZENITH_ELEVATION = 0.35, 1.2
# Lattice cells per radian of the leaves on the land.
_LEAF_CELLS = 25.0


@dataclass(frozen=True, eq=False)
class Outside:
    """The view through every window, by direction: radiance over the window's own."""

    level: np.ndarray  #: (h, 2 * h) float32, laid out as `sphere` says

    def along(self, directions: np.ndarray) -> np.ndarray:
        """Return the level along unit vectors in the room's frame, (n, 3) -> (n,) float32, by bilinear lookup."""
        rows, columns = self.level.shape
        v = np.arccos(np.clip(directions[:, 2], -1.0, 1.0)) * (rows / np.pi) - 0.5
        u = np.arctan2(directions[:, 1], directions[:, 0]) * (columns / (2.0 * np.pi)) - 0.5
        v = np.clip(v, 0.0, rows - 1.0)
        row, column = np.minimum(v.astype(np.int64), rows - 2), np.floor(u).astype(np.int64)
        fv, fu = (v - row).astype(np.float32), (u - column).astype(np.float32)
        left, right = column % columns, (column + 1) % columns
        low = self.level[row, left] * (1.0 - fu) + self.level[row, right] * fu
        high = self.level[row + 1, left] * (1.0 - fu) + self.level[row + 1, right] * fu
        return low * (1.0 - fv) + high * fv


def outside_of(room: RoomEnvironment) -> Outside:
    """Return the view outside: a sky that brightens to the horizon, a skyline, and land below.

    Of a room in its place it is the luminance of `outside_view`.
    """
    if not room.at_infinity:
        first = next((window.radiance for window in room.windows if window.kind == "window"), (1.0, 1.0, 1.0))
        return Outside((luminance(bake_outside(room)) / luminance(np.array(first))).astype(np.float32))
    rows, columns = _OUTSIDE_ROWS, 2 * _OUTSIDE_ROWS
    elevation = (0.5 * np.pi - np.pi * (np.arange(rows) + 0.5) / rows)[:, None]
    azimuth = 2.0 * np.pi * (np.arange(columns) + 0.5) / columns
    compass = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(columns)], axis=-1)
    skyline = _SKYLINE_HEIGHT * fractal_value_noise(compass * _SKYLINE_CELLS, room.seed + 101, 4) ** 2
    level = np.broadcast_to(1.0 - _ZENITH_DIMMING * np.clip(elevation / _ZENITH_ELEVATION, 0.0, 1.0), (rows, columns))
    sky = np.clip((elevation - skyline) / _SKYLINE_SOFTNESS + 0.5, 0.0, 1.0)
    # The land is worked out where it is seen alone.
    low = elevation[:, 0] < _SKYLINE_HEIGHT + _SKYLINE_SOFTNESS
    flat, up = np.cos(elevation[low])[..., None], np.sin(elevation[low])[..., None]
    directions = np.concatenate([flat * compass[None, :, :2], np.broadcast_to(up, (low.sum(), columns, 1))], axis=-1)
    land = np.zeros((rows, columns))
    land[low] = _LAND * (0.5 + fractal_value_noise(directions * _LEAF_CELLS, room.seed + 202, 3))
    return Outside((sky * level + (1.0 - sky) * land).astype(np.float32))


def window_radiance(
    window: Window, coordinates: np.ndarray, outward: np.ndarray, outside: Outside
) -> tuple[np.ndarray, np.ndarray]:
    """Return the radiance that comes through points of a window or lamp.

    Parameters
    ----------
    window : Window
        The rectangle.
    coordinates : (n, 2) float
        Points in the wall's own coordinates [m].
    outward : (n, 3) float
        Unit vectors from the room through the points.
    outside : Outside
        The view.

    Returns
    -------
    radiance : (n, 3) float32
        0 outside the rectangle and on its bars.
    kind : (n,) int8
        0 outside the rectangle, 1 shining, 2 a bar or a frame.
    """
    kind = in_rectangle(coordinates, window.centre, window.size).astype(np.int8)
    inside = np.flatnonzero(kind)
    if window.kind == "window":
        kind[inside[_on_bar(window, coordinates[inside])]] = 2
    shining = np.flatnonzero(kind == 1)
    level = np.zeros(len(kind), dtype=np.float32)
    level[shining] = shining_level(window, coordinates[shining], outward[shining], outside)
    return level[:, None] * np.array(window.radiance, dtype=np.float32), kind


def shining_level(window: Window, coordinates: np.ndarray, outward: np.ndarray, outside: Outside) -> np.ndarray:
    """Return the radiance over ``window.radiance`` at points of a window or lamp, without its bars.

    Parameters
    ----------
    window : Window
        The rectangle.
    coordinates : (n, 2) or (1, 2) float
        Points in the rectangle, in the wall's own coordinates [m].
    outward : (n, 3) float
        Unit vectors from the room through the points.
    outside : Outside
        The view.

    Returns
    -------
    (n,) or (1,) float32
        For a lamp 1, and less near its rim; for a window the view's level.
    """
    if window.kind == "window":
        return outside.along(outward)
    edge = _edge_distance(window, coordinates)
    return np.clip(edge / np.float32(LAMP_RIM * min(window.size)), 0.0, 1.0)


def coverage(
    centre: tuple[float, float], size: tuple[float, float], corner: np.ndarray, extent: np.ndarray, shape: np.ndarray
) -> np.ndarray:
    """Return the fraction of each cell of a face that a rectangle covers.

    Parameters
    ----------
    centre, size : (float, float)
        The rectangle in the face's own coordinates [m].
    corner, extent : (2,) float
        The face in its own coordinates [m].
    shape : (2,) int
        Cells along both.

    Returns
    -------
    (shape[0], shape[1]) float32
        0 to 1.
    """
    along = []
    for axis in range(2):
        edges = corner[axis] + extent[axis] * np.arange(shape[axis] + 1) / shape[axis]
        low, high = centre[axis] - 0.5 * size[axis], centre[axis] + 0.5 * size[axis]
        overlap = np.minimum(edges[1:], high) - np.maximum(edges[:-1], low)
        along.append(np.maximum(overlap, 0.0) / (edges[1:] - edges[:-1]))
    return np.outer(*along).astype(np.float32)


def _edge_distance(window: Window, coordinates: np.ndarray) -> np.ndarray:
    """Return the distance of points in a rectangle to its nearest edge, (n, 2) -> (n,) float32 [m]."""
    offset = np.abs(coordinates - np.array(window.centre, np.float32))
    return (np.float32(0.5) * np.array(window.size, np.float32) - offset).min(axis=1)


def _on_bar(window: Window, coordinates: np.ndarray) -> np.ndarray:
    """Return whether points in a window lie on the frame or on one of the mullions, (n, 2) -> (n,) bool."""
    size = np.array(window.size, np.float32)
    distance = coordinates - np.array(window.centre, np.float32) + np.float32(0.5) * size
    on = _edge_distance(window, coordinates) < BAR_WIDTH
    for bar in range(1, window.bars + 1):
        on |= (np.abs(distance - size * np.float32(bar / (window.bars + 1))) < 0.5 * BAR_WIDTH).any(axis=1)
    return on
