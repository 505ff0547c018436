"""The surfaces of a room with the light that they send out: what a ray from the table meets.

The radiosity solution (`room_light`) is computed once per room and stored as one texture of radiance per face. A ray
then needs no bounce: it meets a wall or a piece of furniture and reads that face's texture, or leaves by a window.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ..description.surroundings import Panel, RoomEnvironment, Window
from ..materials.noise import fractal_value_noise, lattice
from .room_geometry import WALL_FACES, Boxes, boxes_of, cast, face_coordinates, face_frames, face_points, in_rectangle
from .room_light import room_irradiance
from .room_pictures import picture_of, picture_over
from .windows import BAR_REFLECTANCE, Outside, coverage, outside_of, window_radiance

# Side of a texel [m] on faces with boards, doors or pictures, and on plain ones; most texels along a side. A texel of
# a map of 512 rows covers 1 cm at 1.6 m.
_FINE_TEXEL, _PLAIN_TEXEL, _MOST_TEXELS = 0.01, 0.03, 2048
# Plaster and paint vary by some percent over decimetres: smallest value and range of the factor, lattice cells per
# metre, octaves.
_PAINT_LEAST, _PAINT_RANGE, _PAINT_CELLS, _PAINT_OCTAVES = 0.94, 0.12, 3.0, 3
# Spacing of the points at which this factor is computed [m]: half of the finest octave.
_PAINT_STEP = 0.04
# Floor boards: smallest value and range of the shade of a board and of the grain in it; width of a joint [m] and its
# shade.
_BOARD_LEAST, _BOARD_RANGE, _GRAIN_LEAST, _GRAIN_RANGE, _JOINT, _JOINT_SHADE = 0.75, 0.5, 0.85, 0.3, 0.003, 0.3
# Lattice cells per metre of the grain, along and across a board, and its octaves; noise is computed on every third row.
_GRAIN_CELLS, _GRAIN_OCTAVES, _GRAIN_ROWS = (2.0, 40.0), 2, 3
# Distance between the grain of two boards in lattice cells: each board is another piece of wood.
_BOARD_SHIFT = 17.0
# Offsets of the room's seed.
_SHADE_SEED, _GRAIN_SEED = 7, 8
_FLOOR = 5


@dataclass(frozen=True, eq=False)
class RoomSurfaces:
    """A room as rays see it. Coordinates are the room's own: metres from its corner."""

    room: RoomEnvironment
    boxes: Boxes
    textures: list[np.ndarray]  #: per face (rows, columns, 3) float32, radiance of linear Rec.709 [kcd/m^2]
    outside: Outside

    def radiance(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return the radiance that arrives along rays.

        Parameters
        ----------
        origins : (n, 3) or (1, 3) float32
            Points in the room [m].
        directions : (n, 3) float32
            Unit vectors away from them.

        Returns
        -------
        (n, 3) float32
            Linear Rec.709 [kcd/m^2], without the room's ``strength``.
        """
        faces, points = cast(self.boxes, origins, directions)
        radiance = np.empty_like(directions)
        corner, size, _ = face_frames(self.boxes)
        order = np.argsort(faces.astype(np.int16), kind="stable")  # radix sort: the rays of each face in a row
        ends = np.searchsorted(faces[order], np.arange(len(self.textures) + 1))
        for face in np.flatnonzero(np.diff(ends)):
            on = order[ends[face] : ends[face + 1]]
            coordinates = face_coordinates(faces[on], points[on])
            found = _bilinear(self.textures[face], (coordinates - corner[face]) / size[face])
            for window in self.room.windows:
                if WALL_FACES[window.wall] == face:
                    inside = np.flatnonzero(in_rectangle(coordinates, window.centre, window.size))
                    shining, kind = window_radiance(window, coordinates[inside], directions[on[inside]], self.outside)
                    found[inside[kind == 1]] = shining[kind == 1]
            radiance[on] = found
        return radiance


def room_surfaces(room: RoomEnvironment) -> RoomSurfaces:
    """Return the surfaces of a room, lit by its windows and lamps, without ``rotation`` and ``strength``."""
    boxes, outside = boxes_of(room), outside_of(room)
    irradiance = room_irradiance(room)
    size = face_frames(boxes)[1]
    texel = np.full(len(size), _PLAIN_TEXEL)
    texel[[WALL_FACES[panel.wall] for panel in room.panels]] = _FINE_TEXEL
    if room.board_width > 0.0:
        texel[_FLOOR] = _FINE_TEXEL
    texel[[face for face in range(6) if picture_of(room, face) is not None]] = _FINE_TEXEL
    shape = np.clip(np.ceil(size / texel[:, None]), 2, _MOST_TEXELS).astype(np.int64)
    textures = [_texture(room, boxes, face, irradiance[face], shape[face]) for face in range(len(shape))]
    return RoomSurfaces(room, boxes, textures, outside)


def _bilinear(texture: np.ndarray, fraction: np.ndarray) -> np.ndarray:
    """Return a texture at places given as fractions of its sides, (n, 2) in [0, 1] -> (n, 3) float32."""
    rows, columns = texture.shape[:2]
    flat = texture.reshape(-1, 3)
    u, v = (np.clip(fraction[:, k] * texture.shape[k] - 0.5, 0.0, texture.shape[k] - 1.0) for k in range(2))
    row, column = np.minimum(u.astype(np.int32), rows - 2), np.minimum(v.astype(np.int32), columns - 2)
    fu, fv = (u - row).astype(np.float32)[:, None], (v - column).astype(np.float32)[:, None]
    at = row * columns + column
    low, high = flat.take(at, axis=0), flat.take(at + columns, axis=0)
    low += (flat.take(at + 1, axis=0) - low) * fv
    high += (flat.take(at + columns + 1, axis=0) - high) * fv
    return low + (high - low) * fu


def _texture(room: RoomEnvironment, boxes: Boxes, face: int, irradiance: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Return the radiance of a face's texels, (rows, columns, 3) float32."""
    corner, size, _ = face_frames(boxes)
    rows, columns = map(int, shape)
    light = cv2.resize(irradiance, (columns, rows), interpolation=cv2.INTER_LINEAR)
    frame = corner[face], size[face], shape
    panels = [(item.colour, *_patch(item, *frame)) for item in room.panels if WALL_FACES[item.wall] == face]
    windows = [_patch(item, *frame) for item in room.windows if WALL_FACES[item.wall] == face]
    picture = picture_of(room, face)
    pictured = None if picture is None else picture_over(picture, size[face], shape)
    factor = _paint(room, boxes, face, shape) if pictured is None else np.ones((rows, columns), np.float32)
    if face == _FLOOR and room.board_width > 0.0 and pictured is None:
        factor *= _boards(size[face], shape, room.board_width, room.seed)
    planes = []
    # One primary at a time: long rows are several times as fast as rows of three.
    for primary in range(3):
        plane = np.full((rows, columns), boxes.reflectance[face, primary], dtype=np.float32)
        if pictured is not None:
            plane = np.ascontiguousarray(pictured[..., primary])
        for colour, where, cover in panels:
            plane[where] += cover * (np.float32(colour[primary]) - plane[where])
        plane *= factor
        np.minimum(plane, 1.0, out=plane)
        # A window's texels are those of its frame and mullions; between these a ray leaves the room.
        for where, cover in windows:
            plane[where] += cover * (np.float32(BAR_REFLECTANCE) - plane[where])
        planes.append(plane)
    return cv2.multiply(light, cv2.merge(planes), scale=1.0 / np.pi)


def _patch(
    item: Panel | Window, corner: np.ndarray, size: np.ndarray, shape: np.ndarray
) -> tuple[tuple[slice, slice], np.ndarray]:
    """Return the block of a face's texels that a rectangle touches, and the fraction of each that it covers."""
    cover = coverage(item.centre, item.size, corner, size, shape)
    rows, columns = (np.flatnonzero(cover.any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        return (slice(0), slice(0)), cover[:0, :0]
    where = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    return where, cover[where]


def _paint(room: RoomEnvironment, boxes: Boxes, face: int, shape: np.ndarray) -> np.ndarray:
    """Return the factor of uneven plaster and paint, (rows, columns) float32."""
    corner, size, _ = face_frames(boxes)
    steps = np.maximum(np.ceil(size[face] / _PAINT_STEP), 2).astype(np.int64)
    places = corner[face] + (np.indices(steps).reshape(2, -1).T + 0.5) / steps * size[face]
    points = face_points(boxes, np.full(len(places), face), places) * _PAINT_CELLS
    factor = _PAINT_LEAST + _PAINT_RANGE * fractal_value_noise(points, room.seed, _PAINT_OCTAVES)
    return cv2.resize(factor.reshape(steps), (int(shape[1]), int(shape[0])), interpolation=cv2.INTER_LINEAR)


def _boards(size: np.ndarray, shape: np.ndarray, width: float, seed: int) -> np.ndarray:
    """Return the factor of floor boards along x, (rows, columns) float32: shades, grain along x, dark joints."""
    rows, columns = map(int, shape)
    grain_rows = -(-rows // _GRAIN_ROWS)
    x = (np.arange(grain_rows) + 0.5) / grain_rows * size[0]
    y = (np.arange(columns) + 0.5) / columns * size[1]
    board = np.floor(y / width).astype(np.int64)
    zero = np.zeros_like(board)
    shade = _BOARD_LEAST + _BOARD_RANGE * lattice(np.stack([board, zero, zero], axis=1), seed + _SHADE_SEED)
    points = np.zeros((grain_rows, columns, 3))
    points[..., 0], points[..., 1] = x[:, None] * _GRAIN_CELLS[0], y * _GRAIN_CELLS[1]
    points += board[:, None] * _BOARD_SHIFT
    grain = _GRAIN_LEAST + _GRAIN_RANGE * fractal_value_noise(points, seed + _GRAIN_SEED, _GRAIN_OCTAVES)
    grain = cv2.resize(grain, (columns, rows), interpolation=cv2.INTER_LINEAR)
    # The fraction of each texel that a joint covers.
    edges = np.arange(columns + 1) / columns * size[1]
    covered = np.diff(_joints_before(edges, width)) / np.diff(edges)
    return grain * (shade * (1.0 - (1.0 - _JOINT_SHADE) * covered)).astype(np.float32)


def _joints_before(y: np.ndarray, width: float) -> np.ndarray:
    """Return the total width of the joints between 0 and places across the boards; joints are centred on k width."""
    shifted = y + 0.5 * _JOINT
    return np.floor(shifted / width) * _JOINT + np.minimum(shifted % width, _JOINT)
