"""Surfaces that are open: edges are joined, small holes are filled, and sheets without a thickness get one."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ...core.errors import InputError

#: Passes in which edges are split [1]: one for each edge of a face. And most loose edges that are looked at [1]:
#: seams of a body have fewer, more are triangles that never met.
_SPLITS, _MOST_LOOSE = 3, 20_000
#: Least mean cosine between a hole and the faces around it, for a hole in a side [1]: around a mouth, or at the end of
#: a tube, the wall is across the opening.
_IN_SIDE = 0.5
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


def split_at_junctions(vertices: np.ndarray, faces: np.ndarray, reach: float) -> np.ndarray:
    """Return the faces, of which those with a loose edge that passes by loose points are split there (T-junctions).

    Parameters
    ----------
    vertices, faces : (n, 3) float64, (m, 3) int
        An open surface.
    reach : float
        Largest distance between an edge and a point on it.
    """
    for _ in range(_SPLITS):
        start, end = faces.reshape(-1).astype(np.int64), np.roll(faces, -1, axis=1).reshape(-1).astype(np.int64)
        _, edge, count = np.unique(
            np.minimum(start, end) * len(vertices) + np.maximum(start, end), return_inverse=True, return_counts=True
        )
        loose = np.flatnonzero(count[edge.reshape(-1)] == 1)
        if len(loose) > _MOST_LOOSE:
            break
        points = np.unique([start[loose], end[loose]])
        tree = cKDTree(vertices[points])
        split, pieces = set(), []
        for corner in loose.tolist():
            a, b, c = (int(faces[corner // 3, (corner + k) % 3]) for k in range(3))
            line = vertices[b] - vertices[a]
            length = float(np.linalg.norm(line))
            near = points[tree.query_ball_point(0.5 * (vertices[a] + vertices[b]), 0.5 * length)]
            along = (vertices[near] - vertices[a]) @ line / length
            off = np.linalg.norm(vertices[near] - vertices[a] - along[:, None] * line / length, axis=1)
            on = (off <= reach) & (along > reach) & (along < length - reach) & (near != c)
            if corner // 3 in split or not on.any():
                continue
            split.add(corner // 3)
            way = [a, *near[on][np.argsort(along[on])].tolist(), b]
            pieces += [[first, second, c] for first, second in pairwise(way)]
        if not split:
            break
        faces = np.concatenate([np.delete(faces, sorted(split), axis=0), np.array(pieces, faces.dtype)])
    return faces


def holes_filled(vertices: np.ndarray, faces: np.ndarray, in_sides: bool = False) -> np.ndarray:
    """Return the faces with those that fill small holes, each by a fan from one of its points.

    With `in_sides`, holes that go on where the faces around them are; not mouths, around which the wall is across.
    """
    reach = SMALL_HOLE * float(np.ptp(vertices, axis=0).max())
    rings = [ring for ring in loose_rings(faces) or [] if np.ptp(vertices[ring], axis=0).max() <= reach]
    if in_sides and rings:
        normals = _normals_at_edges(vertices, faces)
        rings = [ring for ring in rings if _agreement(vertices, ring, normals) >= _IN_SIDE]
    fans = [np.stack([np.full(len(ring) - 2, ring[0]), ring[1:-1], ring[2:]], axis=1) for ring in rings]
    return np.concatenate([faces, *fans])


def _normals_at_edges(vertices: np.ndarray, faces: np.ndarray) -> dict[tuple[int, int], np.ndarray]:
    """Return the unit normal of the face at each directed edge."""
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    unit = cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), np.finfo(float).tiny)
    ends = zip(faces.reshape(-1).tolist(), np.roll(faces, -1, axis=1).reshape(-1).tolist(), strict=True)
    return {pair: unit[number // 3] for number, pair in enumerate(ends)}


def _agreement(vertices: np.ndarray, ring: np.ndarray, normals: dict[tuple[int, int], np.ndarray]) -> float:
    """Return the mean cosine between what fills a hole and the faces around it, by length of their edges."""
    points, after = vertices[ring], vertices[np.roll(ring, -1)]
    area = np.cross(points - points[0], after - points[0]).sum(0)
    area /= max(float(np.linalg.norm(area)), np.finfo(float).tiny)
    # Faces go along the hole's edges the other way.
    around = np.array([normals[pair] for pair in zip(np.roll(ring, -1).tolist(), ring.tolist(), strict=True)])
    return float(np.average(around @ area, weights=np.linalg.norm(after - points, axis=1)))


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
