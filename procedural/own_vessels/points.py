"""Solids from points on a surface, as scans and sets of keypoints give them, without faces.

The surface is the points' alpha shape (Edelsbrunner and Mücke 1994, "Three-dimensional alpha shapes", ACM Transactions
on Graphics 13(1)): triangles between neighbours. What it closes off is solid; where it is a single sheet it gets a
thickness.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.ndimage import distance_transform_edt, gaussian_filter, label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay, cKDTree

from ...core.errors import InputError
from ..cavities.wall import spread

#: Most points [1]: beyond it a file has faces, or a program that makes them.
MOST_POINTS = 100_000
#: Largest circumradius of a triangle between neighbours, in distances of neighbours (their quantile of 0.95) [1]:
#: points as evenly apart as a Poisson disc leave no larger gap.
_ALPHA, _QUANTILE = 1.6, 0.95
#: Edges of the grid in which the surface is sought, in thicknesses [1], and the fewest along the longest side.
_CELL, _CELLS = 0.4, 100
#: Distances are known this far beyond the surface of a sheet [cells]: what blurring and interpolation look at.
_MARGIN = 3.0
#: Smoothing of the distances [cells], and passes, factors of the mesh's (Taubin 1995, "A signal processing approach to
#: fair surface design", SIGGRAPH '95).
_BLUR, _PASSES, _SHRINK, _GROW = 0.7, 12, 0.5, -0.53


def solid_of_points(path: Path, points: np.ndarray, thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices and faces of a solid whose surface is half a thickness outside of the points.

    Parameters
    ----------
    path : Path
        The file, for the error line.
    points : (n, 3) float64
        Points on a surface, about evenly apart [m]. Groups away from the largest one are left out.
    thickness : float
        Of single sheets [m].

    Raises
    ------
    InputError
        Where there are too few or too many points, or they are no surface.
    """
    import manifold3d

    points = np.unique(points, axis=0)
    if not 50 <= len(points) <= MOST_POINTS:
        raise InputError(path, f"50 to {MOST_POINTS:,} points on a surface, or faces", f"{len(points):,} points")
    triangles, mesh, enclosed = _alpha_shape(points)
    if not len(triangles):
        raise InputError(path, "points on a surface", "points that are no neighbours")
    corners = mesh.points[triangles]
    low, high = corners.min((0, 1)) - 2.0 * thickness, corners.max((0, 1)) + 2.0 * thickness
    cell = min(_CELL * thickness, float((high - low).max()) / _CELLS)
    axes = [np.arange(a, b + cell, cell) for a, b in zip(low, high, strict=True)]
    field = _distances(corners, mesh, enclosed, axes, thickness)
    made = manifold3d.Manifold.level_set(
        _sampled(gaussian_filter(field, _BLUR), low, cell), [*low, *high], 1.5 * cell, -0.5 * thickness
    ).to_mesh()
    vertices, faces = np.asarray(made.vert_properties, np.float64)[:, :3], np.asarray(made.tri_verts, np.int64)
    return _smoothed(vertices, faces), faces


def _alpha_shape(points: np.ndarray) -> tuple[np.ndarray, Delaunay, np.ndarray]:
    """Return the triangles between neighbours, the tetrahedra, and which of these are closed off, (k,) bool."""
    near = cKDTree(points).query(points, 2)[0][:, 1]
    mesh = Delaunay(points)
    tetrahedra, others = mesh.simplices, mesh.neighbors
    # Facet k is across from corner k.
    facets = np.stack([np.delete(tetrahedra, k, axis=1) for k in range(4)], axis=1)
    small = _circumradius(points[facets]) <= _ALPHA * np.quantile(near, _QUANTILE)
    count = len(tetrahedra)
    one, other = np.repeat(np.arange(count), 4), np.where(others < 0, count, others).ravel()
    passed = ~small.ravel()
    graph = coo_array((np.ones(passed.sum()), (one[passed], other[passed])), shape=(count + 1, count + 1))
    _, region = connected_components(graph, directed=False)
    enclosed = region[:-1] != region[-1]
    beyond = np.append(enclosed, False)[other].reshape(-1, 4)
    kept = small & (~(enclosed[:, None] & beyond))
    triangles = np.unique(np.sort(facets[kept], axis=1), axis=0)
    a, b = np.concatenate([triangles[:, :2], triangles[:, 1:]]).T
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(points), len(points)))
    _, group = connected_components(graph, directed=False)
    largest = np.bincount(group).argmax()
    return triangles[group[triangles[:, 0]] == largest], mesh, enclosed


def _circumradius(corners: np.ndarray) -> np.ndarray:
    """Return the radii of the circles through triangles (..., 3, 3): a b c / (4 area)."""
    sides = [corners[..., i, :] - corners[..., j, :] for i, j in ((0, 1), (1, 2), (2, 0))]
    a, b, c = (np.linalg.norm(side, axis=-1) for side in sides)
    area2 = np.linalg.norm(np.cross(sides[0], sides[1]), axis=-1)
    return a * b * c / np.maximum(2.0 * area2, np.finfo(float).tiny)


def _distances(
    corners: np.ndarray, mesh: Delaunay, enclosed: np.ndarray, axes: list[np.ndarray], thickness: float
) -> np.ndarray:
    """Return the distance from the surface at the points of a grid, positive in the solid, near the surface [m]."""
    cell = axes[0][1] - axes[0][0]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    samples, _ = spread(corners, int(4.0 * area / cell**2) + 1000)
    reach = 0.5 * thickness + _MARGIN * cell
    filled = np.zeros(grid.shape[:-1], dtype=bool)
    filled[tuple(np.rint((samples - grid[0, 0, 0]) / cell).astype(int).T)] = True
    near = distance_transform_edt(~filled) * cell <= reach + cell
    away = np.full(near.shape, reach)
    away[near] = np.minimum(cKDTree(samples).query(grid[near], distance_upper_bound=reach)[0], reach)
    inside = np.zeros(near.shape, dtype=bool)
    inside[near] = _inside(mesh, enclosed, grid[near])
    # Far from the surface a whole region is on one side of it.
    region, count = label(~near)
    first = np.unique(region, return_index=True)[1][-count:]
    inside |= np.append(False, _inside(mesh, enclosed, grid.reshape(-1, 3)[first]))[region]
    return np.where(inside, away, -away)


def _inside(mesh: Delaunay, enclosed: np.ndarray, points: np.ndarray) -> np.ndarray:
    place = mesh.find_simplex(points)
    return (place >= 0) & enclosed[place]


def _sampled(field: np.ndarray, low: np.ndarray, cell: float) -> Callable[[float, float, float], float]:
    """Return the field between grid points, by trilinear interpolation, for one point at a time."""
    nx, ny, nz = (size - 2 for size in field.shape)
    values, (x0, y0, z0) = memoryview(np.ascontiguousarray(field).data), low.tolist()

    def at(x: float, y: float, z: float) -> float:
        u, v, w = (x - x0) / cell, (y - y0) / cell, (z - z0) / cell
        i, j, k = min(max(int(u), 0), nx), min(max(int(v), 0), ny), min(max(int(w), 0), nz)
        u, v, w = u - i, v - j, w - k
        low_side = (values[i, j, k] * (1 - u) + values[i + 1, j, k] * u) * (1 - v) + (
            values[i, j + 1, k] * (1 - u) + values[i + 1, j + 1, k] * u
        ) * v
        high_side = (values[i, j, k + 1] * (1 - u) + values[i + 1, j, k + 1] * u) * (1 - v) + (
            values[i, j + 1, k + 1] * (1 - u) + values[i + 1, j + 1, k + 1] * u
        ) * v
        return low_side * (1 - w) + high_side * w

    return at


def _smoothed(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b = np.concatenate([faces[:, :2], faces[:, 1:], faces[:, [2, 0]]]).T
    count = len(vertices)
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(count, count)).tocsr()
    weight = 1.0 / np.maximum(np.asarray(graph.sum(axis=1)).reshape(-1, 1), 1.0)
    for _ in range(_PASSES):
        for factor in (_SHRINK, _GROW):
            vertices = vertices + factor * (weight * (graph @ vertices) - vertices)
    return vertices
