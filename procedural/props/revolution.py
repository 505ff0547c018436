"""Solids of revolution from a profile of lines and arcs, with exact normals."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...core.mesh import Mesh

#: Steps around the axis. The chord of 1/96 of a turn lies 0.05 % of the radius inside the circle: 0.05 mm at 10 cm.
#: A multiple of four, so that the bounding box is that of the exact solid.
SEGMENTS = 96
#: Greatest turn of an arc between two points of the profile [rad].
ARC_STEP = np.radians(7.5)
#: Lengths below this count as zero [m]: a millionth of a millimetre, far below float32 at 10 cm.
ZERO_LENGTH = 1e-9


@dataclass(frozen=True)
class Piece:
    """A smooth part of a profile: points (k, 2) as (r, z) [m], and unit normals (k, 2) on its right side."""

    points: np.ndarray
    normals: np.ndarray


def line(start: np.ndarray, end: np.ndarray) -> Piece:
    """Return a straight piece."""
    along = (end - start) / np.linalg.norm(end - start)
    return Piece(np.array([start, end]), np.tile([along[1], -along[0]], (2, 1)))


def arc(centre: tuple[float, float], radius: float, start: float, end: float) -> Piece:
    """Return a circular piece between two angles [rad]; clockwise arcs (end < start) are concave."""
    steps = max(2, int(np.ceil(abs(end - start) / ARC_STEP - 1e-6)))
    angle = np.linspace(start, end, steps + 1)
    radial = np.stack([np.cos(angle), np.sin(angle)], 1)
    return Piece(np.array(centre) + radius * radial, radial * np.sign(end - start))


def rounded(corners: list[tuple[float, float]], radii: list[float]) -> list[Piece]:
    """Return a polyline whose inner corners are rounded.

    Parameters
    ----------
    corners : list of (r, z)
        The polyline [m].
    radii : list of float
        Radius at each corner but the first and the last [m]; 0 keeps it sharp.

    Raises
    ------
    ValueError
        If an arc does not fit between the neighbouring corners or arcs.
    """
    pieces, points = [], np.array(corners, float)
    here = points[0]
    for before, corner, after, radius in zip(points[:-2], points[1:-1], points[2:], radii, strict=True):
        inward, outward = _direction(before, corner), _direction(corner, after)
        turn = np.arctan2(inward[0] * outward[1] - inward[1] * outward[0], inward @ outward)
        reach = radius * abs(np.tan(turn / 2))
        first_point, last_point = corner - reach * inward, corner + reach * outward
        if (first_point - here) @ inward < -ZERO_LENGTH or (after - last_point) @ outward < -ZERO_LENGTH:
            raise ValueError(f"expected a radius that fits between its neighbours at corner {corner}, got {radius}")
        if np.linalg.norm(first_point - here) > ZERO_LENGTH:
            pieces.append(line(here, first_point))
        if radius > 0:
            side = np.sign(turn)
            centre = first_point + radius * side * np.array([-inward[1], inward[0]])
            first = np.arctan2(*(first_point - centre)[::-1])
            pieces.append(arc((centre[0], centre[1]), radius, first, first + turn))
        here = last_point
    if np.linalg.norm(points[-1] - here) > ZERO_LENGTH:
        pieces.append(line(here, points[-1]))
    return pieces


def revolve(name: str, pieces: list[Piece], closed: bool = False) -> tuple[Mesh, float]:
    """Return the solid that a profile sweeps about the z axis, centred on its bounding box.

    Parameters
    ----------
    name : str
        Name of the mesh.
    pieces : list of Piece
        The profile, with the solid on its left: from the bottom of the axis along the outside to its top. Each piece
        begins at the end of the one before. Edges between pieces are sharp unless their normals agree.
    closed : bool
        Whether the profile is a loop that does not touch the axis.

    Returns
    -------
    Mesh
        Watertight (doubled vertices have identical positions). u runs once around the axis, v along the profile in the
        same unit of length.
    float
        Length of that unit: the greatest circumference [m].
    """
    joined = _snapped(pieces, closed)
    largest = max(points[:, 0].max() for points in joined)
    middle = (min(p[:, 1].min() for p in joined) + max(p[:, 1].max() for p in joined)) / 2
    unit = 2 * np.pi * largest
    turn = 2 * np.pi * (np.arange(SEGMENTS + 1) % SEGMENTS) / SEGMENTS
    around = np.stack([np.cos(turn), np.sin(turn)], 1)
    # Quarter turns exactly on the axes make the extent exact.
    around[np.abs(around) < ZERO_LENGTH] = 0.0
    parts, offset, travelled = [], 0, 0.0
    for points, piece in zip(joined, pieces, strict=True):
        lengths = travelled + np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        parts.append(_swept(points - [0, middle], piece.normals, around, lengths / unit, offset))
        offset, travelled = offset + len(points) * len(around), lengths[-1]
    vertices, normals, uv, faces = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    return Mesh(name, vertices, _without_slivers(vertices, faces), normals, uv), unit


def _direction(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    return (end - start) / np.linalg.norm(end - start)


def _snapped(pieces: list[Piece], closed: bool) -> list[np.ndarray]:
    """Return the pieces' points with ends that are exactly equal, and exactly on the axis where they touch it."""
    joined = [piece.points.copy() for piece in pieces]
    for points in joined:
        points[np.abs(points[:, 0]) < ZERO_LENGTH, 0] = 0.0
    for before, after in pairwise(joined):
        after[0] = before[-1]
    if closed:
        joined[-1][-1] = joined[0][0]
    return joined


def _swept(
    points: np.ndarray, normals: np.ndarray, around: np.ndarray, v: np.ndarray, offset: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    rows, columns = len(points), len(around)
    vertices = np.empty((rows, columns, 3))
    vertices[..., :2] = points[:, None, :1] * around + 0.0  # + 0.0 turns -0 into 0
    vertices[..., 2] = points[:, None, 1]
    directions = np.empty_like(vertices)
    directions[..., :2] = normals[:, None, :1] * around
    directions[..., 2] = normals[:, None, 1]
    uv = np.stack(np.broadcast_arrays(np.linspace(0, 1, columns), v[:, None]), -1)
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1) + offset
    faces = np.concatenate(
        [
            np.stack([first, first + 1, first + columns + 1], 1),
            np.stack([first, first + columns + 1, first + columns], 1),
        ]
    )
    return vertices.reshape(-1, 3), directions.reshape(-1, 3), uv.reshape(-1, 2), faces


def _without_slivers(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the faces with three different corners: on the axis, half of the quads' triangles have two."""
    corners = vertices.astype(np.float32)[faces]
    same = [np.all(corners[:, i] == corners[:, (i + 1) % 3], axis=1) for i in range(3)]
    return faces[~np.any(same, axis=0)]
