"""Flat and round pieces that a room's surfaces consist of: grids, boxes and cylinders with texture coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .room_geometry import ALONG

#: Distance of the vertices on furniture [m]: the light changes there over decimetres.
BODY_STEP = 0.25
# Sides of a cylinder: seen from a metre a lamp shade of 0.4 m is round to a millimetre.
_SIDES = 24


@dataclass(frozen=True, eq=False)
class Patch:
    """One flat or round piece of a body before it is joined with others."""

    points: np.ndarray  #: (n, 3) [m]
    normals: np.ndarray
    faces: np.ndarray
    uv: np.ndarray  #: (n, 2) along the surface [m]
    irradiance: np.ndarray | None = None


def grid_faces(shape: tuple[int, int], points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return two triangles for each cell of a grid of vertices that face along the normal, (cells, 2, 3)."""
    index = np.arange(shape[0] * shape[1]).reshape(shape)
    a, b, c, d = (x.ravel() for x in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=1)
    p, q, r = (points[faces[0, 0, k]] for k in range(3))
    return faces if np.linalg.det([q - p, r - p, normal]) > 0.0 else faces[..., ::-1]


def box_patches(lower: np.ndarray, upper: np.ndarray, step: float) -> list[tuple[int, Patch]]:
    """Return the faces of a box seen from outside, numbered as in `room_geometry`."""
    found = []
    for face in range(6):
        axis, side = face // 2, face % 2
        normal = np.zeros(3)
        normal[axis] = 1.0 - 2.0 * side
        along = ALONG[axis]
        counts = [max(1, int(np.ceil((upper[k] - lower[k]) / step - 1e-6))) for k in along]
        lines = [np.linspace(lower[k], upper[k], n + 1) for k, n in zip(along, counts, strict=True)]
        grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
        points = np.empty((len(grid), 3))
        points[:, axis] = (upper, lower)[side][axis]
        points[:, along] = grid
        faces = grid_faces((counts[0] + 1, counts[1] + 1), points, normal).reshape(-1, 3)
        # Texture coordinates along the longest edges: the grain of a board follows it.
        uv = grid - lower[along]
        uv = uv[:, ::-1] if np.ptp(grid[:, 1]) > np.ptp(grid[:, 0]) else uv
        found.append((face, Patch(points, np.tile(normal, (len(points), 1)), faces, uv)))
    return found


def cylinder_patches(half: np.ndarray) -> list[Patch]:
    """Return the side and both ends of a cylinder about z."""
    angle = 2.0 * np.pi * np.arange(_SIDES + 1) / _SIDES
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    outward = np.concatenate([ring / half[:2], np.zeros((len(ring), 1))], axis=1)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    levels = np.array([-half[2], half[2]])
    points = np.concatenate([np.column_stack([ring * half[:2], np.full(len(ring), z)]) for z in levels])
    low, n = np.arange(_SIDES), _SIDES + 1
    side = np.concatenate([np.stack([low, low + 1, low + 1 + n], -1), np.stack([low, low + 1 + n, low + n], -1)])
    uv = np.column_stack([np.tile(angle * half[0], 2), np.repeat(levels, n)])
    patches = [Patch(points, np.tile(outward, (2, 1)), side, uv)]
    for sign, z in zip((-1.0, 1.0), levels, strict=True):
        cap = np.column_stack([ring[:-1] * half[:2], np.full(_SIDES, z)])
        fan = np.stack([np.zeros(_SIDES - 2, int), np.arange(1, _SIDES - 1), np.arange(2, _SIDES)], -1)
        up = np.tile([0.0, 0.0, sign], (_SIDES, 1))
        patches.append(Patch(cap, up, fan if sign > 0.0 else fan[:, ::-1], cap[:, :2]))
    return patches
