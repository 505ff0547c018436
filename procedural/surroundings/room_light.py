"""Radiosity of a room: direct light of windows and lamps, soft shadows and diffuse interreflection.

Every face of the room and of its furniture is cut into cells. Form factors between cells come from cosine-distributed
rays (Goral et al., "Modeling the Interaction of Light Between Diffuse Surfaces", SIGGRAPH 1984), so that the contrast
between a window and the walls follows from the room itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from scipy import sparse

from ..description.surroundings import RoomEnvironment, Window
from .room_geometry import (
    WALL_FACES,
    Boxes,
    blocked,
    boxes_of,
    cast,
    face_coordinates,
    face_frames,
    face_points,
)
from .windows import Outside, coverage, outside_of, shining_level

#: Side of a cell [m], and the fewest and most cells along one side of a face. Indirect light changes over a metre; the
#: shadows of furniture are soft over some decimetres, because windows and lamps are large.
CELL_SIZE, _FEWEST_CELLS, _MOST_CELLS = 0.25, 2, 24
# Points per side of a window or lamp, for direct light with soft shadows.
_WINDOW_SAMPLES = 4
# Rays per cell for the form factors; a 3 x 3 mean of the cells removes the noise that they leave.
_RAYS_PER_CELL = 64
# Rays that are cast at once: keeps memory near 50 MB.
_RAYS_PER_PASS = 1 << 18
# Reflections: with walls of 0.8 mean reflectance 0.8^24 = 0.5 % of the light is left out.
_BOUNCES = 24
# Rays start this far off the surface that they leave [m].
_RAY_OFFSET = np.float32(1e-3)


@dataclass(frozen=True, eq=False)
class Cells:
    """The cells of all faces in one list: face by face, then along the first and the second own coordinate."""

    first: np.ndarray  #: (f,) int64, number of each face's first cell
    shape: np.ndarray  #: (f, 2) int64, cells along both own coordinates of each face
    face: np.ndarray  #: (n,) int64, face of each cell
    coordinates: np.ndarray  #: (n, 2) float32, centre of each cell in its face's own coordinates [m]

    def by_face(self, values: np.ndarray) -> list[np.ndarray]:
        """Return values of all cells, (n, ...), as one array a face, (rows, columns, ...)."""
        parts = np.split(values, self.first[1:])
        return [part.reshape(*shape, *values.shape[1:]) for part, shape in zip(parts, self.shape, strict=True)]

    def at(self, face: np.ndarray, fraction: np.ndarray) -> np.ndarray:
        """Return the number of the cell at a place on a face, given as fractions of its sides, (n, 2) in [0, 1]."""
        shape = self.shape[face]
        row, column = np.clip((fraction * shape).astype(np.int64), 0, shape - 1).T
        return self.first[face] + row * shape[:, 1] + column


def cells_of(boxes: Boxes) -> Cells:
    """Return the cells of all faces."""
    corner, size, _ = face_frames(boxes)
    shape = np.clip(np.ceil(size / CELL_SIZE), _FEWEST_CELLS, _MOST_CELLS).astype(np.int64)
    counts = shape.prod(axis=1)
    centres = [
        corner[face] + (np.indices(shape[face]).reshape(2, -1).T + 0.5) / shape[face] * size[face]
        for face in range(len(shape))
    ]
    first = np.cumsum(counts) - counts
    return Cells(first, shape, np.repeat(np.arange(len(shape)), counts), np.concatenate(centres).astype(np.float32))


def room_irradiance(room: RoomEnvironment) -> list[np.ndarray]:
    """Return `solve` of a room, read-only: the last result is remembered, as map and surfaces both ask for it."""
    return _solved(room.model_copy(update={"details": (), "rotation": 0.0, "strength": 1.0}))  # pyright: ignore[reportArgumentType]  # frozen models are hashable at run time


@lru_cache(maxsize=1)
def _solved(room: RoomEnvironment) -> list[np.ndarray]:
    faces = solve(room, boxes_of(room), outside_of(room))
    for face in faces:
        face.setflags(write=False)
    return faces


def solve(room: RoomEnvironment, boxes: Boxes, outside: Outside) -> list[np.ndarray]:
    """Return the irradiance on the cells of every face.

    Parameters
    ----------
    room : RoomEnvironment
        The description.
    boxes : Boxes
        Its geometry.
    outside : Outside
        What lies behind the windows.

    Returns
    -------
    list of (rows, columns, 3) float32
        One array a face; its first two axes follow the face's own coordinates.
    """
    cells = cells_of(boxes)
    points = face_points(boxes, cells.face, cells.coordinates)
    normals = face_frames(boxes)[2][cells.face]
    direct = np.zeros((len(points), 3), dtype=np.float32)
    for window in room.windows:
        direct += _direct(window, outside, boxes, points, normals)
    form_factors = _form_factors(boxes, cells, points, normals, np.random.Generator(np.random.PCG64(room.seed)))
    reflectance = boxes.reflectance[cells.face] * (1.0 - _shining(room, boxes, cells))[:, None]
    total = direct
    for _ in range(_BOUNCES):
        total = direct + _smoothed(cells, form_factors @ (reflectance * total))
    return cells.by_face(total.astype(np.float32))


def _direct(window: Window, outside: Outside, boxes: Boxes, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the irradiance from one window or lamp, by midpoints of equal parts with a shadow ray each, (n, 3)."""
    steps = (np.arange(_WINDOW_SAMPLES) + 0.5) / _WINDOW_SAMPLES - 0.5
    face = WALL_FACES[window.wall]
    area = np.float32(window.size[0] * window.size[1] / _WINDOW_SAMPLES**2)
    inward = face_frames(boxes)[2][face]
    level = np.zeros(len(points), dtype=np.float32)
    for u, v in ((u, v) for u in steps for v in steps):
        place = np.array([[window.centre[0] + u * window.size[0], window.centre[1] + v * window.size[1]]], np.float32)
        end = face_points(boxes, np.array([face]), place)
        offset = end - points
        facing, leaving = np.einsum("ij,ij->i", offset, normals), offset @ inward
        lit = np.flatnonzero((facing > 0.0) & (leaving < 0.0))
        lit = lit[~blocked(boxes, points[lit], end)]
        # Near the window the part is not small: no closer than the radius of a disc of its area.
        squared = np.maximum(np.einsum("ij,ij->i", offset[lit], offset[lit]), area / np.float32(np.pi))
        form = -facing[lit] * leaving[lit] * area / squared**2
        level[lit] += form * shining_level(window, place, offset[lit] / np.sqrt(squared)[:, None], outside)
    return level[:, None] * np.array(window.radiance, dtype=np.float32)


def _form_factors(
    boxes: Boxes, cells: Cells, points: np.ndarray, normals: np.ndarray, rng: np.random.Generator
) -> sparse.csr_array:
    """Return the form factors from every cell to every other: fractions of cosine-distributed rays, (n, n)."""
    corner, size, _ = face_frames(boxes)
    count = len(points)
    found = np.empty((count, _RAYS_PER_CELL), dtype=np.int64)
    step = max(1, _RAYS_PER_PASS // _RAYS_PER_CELL)
    for begin in range(0, count, step):
        some = slice(begin, begin + step)
        directions = _cosine_directions(normals[some], rng)
        origins = (points[some] + normals[some] * _RAY_OFFSET).repeat(_RAYS_PER_CELL, axis=0)
        faces, ends = cast(boxes, origins, directions)
        fraction = (face_coordinates(faces, ends) - corner[faces]) / size[faces]
        found[some] = cells.at(faces, fraction).reshape(-1, _RAYS_PER_CELL)
    rows = np.arange(count + 1) * _RAYS_PER_CELL
    fractions = np.full(found.size, 1.0 / _RAYS_PER_CELL, dtype=np.float32)
    return sparse.csr_array((fractions, found.ravel(), rows), shape=(count, count))


def _cosine_directions(normals: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return cosine-distributed directions about normals, (n, 3) -> (n * rays, 3), stratified by elevation."""
    shape = (len(normals), _RAYS_PER_CELL)
    # A point on the unit sphere about the tip of the normal is cosine-distributed about the normal.
    height = 2.0 * (np.arange(_RAYS_PER_CELL) + rng.uniform(size=shape)) / _RAYS_PER_CELL - 1.0
    turn = 2.0 * np.pi * rng.uniform(size=shape)
    flat = np.sqrt(np.maximum(1.0 - height**2, 0.0))
    ball = np.stack([flat * np.cos(turn), flat * np.sin(turn), height], axis=-1).astype(np.float32)
    # A little longer than 1, so that no direction has length 0.
    directions = (normals[:, None] * np.float32(1.0001) + ball).reshape(-1, 3)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def _shining(room: RoomEnvironment, boxes: Boxes, cells: Cells) -> np.ndarray:
    """Return the fraction of each cell that a window or a lamp covers: it reflects nothing back, (n,) float32."""
    covered = np.zeros(len(cells.face), dtype=np.float32)
    corner, size, _ = face_frames(boxes)
    for window in room.windows:
        face = WALL_FACES[window.wall]
        here = slice(cells.first[face], cells.first[face] + cells.shape[face].prod())
        covered[here] += coverage(window.centre, window.size, corner[face], size[face], cells.shape[face]).ravel()
    return np.minimum(covered, 1.0)


def _smoothed(cells: Cells, values: np.ndarray) -> np.ndarray:
    """Return the 3 x 3 mean over each face's cells, edges repeated."""
    faces = [cv2.blur(face, (3, 3), borderType=cv2.BORDER_REPLICATE) for face in cells.by_face(values)]
    return np.concatenate([face.reshape(-1, 3) for face in faces])
