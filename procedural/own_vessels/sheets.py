"""Surfaces that are open: small holes are filled, and sheets without a thickness get one."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...core.errors import InputError

#: Holes up to this fraction of the longest side are filled [1]: a missing triangle, not an opening.
SMALL_HOLE = 0.05


def loose_rings(faces: np.ndarray) -> list[np.ndarray] | None:
    """Return the closed lines of edges with one face, in the direction that faces on their other side would have.

    None where a point has several ways on.
    """
    start, end = faces.reshape(-1).astype(np.int64), np.roll(faces, -1, axis=1).reshape(-1).astype(np.int64)
    count = int(faces.max()) + 1
    single = ~np.isin(start * count + end, end * count + start)
    after = dict(zip(end[single].tolist(), start[single].tolist(), strict=True))
    if len(after) != int(single.sum()) or after.keys() != set(after.values()):
        return None
    rings = []
    while after:
        first, place = after.popitem()
        ring = [first]
        while place != first:
            ring.append(place)
            place = after.pop(place)
        rings.append(np.array(ring))
    return rings


def holes_filled(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the faces with those that fill small holes, each by a fan from one of its points."""
    reach = SMALL_HOLE * float(np.ptp(vertices, axis=0).max())
    rings = [ring for ring in loose_rings(faces) or [] if np.ptp(vertices[ring], axis=0).max() <= reach]
    fans = [np.stack([np.full(len(ring) - 2, ring[0]), ring[1:-1], ring[2:]], axis=1) for ring in rings]
    return np.concatenate([faces, *fans])


def thickened(path: Path, vertices: np.ndarray, faces: np.ndarray, thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a solid with a sheet as its outside: a second sheet lies inwards, and strips join the edges of the two.

    The sheet's sides are those of its faces, where these look away from the middle; otherwise the other ones.

    Parameters
    ----------
    path : Path
        The file, for the error line.
    vertices, faces : (n, 3) float64, (m, 3) int
        An open surface whose neighbours look to the same side [m].
    thickness : float
        Of the solid [m].

    Raises
    ------
    InputError
        Where several sheets meet in one point of their edges.
    """
    rings = loose_rings(faces)
    if rings is None:
        raise InputError(path, "edges of a surface that do not touch each other", "edges that do")
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middle = 0.5 * (vertices.min(0) + vertices.max(0))
    if np.einsum("ij,ij->", corners.mean(1) - middle, cross) < 0.0:
        faces, cross, rings = faces[:, ::-1], -cross, [ring[::-1] for ring in rings]
    count = len(vertices)
    inside = vertices - thickness * _offsets(vertices, faces, cross)
    strips = []
    for ring in rings:
        after = np.roll(ring, -1)
        strips += [np.stack([ring, after, ring + count], 1), np.stack([after, after + count, ring + count], 1)]
    return np.concatenate([vertices, inside]), np.concatenate([faces, faces[:, ::-1] + count, *strips])


def _offsets(vertices: np.ndarray, faces: np.ndarray, cross: np.ndarray) -> np.ndarray:
    """Return, for each point, the vector along which its faces move by one along their normals, as far as they agree.

    The least-squares solution of ``n_i . x = 1`` over the normals of the faces at the point, damped so that faces that
    nearly oppose each other do not send it far.
    """
    unit = cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), np.finfo(float).tiny)
    matrix, right = np.zeros((len(vertices), 3, 3)), np.zeros((len(vertices), 3))
    angles = corner_angles(vertices, faces)
    for k in range(3):
        weight = angles[:, k, None]
        np.add.at(matrix, faces[:, k], (weight * unit)[:, :, None] * unit[:, None, :])
        np.add.at(right, faces[:, k], weight * unit)
    scale = np.trace(matrix, axis1=1, axis2=2)[:, None, None]
    return np.linalg.solve(matrix + 1e-2 * scale * np.eye(3) / 3.0 + 1e-12 * np.eye(3), right[..., None])[..., 0]


def corner_angles(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the angles of triangles at their corners, (m, 3) [rad]."""
    corners = vertices[faces]
    angles = []
    for k in range(3):
        u, v = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        lengths = np.maximum(np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1), np.finfo(float).tiny)
        angles.append(np.arccos(np.clip(np.einsum("ij,ij->i", u, v) / lengths, -1.0, 1.0)))
    return np.stack(angles, axis=1)
