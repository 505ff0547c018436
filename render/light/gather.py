"""The light that arrives at every node, caustics included: paths that start at the surfaces.

A path starts at a random point near its node, with the interpolation's own weight (a node is the mean of the surface
that it stands for), looks at one lamp, and goes on along one direction drawn by the cosine, as the path tracer does it.
"""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from ...procedural.surroundings.colour import luminance
from ..pictures.integrator import SHADOW_EPSILON, Start, trace
from ..pictures.sampler import Samples, four, samples
from ..rays import leave
from ..scene.kernel import Kernel
from ..scene.spectrum import draw_wavelengths
from .lobes import schlick
from .nodes import Nodes
from .stored import MOMENTS, StoredLight

#: Paths traced at a time. Each holds 52 bytes of results.
PATHS_PER_PASS = 1 << 21
#: Paths of a group; the spread of a node's groups tells its variance.
GROUP = 16


def gather_light(kernel: Kernel, nodes: Nodes, groups: int, seed: int) -> StoredLight:
    """Return the light that arrives at the nodes.

    Parameters
    ----------
    kernel : Kernel
        The scene, loaded with cut meshes.
    nodes : Nodes
        Where it is wanted.
    groups : int
        Groups of paths for every node.
    seed : int
        32-bit seed.
    """
    starts = Starts(nodes)
    counts = np.full(nodes.count, groups, np.int64)
    total, square, done = np.zeros((nodes.count, MOMENTS)), np.zeros(nodes.count), np.zeros(nodes.count, np.int64)
    _add_groups(kernel, starts, counts, seed, total, square, done)
    return _mean(nodes, total, square, done)


def _add_groups(kernel: Kernel, starts: Starts, counts: np.ndarray, seed: int, total, square, done) -> None:
    node = np.repeat(np.arange(len(counts), dtype=np.uint32), counts)
    rank = np.arange(len(node)) - np.repeat(np.cumsum(counts) - counts, counts)
    index = ((done[node] + rank) * GROUP).astype(np.uint32)
    share = PATHS_PER_PASS // GROUP
    for first in range(0, len(node), share):
        some = slice(first, first + share)
        sums = _one_pass(kernel, starts, node[some], index[some], seed)
        for k in range(MOMENTS):
            total[:, k] += np.bincount(node[some], sums[k], len(counts))
        square += np.bincount(node[some], sums[:3].mean(0) ** 2, len(counts))
    done += counts


def _mean(nodes: Nodes, total: np.ndarray, square: np.ndarray, done: np.ndarray) -> StoredLight:
    n = done.astype(np.float64)
    moments = total / (n * GROUP)[:, None]
    level = moments[:, :3].mean(1)
    spread = np.maximum(square / (n * GROUP**2) - level**2, 0.0)
    variance = spread / np.maximum(n - 1.0, 1.0)
    # First moments are kept as mean directions.
    for colour, vector in ((slice(0, 3), slice(6, 9)), (slice(3, 6), slice(9, 12))):
        weight = luminance(moments[:, colour])[:, None]
        moments[:, vector] = np.divide(moments[:, vector], weight, out=np.zeros_like(moments[:, vector]), where=weight > 0)
    return StoredLight(nodes, moments.astype(np.float32), variance, done * GROUP)


class Starts:
    """The nodes as Dr.Jit arrays, with the triangles round every vertex."""

    def __init__(self, nodes: Nodes) -> None:
        x, y = nodes.axes
        places = [axis.coordinate(np.arange(-1, axis.lines + 1)) for axis in (x, y)]
        self.lines_x, self.grid_count = mi.UInt32(x.lines), mi.UInt32(nodes.grid_count)
        # Lines beyond the first and the last stand in for themselves.
        self.x, self.y = (mi.Float(np.clip(p, a.low, None).astype(np.float32)) for p, a in zip(places, (x, y), strict=True))
        self.positions, self.normals = mi.Float(nodes.positions.ravel()), mi.Float(nodes.normals.ravel())
        first, around = _triangles_round(nodes)
        self.first, self.around = mi.UInt32(first), mi.UInt32(around)
        self.triangles = mi.UInt32(nodes.triangles.ravel())
        self.back = mi.Bool(nodes.back)
        self.to_front = mi.UInt32(_to_front(nodes))
        dr.make_opaque(self.lines_x, self.grid_count, self.x, self.y, self.positions, self.normals)
        dr.make_opaque(self.first, self.around, self.triangles, self.back, self.to_front)


def _to_front(nodes: Nodes) -> np.ndarray:
    """Return for every vertex how far before it its front stands (0 for fronts)."""
    away = np.zeros(len(nodes.positions), np.uint32)
    if nodes.back.any():
        edges = np.flatnonzero(np.diff(nodes.back.astype(np.int8), prepend=0, append=0))
        for begin, end in edges.reshape(-1, 2):
            away[begin:end] = end - begin
    return away


def _triangles_round(nodes: Nodes) -> tuple[np.ndarray, np.ndarray]:
    """Return for every vertex where its corners begin, and all corners (3 * triangle + k), sorted by vertex."""
    corners = nodes.triangles.ravel()
    order = np.argsort(corners, kind="stable").astype(np.uint32)
    counts = np.bincount(corners, minlength=len(nodes.positions))
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.uint32), order


def _one_pass(kernel: Kernel, starts: Starts, node: np.ndarray, index: np.ndarray, seed: int) -> np.ndarray:
    """Return the sums of the moments over each group, (12, groups) float64."""
    lane = dr.arange(mi.UInt32, len(node) * GROUP)
    group = lane // GROUP
    at, first = (dr.gather(mi.UInt32, mi.UInt32(values), group) for values in (node, index))
    points = samples(at, first + lane % GROUP, 1 << 14, seed)
    values = _arriving(kernel, starts, at, points)
    dr.eval(values)
    return np.stack([np.array(dr.block_sum(value, GROUP), np.float64) for value in values])


def _arriving(kernel: Kernel, starts: Starts, at: mi.UInt32, points: Samples) -> list[mi.Float]:
    scene, offset = kernel.mi_scene, dr.opaque(mi.Float, kernel.offset)
    p, n, ns = _start(starts, at, points)
    si = dr.zeros(mi.SurfaceInteraction3f, dr.width(at))
    si.p, si.n, frame = p, n, mi.Frame3f(ns)
    wavelengths, weight = draw_wavelengths(mi.Float(0.5))
    si.wavelengths = wavelengths
    a, b, c, d = four(points, mi.UInt32(1))

    ds, lamp = scene.sample_emitter_direction(si, mi.Point2f(a, b), False)
    cos = dr.dot(ns, ds.d)
    lit = (ds.pdf > 0.0) & (cos > 0.0) & (dr.dot(n, ds.d) > 0.0) & dr.any(lamp > 0.0)
    shadow = leave(si, ds.d, offset)
    shadow.maxt = ds.dist * (1.0 - SHADOW_EPSILON)
    lit &= ~scene.ray_test(shadow, False, lit)
    share = dr.select(ds.delta, 1.0, ds.pdf / (ds.pdf + cos * dr.inv_pi))
    near = dr.select(lit, share * cos * lamp, 0.0)

    local = mi.warp.square_to_cosine_hemisphere(mi.Point2f(c, d))
    direction = frame.to_world(local)
    out = (dr.dot(n, direction) > 0.0) & (local.z > 0.0)
    ray = leave(si, direction, offset)
    far = trace(kernel, ray, weight, points, kernel.description.picture, start=Start(si, local.z * dr.inv_pi)).radiance
    far = dr.select(out, far * dr.pi, 0.0)
    f_near, f_far = schlick(cos), schlick(local.z)
    level = mi.luminance(near), mi.luminance(far)
    towards = level[0] * ds.d + level[1] * direction
    towards_f = level[0] * f_near * ds.d + level[1] * f_far * direction
    return [*(near + far), *(f_near * near + f_far * far), *towards, *towards_f]


def _start(starts: Starts, at: mi.UInt32, points: Samples) -> tuple[mi.Point3f, mi.Normal3f, mi.Normal3f]:
    """Return a random point of the surface round each node, its geometric and its shading normal."""
    a, b, c, _ = four(points, mi.UInt32(0))
    grid = at < starts.grid_count
    j = at // starts.lines_x
    i = at - j * starts.lines_x
    x, y = _near(starts.x, i, a, grid), _near(starts.y, j, b, grid)

    vertex = dr.select(grid, 0, at - starts.grid_count)
    away = dr.gather(mi.UInt32, starts.to_front, vertex, ~grid)
    front = vertex - away
    first, end = (dr.gather(mi.UInt32, starts.first, front + k, ~grid) for k in range(2))
    pick = dr.minimum(mi.UInt32(mi.Float(end - first) * c), dr.maximum(end - first, 1) - 1)
    corner = dr.gather(mi.UInt32, starts.around, first + pick, ~grid & (end > first))
    triangle, k = corner // 3, corner % 3
    ids = [dr.gather(mi.UInt32, starts.triangles, 3 * triangle + (k + m) % 3, ~grid) for m in range(3)]
    # Uniform on the half of the triangle that is nearest to the corner, as far as weights go: see `_corner_weights`.
    u, v, w = _corner_weights(a, b)
    P = [dr.gather(mi.Point3f, starts.positions, index, ~grid) for index in ids]
    N = [dr.gather(mi.Normal3f, starts.normals, index + away, ~grid) for index in ids]
    p, ns = u * P[0] + v * P[1] + w * P[2], dr.normalize(u * N[0] + v * N[1] + w * N[2])
    n = dr.normalize(mi.Normal3f(dr.cross(P[1] - P[0], P[2] - P[0])))
    n = dr.select(dr.gather(mi.Bool, starts.back, vertex, ~grid), -n, n)
    up = mi.Normal3f(0.0, 0.0, 1.0)
    return dr.select(grid, mi.Point3f(x, y, 0.0), p), dr.select(grid, up, n), dr.select(grid, up, ns)


def _near(lines: mi.Float, k: mi.UInt32, sample: mi.Float, active: mi.Bool) -> mi.Float:
    """Return a coordinate in the cell round a line, half-way to its neighbours."""
    before, here, after = (dr.gather(mi.Float, lines, k + m, active) for m in range(3))
    t = 2.0 * sample - 1.0
    return here + 0.5 * dr.select(t < 0.0, t * (here - before), t * (after - here))


def _corner_weights(a: mi.Float, b: mi.Float) -> tuple[mi.Float, mi.Float, mi.Float]:
    """Return barycentric weights of a uniform point of the part of a triangle that is nearest to the first corner.

    That part is the quadrilateral of corner, both middles of its edges, and the centroid: a third of the triangle.
    """
    # Uniform points of the triangle, turned so that the first weight is the largest, are uniform on that part.
    root = dr.sqrt(a)
    x, y = 1.0 - root, root * (1.0 - b)
    z = 1.0 - x - y
    largest = dr.maximum(dr.maximum(x, y), z)
    first = dr.select(x == largest, 0, dr.select(y == largest, 1, 2))
    u = largest
    v = dr.select(first == 0, y, dr.select(first == 1, z, x))
    return u, v, 1.0 - u - v
