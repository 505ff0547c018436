"""Sampling of the surface around cache points: where the paths start that estimate their irradiance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._mitsuba import dr, mi
from ..pictures.sampler import SobolSampler, sample_4d
from .cache_points import CachePoints, to_front


@dataclass(frozen=True, eq=False)
class PointSampler:
    """The cache points as opaque Dr.Jit arrays, with the triangles of every vertex."""

    lines_x: mi.UInt32
    grid_count: mi.UInt32
    x: mi.Float  #: coordinates of the grid's lines [m]; the first and the last are repeated
    y: mi.Float
    positions: mi.Float
    normals: mi.Float
    first: mi.UInt32  #: by vertex: its first entry in `corners`
    corners: mi.UInt32  #: triangle corners (3 * triangle + k), sorted by vertex
    triangles: mi.UInt32
    back: mi.Bool  #: by vertex
    to_front: mi.UInt32  #: by vertex: offset back to the same vertex of the front side


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Random points on surfaces, world frame."""

    p: mi.Point3f  #: [m]
    n: mi.Normal3f  #: geometric normal on the side of the cache point
    ns: mi.Normal3f  #: shading normal
    valid: mi.Bool  #: False for vertices without triangles, which are never read, and on triangles without area


def point_sampler(points: CachePoints) -> PointSampler:
    """Return the arrays that `sample_points` reads."""
    x, y = (np.pad(a.coordinate(np.arange(a.lines)), 1, mode="edge").astype(np.float32) for a in points.axes)
    first, corners = _corners_by_vertex(points)
    result = PointSampler(
        lines_x=mi.UInt32(points.axes[0].lines),
        grid_count=mi.UInt32(points.grid_count),
        x=mi.Float(x),
        y=mi.Float(y),
        positions=mi.Float(points.positions.ravel()),
        normals=mi.Float(points.normals.ravel()),
        first=mi.UInt32(first),
        corners=mi.UInt32(corners),
        triangles=mi.UInt32(points.triangles.ravel()),
        back=mi.Bool(points.back),
        to_front=mi.UInt32(to_front(points)),
    )
    for name in PointSampler.__dataclass_fields__:
        dr.make_opaque(getattr(result, name))
    return result


def _corners_by_vertex(points: CachePoints) -> tuple[np.ndarray, np.ndarray]:
    corners = points.triangles.ravel()
    counts = np.bincount(corners, minlength=len(points.positions))
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.uint32)
    return first, np.argsort(corners, kind="stable").astype(np.uint32)


def sample_points(origins: PointSampler, index: mi.UInt32, sampler: SobolSampler) -> SurfacePoints:
    """Sample a point of the surface area that each cache point represents.

    On the grid that is the cell around it, half-way to the neighbouring lines; on a mesh the third of each of the
    vertex's triangles that is nearest to it.
    """
    a, b, c, _ = sample_4d(sampler, mi.UInt32(0))
    grid = index < origins.grid_count
    j = index // origins.lines_x
    x, y = _near_line(origins.x, index - j * origins.lines_x, a, grid), _near_line(origins.y, j, b, grid)
    vertex = dr.select(grid, 0, index - origins.grid_count)
    on_mesh = _sample_mesh(origins, vertex, (a, b, c), ~grid)
    up = mi.Normal3f(0.0, 0.0, 1.0)
    return SurfacePoints(
        p=dr.select(grid, mi.Point3f(x, y, 0.0), on_mesh.p),
        n=dr.select(grid, up, on_mesh.n),
        ns=dr.select(grid, up, on_mesh.ns),
        valid=grid | on_mesh.valid,
    )


def _near_line(lines: mi.Float, k: mi.UInt32, sample: mi.Float, active: mi.Bool) -> mi.Float:
    """Return a random coordinate between the middles of the cells on both sides of line k."""
    before, here, after = (dr.gather(mi.Float, lines, k + m, active) for m in range(3))
    t = sample - 0.5
    return here + dr.select(t < 0.0, t * (here - before), t * (after - here))


def _sample_mesh(
    origins: PointSampler, vertex: mi.UInt32, sample: tuple[mi.Float, mi.Float, mi.Float], active: mi.Bool
) -> SurfacePoints:
    to_back = dr.gather(mi.UInt32, origins.to_front, vertex, active)
    first, end = (dr.gather(mi.UInt32, origins.first, vertex - to_back + k, active) for k in range(2))
    valid = active & (end > first)
    pick = dr.minimum(mi.UInt32(mi.Float(end - first) * sample[2]), dr.maximum(end - first, 1) - 1)
    corner = dr.gather(mi.UInt32, origins.corners, first + pick, valid)
    triangle, k = corner // 3, corner % 3
    ids = [dr.gather(mi.UInt32, origins.triangles, 3 * triangle + (k + m) % 3, valid) for m in range(3)]
    weights = _corner_weights(sample[0], sample[1])
    P = [dr.gather(mi.Point3f, origins.positions, index, valid) for index in ids]
    N = [dr.gather(mi.Normal3f, origins.normals, index + to_back, valid) for index in ids]
    p = weights[0] * P[0] + weights[1] * P[1] + weights[2] * P[2]
    ns = weights[0] * N[0] + weights[1] * N[1] + weights[2] * N[2]
    across = dr.cross(P[1] - P[0], P[2] - P[0])
    valid &= (dr.squared_norm(across) > 0.0) & (dr.squared_norm(ns) > 0.0)
    up = mi.Normal3f(0.0, 0.0, 1.0)
    n, ns = (dr.select(valid, dr.normalize(mi.Normal3f(x)), up) for x in (across, ns))
    sign = dr.select(dr.gather(mi.Bool, origins.back, vertex, active), mi.Float(-1.0), mi.Float(1.0))
    return SurfacePoints(p, sign * n, ns, valid)


def _corner_weights(a: mi.Float, b: mi.Float) -> tuple[mi.Float, mi.Float, mi.Float]:
    """Return barycentric weights of a uniform point on the third of a triangle that is nearest to its first corner.

    A uniform point on the whole triangle, rotated so that its largest weight comes first, is uniform on that third.
    """
    root = dr.sqrt(a)
    x, y = 1.0 - root, root * (1.0 - b)
    z = 1.0 - x - y
    largest = dr.maximum(dr.maximum(x, y), z)
    second = dr.select(largest == x, y, dr.select(largest == y, z, x))
    return largest, second, 1.0 - largest - second
