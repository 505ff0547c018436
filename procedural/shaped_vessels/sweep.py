"""Handles and tubes: an ellipse swept along a curve in the xz plane."""

from __future__ import annotations

import numpy as np

from .loft import Solid

#: Points around an ellipse [1], and along a curve; at a handle's 6 mm of radius the chord error is 0.03 mm.
AROUND, ALONG = 32, 40


def swept(path: np.ndarray, in_plane: np.ndarray, across: np.ndarray, inwards: bool = False) -> Solid:
    """Return the closed solid that an ellipse sweeps along a path in the plane y = 0.

    Parameters
    ----------
    path : (n, 2) float
        Points (x, z) of a smooth curve [m].
    in_plane, across : (n,) float
        Half axes of the ellipse, in the plane and along y [m].
    inwards : bool
        Whether the normals point into the solid: of a bore that is taken out of a body.

    Returns
    -------
    Solid
        With flat ends.
    """
    tangent = np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)  # a quarter turn from the tangent, x towards z
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    cosine, sine = np.cos(angle)[None], np.sin(angle)[None]
    points = np.empty((len(path), AROUND, 3))
    points[..., [0, 2]] = path[:, None] + (in_plane[:, None] * cosine)[..., None] * side[:, None]
    points[..., 1] = across[:, None] * sine
    around = np.roll(points, -1, axis=1) - np.roll(points, 1, axis=1)
    normals = np.cross(np.gradient(points, axis=0), around)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    outward = points - np.insert(path, 1, 0.0, axis=1)[:, None]
    if (normals * outward).sum() < 0.0:
        normals = -normals
    return _capped(points, -normals if inwards else normals, path)


def _capped(points: np.ndarray, normals: np.ndarray, path: np.ndarray) -> Solid:
    """Return a tube closed by flat ends, with a crease around them."""
    rows, columns = points.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    ring = np.roll(number, -1, axis=1)
    a, b, c, d = number[:-1], ring[:-1], ring[1:], number[1:]
    start = rows * columns + np.arange(columns)
    end, middles = start + columns, rows * columns + 2 * columns + np.arange(2)
    faces = np.concatenate(
        [
            np.stack([a, b, c], -1).reshape(-1, 3),
            np.stack([a, c, d], -1).reshape(-1, 3),
            np.stack([np.full(columns, middles[0]), np.roll(start, -1), start], -1),
            np.stack([np.full(columns, middles[1]), end, np.roll(end, -1)], -1),
        ]
    )
    vertices = np.concatenate([points.reshape(-1, 3), points[0], points[-1], np.insert(path[[0, -1]], 1, 0.0, axis=1)])
    ends = [path[0] - path[1], path[-1] - path[-2]]
    before, after = (np.insert(end / np.linalg.norm(end), 1, 0.0) for end in ends)
    flat = [np.tile(before, (columns, 1)), np.tile(after, (columns, 1)), before[None], after[None]]
    facing = np.concatenate([normals.reshape(-1, 3), *flat])
    corners = vertices[faces]
    if np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) < 0.0:
        faces = faces[:, ::-1]
    return Solid(vertices, facing, faces, np.zeros(len(faces), bool))


def bezier(points: np.ndarray, count: int = ALONG) -> np.ndarray:
    """Return points of the Bezier curve of four control points (4, 2), evenly in its parameter, (count, 2)."""
    t = np.linspace(0.0, 1.0, count)[:, None]
    s = 1.0 - t
    return s**3 * points[0] + 3.0 * s**2 * t * points[1] + 3.0 * s * t**2 * points[2] + t**3 * points[3]


def flared(count: int, growth: float, length: float) -> np.ndarray:
    """Return a factor along a handle that grows towards both ends, as molten glass does where it is pressed on."""
    t = np.linspace(0.0, 1.0, count)
    return 1.0 + growth * (np.exp(-t / length) + np.exp(-(1.0 - t) / length))
