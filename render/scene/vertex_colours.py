"""Colours of vertices as a texture, so that they share the kernels of all other opaque surfaces."""

from __future__ import annotations

import math

import numpy as np

from ...core.mesh import Mesh


def coloured(mesh: Mesh) -> tuple[Mesh, np.ndarray]:
    """Return a mesh with texture coordinates, and the texture that shows the colours of its vertices.

    Each face has a square of 2 x 2 texels of its own, with its corners at the centres of three of them. Bilinear
    interpolation between a, b, c and b + c - a is linear, so the texture shows what interpolation between the vertices
    would. The corner a has the middle one of the three luminances, so that the fourth texel is between the others where
    a face has colours of one hue; elsewhere it is clipped.

    Parameters
    ----------
    mesh : Mesh
        A mesh with colours; its own texture coordinates are not used.

    Returns
    -------
    Mesh, (h, w, 3) float32
        Three vertices for each face; linear Rec.709, the first row at v = 0, as `textures.bake` returns it.

    Raises
    ------
    ValueError
        Where the mesh has no colours.
    """
    if mesh.colours is None:
        raise ValueError(f"mesh {mesh.name}: expected colours of its vertices, found none")
    middle = np.argsort(mesh.colours[mesh.faces].mean(2), axis=1, kind="stable")[:, 1]
    faces = np.take_along_axis(mesh.faces, (middle[:, None] + np.arange(3)) % 3, axis=1)
    index = faces.ravel()
    a, b, c = (mesh.colours[faces[:, k]] for k in range(3))
    across = max(1, math.ceil(math.sqrt(len(mesh.faces))))
    rows = math.ceil(len(mesh.faces) / across)
    row, column = np.divmod(np.arange(len(mesh.faces)), across)
    pixels = np.zeros((2 * rows, 2 * across, 3), np.float32)
    for (down, right), colour in (((0, 0), a), ((0, 1), b), ((1, 0), c), ((1, 1), np.clip(b + c - a, 0.0, 1.0))):
        pixels[2 * row + down, 2 * column + right] = colour
    corner = np.stack([2 * column, 2 * row], 1)[:, None] + np.array([[0, 0], [1, 0], [0, 1]]) + 0.5
    uv = (corner / [2 * across, 2 * rows]).reshape(-1, 2)
    normals = None if mesh.normals is None else mesh.normals[index]
    return Mesh(mesh.name, mesh.vertices[index], np.arange(len(index)).reshape(-1, 3), normals, uv), pixels
