"""Meshes cut finer until no edge is longer than asked, without a change of shape, shading or texture."""

from __future__ import annotations

import numpy as np

from ...core.mesh import Mesh

#: Rounds after which cutting stops: each halves the longest edges, so these take one of 4 m below 1 mm.
_MOST_ROUNDS = 12


def refined(mesh: Mesh, longest: float, most_faces: int) -> Mesh:
    """Return the mesh with edges of at most `longest`, or as fine as `most_faces` allows.

    A face is cut at the middles of its long edges, and so is its neighbour at the same places: no cracks. Normals at
    the new vertices are means of their neighbours, unnormalised, so that they interpolate to what they did before.

    Parameters
    ----------
    mesh : Mesh
        The mesh; the scale of its frame is that of `longest`.
    longest : float
        Longest edge wanted [m].
    most_faces : int
        No round begins with more faces than this.
    """
    columns = [mesh.vertices, *(x for x in (mesh.normals, mesh.uv) if x is not None)]
    values, faces = np.concatenate(columns, axis=1).astype(np.float64), mesh.faces.astype(np.int64)
    for _ in range(_MOST_ROUNDS):
        if len(faces) > most_faces:
            break
        values, faces, changed = _one_round(values, faces, longest)
        if not changed:
            break
    normals = values[:, 3:6] if mesh.normals is not None else None
    uv = values[:, -2:] if mesh.uv is not None else None
    return Mesh(mesh.name, values[:, :3], faces, normals, uv)


def unwelded(mesh: Mesh) -> Mesh:
    """Return the mesh with three vertices of its own for every face."""
    index = mesh.faces.ravel()
    normals, uv = (None if x is None else x[index] for x in (mesh.normals, mesh.uv))
    return Mesh(mesh.name, mesh.vertices[index], np.arange(len(index)).reshape(-1, 3), normals, uv)


def _one_round(values: np.ndarray, faces: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray, bool]:
    """Cut every long edge once; return vertices, faces and whether there was one."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)  # edge k runs from corner k
    lengths = np.linalg.norm(values[ends[:, 0], :3] - values[ends[:, 1], :3], axis=1)
    # Edges by position, not by vertex: on both sides of a seam the same edge is cut at the same place.
    cut = lengths > longest
    if not cut.any():
        return values, faces, False
    edges, which = np.unique(np.sort(ends[cut], axis=1), axis=0, return_inverse=True)
    middles = 0.5 * (values[edges[:, 0]] + values[edges[:, 1]])
    middle = np.full(len(ends), -1)
    middle[cut] = len(values) + which.reshape(-1)
    return np.concatenate([values, middles]), _cut_faces(faces, middle.reshape(-1, 3)), True


def _cut_faces(faces: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Return the faces cut at the middles of their edges (-1: whole edge); edge k runs from corner k to k + 1."""
    cut = middle >= 0
    number, pieces = cut.sum(1), [faces[~cut.any(1)]]
    # Turned so that the first edge is a cut one, and with two cuts so that the third edge is the whole one.
    turn = np.where(number == 2, (np.argmin(cut, 1) + 1) % 3, np.argmax(cut, 1))
    order = (turn[:, None] + np.arange(3)) % 3
    (a, b, c), (ab, bc, ca) = (np.take_along_axis(x, order, 1).T for x in (faces, middle))
    one, two, three = (number == k for k in (1, 2, 3))
    pieces += [np.stack(corners, 1)[one] for corners in ((a, ab, c), (ab, b, c))]
    pieces += [np.stack(corners, 1)[two] for corners in ((ab, b, bc), (a, ab, bc), (a, bc, c))]
    pieces += [np.stack(corners, 1)[three] for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return np.concatenate(pieces)
