"""Shading normals of a triangle surface, split at creases."""

from __future__ import annotations

import numpy as np

#: Faces that meet at a larger angle keep an edge between them [rad]. 40 degrees lies between the 30 degrees of a
#: coarse (12-sided) cylinder and the 45 degrees of a bevel.
CREASE = np.radians(40.0)


def creased(
    vertices: np.ndarray, faces: np.ndarray, uv: np.ndarray | None = None, crease: float = CREASE
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
    """Return a surface with shading normals: smooth where it bends little, split at creases.

    Around each position, faces that share an edge there and meet at `crease` or less form one fan, and a fan has one
    normal: the mean of its faces' normals weighted by area, so that a large flat face stays flat beside a bevel.

    Parameters
    ----------
    vertices : (n, 3) float
        Positions; equal positions are welded.
    faces : (m, 3) int
        Indices into `vertices`.
    uv : (n, 2) float, optional
        Texture coordinates of the vertices.
    crease : float
        Largest angle between the normals of two faces of one fan [rad].

    Returns
    -------
    (k, 3) float, (m, 3) int, (k, 3) float, (k, 2) float or None
        Vertices, faces in the same order, unit normals, texture coordinates.
    """
    import trimesh  # here, as it takes half a second to load

    welded, position = np.unique(vertices, axis=0, return_inverse=True)
    position = position.reshape(-1)[faces]
    cross = np.cross(welded[position[:, 1]] - welded[position[:, 0]], welded[position[:, 2]] - welded[position[:, 0]])
    links = _corner_links(position, _unit(cross), np.cos(crease))
    fan = trimesh.graph.connected_component_labels(links, node_count=faces.size)
    sums = np.zeros((fan.max() + 1, 3))
    np.add.at(sums, fan, np.repeat(cross, 3, axis=0))
    normal = _unit(sums)
    pairs, corner = np.unique(np.stack([fan, faces.reshape(-1)], 1), axis=0, return_inverse=True)
    kept_uv = None if uv is None else uv[pairs[:, 1]]
    return vertices[pairs[:, 1]], corner.reshape(-1, 3), normal[pairs[:, 0]], kept_uv


def _corner_links(position: np.ndarray, face_normal: np.ndarray, least_cosine: float) -> np.ndarray:
    """Return pairs of corners (3 * face + place) that belong to one fan, (k, 2) int."""
    count = len(position)
    start = np.arange(3 * count)
    end = start - start % 3 + (start + 1) % 3
    ends = position.reshape(-1)
    swap = ends[start] > ends[end]
    low, high = np.where(swap, end, start), np.where(swap, start, end)
    order = np.lexsort((ends[high], ends[low]))
    low, high = low[order], high[order]
    # Equal edges are neighbours after sorting; three or more faces at an edge are linked in a chain.
    same = (ends[low[1:]] == ends[low[:-1]]) & (ends[high[1:]] == ends[high[:-1]])
    cosine = np.sum(face_normal[low[1:] // 3] * face_normal[low[:-1] // 3], axis=1)
    linked = np.flatnonzero(same & (cosine >= least_cosine))
    return np.concatenate(
        [np.stack([low[linked], low[linked + 1]], 1), np.stack([high[linked], high[linked + 1]], 1)]
    ).reshape(-1, 2)


def _unit(vectors: np.ndarray) -> np.ndarray:
    """Return unit vectors; +z replaces vectors of length 0 (of slivers and of fans folded flat)."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    vanishing = length[:, 0] <= np.finfo(float).tiny
    unit = vectors / np.where(vanishing[:, None], 1.0, length)
    unit[vanishing] = (0.0, 0.0, 1.0)
    return unit
