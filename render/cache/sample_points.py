"""Where the paths start that find the light of a node: random points of the surface round it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._mitsuba import dr, mi
from ..pictures.sampler import Samples, four
from .cache_points import Nodes, to_front


@dataclass(frozen=True, eq=False)
class Starts:
    """The nodes as opaque Dr.Jit arrays, with the triangles round every vertex."""

    lines_x: mi.UInt32
    grid_count: mi.UInt32
    x: mi.Float  #: coordinates of the grid's lines [m], with the first and the last one twice
    y: mi.Float
    positions: mi.Float
    normals: mi.Float
    first: mi.UInt32  #: by vertex: where its corners begin
    around: mi.UInt32  #: corners (3 * triangle + k), sorted by vertex
    triangles: mi.UInt32
    back: mi.Bool  #: by vertex
    to_front: mi.UInt32  #: by vertex: how far before it the same vertex of the front stands


def starts_of(nodes: Nodes) -> Starts:
    """Return what `start_points` reads."""
    x, y = (np.pad(a.coordinate(np.arange(a.lines)), 1, mode="edge").astype(np.float32) for a in nodes.axes)
    first, around = _corners_round(nodes)
    result = Starts(
        lines_x=mi.UInt32(nodes.axes[0].lines),
        grid_count=mi.UInt32(nodes.grid_count),
        x=mi.Float(x),
        y=mi.Float(y),
        positions=mi.Float(nodes.positions.ravel()),
        normals=mi.Float(nodes.normals.ravel()),
        first=mi.UInt32(first),
        around=mi.UInt32(around),
        triangles=mi.UInt32(nodes.triangles.ravel()),
        back=mi.Bool(nodes.back),
        to_front=mi.UInt32(to_front(nodes)),
    )
    for name in Starts.__dataclass_fields__:
        dr.make_opaque(getattr(result, name))
    return result


def _corners_round(nodes: Nodes) -> tuple[np.ndarray, np.ndarray]:
    corners = nodes.triangles.ravel()
    counts = np.bincount(corners, minlength=len(nodes.positions))
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.uint32)
    return first, np.argsort(corners, kind="stable").astype(np.uint32)


def start_points(
    starts: Starts, node: mi.UInt32, points: Samples
) -> tuple[mi.Point3f, mi.Normal3f, mi.Normal3f, mi.Bool]:
    """Return a random point of the surface that each node stands for.

    On the grid that is its cell, half-way to the neighbouring lines; on a mesh, of a triangle round the vertex the
    third that lies nearest to it.

    Returns
    -------
    p : mi.Point3f
        The point, world [m].
    n, ns : mi.Normal3f
        Its geometric and its shading normal, on the side that the node's light is for.
    known : mi.Bool
        False for vertices of no triangle, which nothing ever reads, and on triangles without area.
    """
    a, b, c, _ = four(points, mi.UInt32(0))
    grid = node < starts.grid_count
    j = node // starts.lines_x
    x, y = _near(starts.x, node - j * starts.lines_x, a, grid), _near(starts.y, j, b, grid)
    vertex = dr.select(grid, 0, node - starts.grid_count)
    p, n, ns, known = _on_mesh(starts, vertex, (a, b, c), ~grid)
    up = mi.Normal3f(0.0, 0.0, 1.0)
    return dr.select(grid, mi.Point3f(x, y, 0.0), p), dr.select(grid, up, n), dr.select(grid, up, ns), grid | known


def _near(lines: mi.Float, k: mi.UInt32, sample: mi.Float, active: mi.Bool) -> mi.Float:
    before, here, after = (dr.gather(mi.Float, lines, k + m, active) for m in range(3))
    t = sample - 0.5
    return here + dr.select(t < 0.0, t * (here - before), t * (after - here))


def _on_mesh(
    starts: Starts, vertex: mi.UInt32, sample: tuple[mi.Float, mi.Float, mi.Float], active: mi.Bool
) -> tuple[mi.Point3f, mi.Normal3f, mi.Normal3f, mi.Bool]:
    away = dr.gather(mi.UInt32, starts.to_front, vertex, active)
    first, end = (dr.gather(mi.UInt32, starts.first, vertex - away + k, active) for k in range(2))
    known = active & (end > first)
    pick = dr.minimum(mi.UInt32(mi.Float(end - first) * sample[2]), dr.maximum(end - first, 1) - 1)
    corner = dr.gather(mi.UInt32, starts.around, first + pick, known)
    triangle, k = corner // 3, corner % 3
    ids = [dr.gather(mi.UInt32, starts.triangles, 3 * triangle + (k + m) % 3, known) for m in range(3)]
    weights = _corner_weights(sample[0], sample[1])
    P = [dr.gather(mi.Point3f, starts.positions, index, known) for index in ids]
    N = [dr.gather(mi.Normal3f, starts.normals, index + away, known) for index in ids]
    p = weights[0] * P[0] + weights[1] * P[1] + weights[2] * P[2]
    ns = weights[0] * N[0] + weights[1] * N[1] + weights[2] * N[2]
    across = dr.cross(P[1] - P[0], P[2] - P[0])
    known &= (dr.squared_norm(across) > 0.0) & (dr.squared_norm(ns) > 0.0)
    up = mi.Normal3f(0.0, 0.0, 1.0)
    n, ns = (dr.select(known, dr.normalize(mi.Normal3f(x)), up) for x in (across, ns))
    sign = dr.select(dr.gather(mi.Bool, starts.back, vertex, active), mi.Float(-1.0), mi.Float(1.0))
    return p, sign * n, ns, known


def _corner_weights(a: mi.Float, b: mi.Float) -> tuple[mi.Float, mi.Float, mi.Float]:
    """Return barycentric weights of a uniform point of the third of a triangle that is nearest to its first corner.

    A uniform point of the whole triangle, turned so that its largest weight comes first, is uniform on that third.
    """
    root = dr.sqrt(a)
    x, y = 1.0 - root, root * (1.0 - b)
    z = 1.0 - x - y
    largest = dr.maximum(dr.maximum(x, y), z)
    second = dr.select(largest == x, y, dr.select(largest == y, z, x))
    return largest, second, 1.0 - largest - second
