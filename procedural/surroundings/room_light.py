"""How light spreads in a room: glowing rectangles, soft shadows and diffuse interreflection.

A radiosity solution on a grid of points per face (Goral et al., "Modeling the Interaction of Light Between Diffuse
Surfaces", SIGGRAPH 1984), so that the contrast between a window and the walls follows from the room itself.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..description.surroundings import RoomEnvironment, Window
from ..materials.noise import fractal_value_noise as fractal_noise
from .room_geometry import (
    WALL_FACES,
    Boxes,
    blocked,
    cast,
    face_coordinates,
    face_frames,
    face_points,
    in_rectangle,
)

#: Points per side of a face's grid.
GRID = 16
# Points per side of a glowing rectangle, for direct light with soft shadows.
_GLOW_SAMPLES = 4
# Directions per point for the light from other walls; a 3 x 3 mean of the points removes what noise they leave.
_GATHER = 64
# Rounds of reflection: with walls of 0.8 mean reflectance 0.8^24 = 0.5 % of the light is left out.
_BOUNCES = 24
# Width of a mullion [m], and reflectance of its paint.
_BAR_WIDTH, _BAR_PAINT = 0.05, 0.6
# Share of the rectangle's shorter side over which a lamp's diffuser fades at its rim.
_LAMP_RIM = 0.08
# Luminance of the land outside over the sky's: about the reflectance of vegetation and paving, 0.1 to 0.3.
_LAND = 0.22


def glow(window: Window, coordinates: np.ndarray, outward: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the radiance that comes through points of a rectangle.

    Parameters
    ----------
    window : Window
        The rectangle.
    coordinates : (n, 2) float
        Points in the wall's own coordinates [m].
    outward : (n, 3) float
        Unit vectors from the room through the points.
    seed : int
        Seed of the skyline outside.

    Returns
    -------
    radiance : (n, 3) float32
        0 outside the rectangle and on its bars.
    kind : (n,) int8
        0 outside the rectangle, 1 shining, 2 a bar or a frame.
    """
    size = np.array(window.size, dtype=np.float32)
    distance = coordinates - np.array(window.centre, dtype=np.float32) + 0.5 * size
    kind = in_rectangle(coordinates, window.centre, window.size).astype(np.int8)
    inside = np.flatnonzero(kind)
    level = np.zeros(len(kind), dtype=np.float32)
    if window.kind == "lamp":
        edge = np.minimum(distance, size - distance)[inside].min(axis=1)
        level[inside] = np.clip(edge / (_LAMP_RIM * size.min()), 0.0, 1.0)
    else:
        on_bar = _on_bar(distance[inside], size, window.bars)
        kind[inside[on_bar]] = 2
        level[inside[~on_bar]] = _outside(outward[inside[~on_bar]], seed)
    return level[:, None] * np.array(window.radiance, dtype=np.float32), kind


def solve(room: RoomEnvironment, boxes: Boxes) -> np.ndarray:
    """Return the irradiance on a grid of points of every face.

    Parameters
    ----------
    room : RoomEnvironment
        The description.
    boxes : Boxes
        Its geometry.

    Returns
    -------
    (f, GRID, GRID, 3) float32
        By face, then along its first and second own coordinate.
    """
    faces, points, normals = _grid_points(boxes)
    direct = np.zeros((len(points), 3), dtype=np.float32)
    for window in room.windows:
        direct += _direct(window, room.seed, boxes, points, normals)
    source = _form_factors(boxes, points, normals, np.random.Generator(np.random.PCG64(room.seed)))
    shining = _shining_share(room, boxes, points, faces)
    reflectance = boxes.reflectance[faces] * (1.0 - shining)[:, None]
    total = direct
    for _ in range(_BOUNCES):
        total = direct + _smoothed(source @ (reflectance * total))
    return total.reshape(-1, GRID, GRID, 3).astype(np.float32)


def sample(grids: np.ndarray, boxes: Boxes, faces: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Return the irradiance at points of faces by bilinear interpolation, (n, 3) float32."""
    corner, size, _ = face_frames(boxes)
    place = (coordinates - corner[faces]) / size[faces] * GRID - 0.5
    place = np.clip(place, 0.0, GRID - 1.0)
    base = np.minimum(place.astype(np.int64), GRID - 2)
    (fu, fv), (iu, iv) = (place - base).T.astype(np.float32)[..., None], base.T
    low = grids[faces, iu, iv] * (1.0 - fu) + grids[faces, iu + 1, iv] * fu
    high = grids[faces, iu, iv + 1] * (1.0 - fu) + grids[faces, iu + 1, iv + 1] * fu
    return low * (1.0 - fv) + high * fv


def bar_radiance(irradiance: np.ndarray) -> np.ndarray:
    """Return the radiance of a mullion's painted inside."""
    return irradiance * np.float32(_BAR_PAINT / np.pi)


def _grid_points(boxes: Boxes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    corner, size, normals = face_frames(boxes)
    steps = (np.arange(GRID) + 0.5) / GRID
    cells = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    faces = np.repeat(np.arange(len(corner)), GRID * GRID)
    coordinates = corner[faces] + np.tile(cells, (len(corner), 1)) * size[faces]
    return faces, face_points(boxes, faces, coordinates), normals[faces]


def _direct(window: Window, seed: int, boxes: Boxes, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the irradiance from one rectangle, by midpoints of equal parts with a shadow ray each."""
    steps = (np.arange(_GLOW_SAMPLES) + 0.5) / _GLOW_SAMPLES - 0.5
    face = WALL_FACES[window.wall]
    area = window.size[0] * window.size[1] / _GLOW_SAMPLES**2
    inward = face_frames(boxes)[2][face]
    bare = window.model_copy(update={"bars": 0})
    total = np.zeros((len(points), 3), dtype=np.float32)
    for u in steps:
        for v in steps:
            place = np.array([[window.centre[0] + u * window.size[0], window.centre[1] + v * window.size[1]]])
            end = face_points(boxes, np.array([face]), place)
            offset = end - points
            lit = np.flatnonzero((np.einsum("ij,ij->i", offset, normals) > 0.0) & (offset @ inward < 0.0))
            lit = lit[~blocked(boxes, points[lit], end)]
            squared = np.maximum(np.einsum("ij,ij->i", offset[lit], offset[lit]), area / np.pi)
            outward = offset[lit] / np.sqrt(squared)[:, None]
            cosines = -(outward @ inward) * np.einsum("ij,ij->i", outward, normals[lit])
            radiance, _ = glow(bare, np.broadcast_to(place, (len(lit), 2)), outward, seed)
            total[lit] += radiance * (cosines * area / squared)[:, None].astype(np.float32)
    return total


def _form_factors(boxes: Boxes, points: np.ndarray, normals: np.ndarray, rng: np.random.Generator) -> sparse.csr_array:
    """Return the form factors from every point to every other: shares of cosine-distributed rays, (n, n)."""
    corner, size, _ = face_frames(boxes)
    count = len(points)
    cells = np.empty((count, _GATHER), dtype=np.int64)
    for ray in range(_GATHER):
        # A point on the unit sphere about the tip of the normal is cosine-distributed about the normal.
        height = 2.0 * (ray + rng.uniform(size=len(points))) / _GATHER - 1.0
        turn = 2.0 * np.pi * rng.uniform(size=len(points))
        flat = np.sqrt(np.maximum(1.0 - height**2, 0.0))
        ball = np.stack([flat * np.cos(turn), flat * np.sin(turn), height], axis=1)
        directions = normals * 1.0001 + ball
        directions = (directions / np.linalg.norm(directions, axis=1, keepdims=True)).astype(np.float32)
        faces, ends = cast(boxes, points + normals * np.float32(1e-3), directions)
        place = (face_coordinates(faces, ends) - corner[faces]) / size[faces]
        iu, iv = np.clip((place * GRID).astype(np.int64), 0, GRID - 1).T
        cells[:, ray] = (faces * GRID + iu) * GRID + iv
    rows = np.arange(count + 1) * _GATHER
    shares = np.full(cells.size, 1.0 / _GATHER, dtype=np.float32)
    return sparse.csr_array((shares, cells.ravel(), rows), shape=(count, count))


def _shining_share(room: RoomEnvironment, boxes: Boxes, points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return 1 where a grid point lies on a rectangle that shines (it reflects nothing back), else 0."""
    shining = np.zeros(len(points), dtype=np.float32)
    coordinates = face_coordinates(faces, points)
    for window in room.windows:
        shining[(faces == WALL_FACES[window.wall]) & in_rectangle(coordinates, window.centre, window.size)] = 1.0
    return shining


def _smoothed(values: np.ndarray) -> np.ndarray:
    """Return the 3 x 3 mean over each face's grid, edges repeated."""
    grid = np.pad(values.reshape(-1, GRID, GRID, 3), ((0, 0), (1, 1), (1, 1), (0, 0)), mode="edge")
    rows = grid[:, :-2] + grid[:, 1:-1] + grid[:, 2:]
    return ((rows[:, :, :-2] + rows[:, :, 1:-1] + rows[:, :, 2:]) / 9.0).reshape(-1, 3)


def _on_bar(distance: np.ndarray, size: np.ndarray, bars: int) -> np.ndarray:
    """Return whether points lie on the frame or on one of the mullions."""
    on = np.minimum(distance, size - distance).min(axis=1) < _BAR_WIDTH
    for bar in range(1, bars + 1):
        on = on | (np.abs(distance - size * bar / (bars + 1)).min(axis=1) < 0.5 * _BAR_WIDTH)
    return on


def _outside(outward: np.ndarray, seed: int) -> np.ndarray:
    """Return the radiance outside over the sky's: a sky that brightens to the horizon, a skyline, and land below."""
    elevation = np.arcsin(np.clip(outward[:, 2], -1.0, 1.0))
    flat = outward.copy()
    flat[:, 2] = 0.0
    # Houses and trees up to 11 degrees high; the finest octave is about 2 degrees wide.
    skyline = 0.2 * fractal_noise(flat * 4.0, seed + 101, 4) ** 2
    leaves = 0.5 + fractal_noise(outward * 25.0, seed + 202, 3)
    sky = 1.0 - 0.35 * np.clip(elevation / 1.2, 0.0, 1.0)
    # Softened over 1 degree: the glass and the air blur what is far.
    share = np.clip((elevation - skyline) / 0.0175 + 0.5, 0.0, 1.0)
    return share * sky + (1.0 - share) * _LAND * leaves
