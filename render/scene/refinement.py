"""Mesh refinement: edges are split until none is longer than a limit; shape, shading and texture stay the same."""

from __future__ import annotations

import numpy as np

from ...core.mesh import Mesh

#: Maximum number of passes: each halves the longest edges, so this many reduce an edge of 4 m below 1 mm.
_MAX_PASSES = 12


def refined(mesh: Mesh, max_edge: float, max_faces: int) -> Mesh:
    """Return the mesh with edges of at most `max_edge`, or as fine as `max_faces` allows.

    A face is split at the midpoints of its long edges, and its neighbour at the same points, so no cracks appear.
    Normals at new vertices are means of their neighbours, not normalised: interpolated normals stay the same.

    Parameters
    ----------
    mesh : Mesh
        The mesh, in metres.
    max_edge : float
        Maximum edge length [m].
    max_faces : int
        Number of faces above which no further pass is made.
    """
    columns = [mesh.vertices, *(x for x in (mesh.normals, mesh.uv) if x is not None)]
    values, faces = np.concatenate(columns, axis=1).astype(np.float64), mesh.faces.astype(np.int64)
    for _ in range(_MAX_PASSES):
        if len(faces) > max_faces:
            break
        values, faces, changed = _split_long_edges(values, faces, max_edge)
        if not changed:
            break
    normals = values[:, 3:6] if mesh.normals is not None else None
    uv = values[:, -2:] if mesh.uv is not None else None
    return Mesh(mesh.name, values[:, :3], faces, normals, uv)


def unwelded(mesh: Mesh) -> Mesh:
    """Return the mesh with three separate vertices for every face."""
    index = mesh.faces.ravel()
    normals, uv = (None if x is None else x[index] for x in (mesh.normals, mesh.uv))
    return Mesh(mesh.name, mesh.vertices[index], np.arange(len(index)).reshape(-1, 3), normals, uv)


def _split_long_edges(values: np.ndarray, faces: np.ndarray, max_edge: float) -> tuple[np.ndarray, np.ndarray, bool]:
    """Split every long edge once; return vertices, faces and whether any edge was split."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)  # edge k runs from corner k
    lengths = np.linalg.norm(values[ends[:, 0], :3] - values[ends[:, 1], :3], axis=1)
    # Edges by position, not by vertex: on both sides of a seam the same edge is split at the same point.
    cut = lengths > max_edge
    if not cut.any():
        return values, faces, False
    edges, which = np.unique(np.sort(ends[cut], axis=1), axis=0, return_inverse=True)
    middles = 0.5 * (values[edges[:, 0]] + values[edges[:, 1]])
    middle = np.full(len(ends), -1)
    middle[cut] = len(values) + which.reshape(-1)
    return np.concatenate([values, middles]), _split_faces(faces, middle.reshape(-1, 3)), True


def _split_faces(faces: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Return the faces split at the midpoints of their edges (-1: not split); edge k runs from corner k to k + 1."""
    cut = middle >= 0
    number, pieces = cut.sum(1), [faces[~cut.any(1)]]
    # Corners are rotated so that the first edge is split, and with two split edges so that the third is not.
    turn = np.where(number == 2, (np.argmin(cut, 1) + 1) % 3, np.argmax(cut, 1))
    order = (turn[:, None] + np.arange(3)) % 3
    (a, b, c), (ab, bc, ca) = (np.take_along_axis(x, order, 1).T for x in (faces, middle))
    one, two, three = (number == k for k in (1, 2, 3))
    pieces += [np.stack(corners, 1)[one] for corners in ((a, ab, c), (ab, b, c))]
    pieces += [np.stack(corners, 1)[two] for corners in ((ab, b, bc), (a, ab, bc), (a, bc, c))]
    pieces += [np.stack(corners, 1)[three] for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return np.concatenate(pieces)
