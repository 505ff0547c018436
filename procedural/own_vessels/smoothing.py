"""Low-polygon solids made smooth: their edges are divided along arcs through the points of the file.

The middle of an edge lies where the surfaces at its two ends bend to, as in curved PN triangles (Vlachos, Peters, Boyd
and Mitchell 2001, "Curved PN triangles", I3D '01), by the end that bends less: flat parts stay flat. Along a crease the
tangent of the crease takes the place of the surface, so that rims become circles. The points of the file stay.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...core.errors import InputError
from ..props.normals import creased
from .repair import Surface, doubled_at
from .sheets import corner_angles

#: Edges are divided until none that is smoothed bends by more [rad], a circle of 64 edges; at most so often [1], and
#: into at most so many triangles [1].
_BEND, _PASSES, _MOST_FACES = np.radians(6.0), 5, 200_000
#: Normals that differ by less are those of one surface [1 minus their cosine].
_SAME = 1e-9


def smoothed(path: Path, surface: Surface, angle: float) -> Surface:
    """Return a closed solid whose edges that bend by less than an angle [rad] are rounded.

    Raises
    ------
    InputError
        Where the rounded surface would cross itself.
    """
    vertices, faces = surface.vertices, surface.faces
    for _ in range(_PASSES):
        if 4 * len(faces) > _MOST_FACES or _largest_bend(vertices, faces, angle) <= _BEND:
            break
        vertices, faces = _divided(vertices, faces, angle)
    single = vertices.astype(np.float32).astype(np.float64)
    made = Surface(single, faces)
    place = doubled_at(made) if len(faces) > len(surface.faces) else None
    if place is not None:
        where = f"({', '.join(f'{1e3 * x:.1f}' for x in place)}) mm"
        raise InputError(path, "a surface that does not cross itself when it is smoothed", f"one that does, at {where}")
    return made


def _edges(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the ends of the edges (e, 2), the edge of each corner (m, 3), and its two corners from each side (e, 2).

    A corner of a side is the one at which the edge begins there: the two sides run in opposite directions.
    """
    start, end = faces.reshape(-1).astype(np.int64), np.roll(faces, -1, axis=1).reshape(-1).astype(np.int64)
    keys = np.minimum(start, end) * (int(faces.max()) + 1) + np.maximum(start, end)
    unique, number = np.unique(keys, return_inverse=True)
    number = number.reshape(-1)
    sides = np.argsort(number, kind="stable").reshape(-1, 2)
    return np.stack(np.divmod(unique, int(faces.max()) + 1), axis=1), number.reshape(-1, 3), sides


def _face_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    corners = vertices[faces]
    return _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def _largest_bend(vertices: np.ndarray, faces: np.ndarray, angle: float) -> float:
    """Return the largest angle between faces that is below an angle [rad]."""
    normal = _face_normals(vertices, faces)
    _, _, sides = _edges(faces)
    cosine = np.einsum("ij,ij->i", *(normal[sides[:, k] // 3] for k in range(2)))
    bends = np.arccos(np.clip(cosine, -1.0, 1.0))
    return float(bends[bends <= angle].max(initial=0.0))


def _divided(vertices: np.ndarray, faces: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices with the middles of all edges, and four faces for each."""
    ends, edge, sides = _edges(faces)
    normals = _corner_normals(vertices, faces, angle)
    after = sides - sides % 3 + (sides + 1) % 3
    # At the first end, the corners of both sides there; at the second end likewise.
    forward = faces.reshape(-1)[sides[:, 0]] == ends[:, 0]
    first = np.where(forward[:, None], np.stack([sides[:, 0], after[:, 1]], 1), np.stack([after[:, 0], sides[:, 1]], 1))
    last = np.where(forward[:, None], np.stack([after[:, 0], sides[:, 1]], 1), np.stack([sides[:, 0], after[:, 1]], 1))
    a, b = (vertices[ends[:, k]] for k in range(2))
    off_first, off_last = _off_surface(b - a, normals[first]), _off_surface(a - b, normals[last])
    lengths = [np.linalg.norm(off, axis=1, keepdims=True) for off in (off_first, off_last)]
    least = np.minimum(*lengths)
    same_side = np.einsum("ij,ij->i", off_first, off_last)[:, None] > 0.0
    bend = sum(off / np.maximum(length, 1e-300) for off, length in zip((off_first, off_last), lengths, strict=True))
    middles = 0.5 * (a + b) - np.where(same_side, 0.125 * least * bend, 0.0)
    count = len(vertices)
    ab, bc, ca = (count + edge).T
    one, two, three = faces.T
    pieces = [np.stack(corners, 1) for corners in ((one, ab, ca), (ab, two, bc), (ca, bc, three), (ab, bc, ca))]
    return np.concatenate([vertices, middles]), np.concatenate(pieces)


def _off_surface(along: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the part of vectors (e, 3) that is not in the surface, or along the crease of two (e, 2, 3)."""
    n, m = normals[:, 0], normals[:, 1]
    crease = np.cross(n, m)
    tangent = _unit(crease)
    smooth = (1.0 - np.einsum("ij,ij->i", n, m) < _SAME)[:, None]
    out = np.einsum("ij,ij->i", along, n)[:, None] * n
    return np.where(smooth, out, along - np.einsum("ij,ij->i", along, tangent)[:, None] * tangent)


def _corner_normals(vertices: np.ndarray, faces: np.ndarray, angle: float) -> np.ndarray:
    """Return the normal at each corner (3m, 3), the mean by angle over faces that bend by less than an angle."""
    _, corner, _, _ = creased(vertices, faces, crease=angle)
    face = _face_normals(vertices, faces)
    angles = corner_angles(vertices, faces)
    sums = np.zeros((int(corner.max()) + 1, 3))
    for k in range(3):
        np.add.at(sums, corner[:, k], angles[:, k, None] * face)
    return _unit(sums)[corner.reshape(-1)]


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(float).tiny)
