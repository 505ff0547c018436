"""The light that arrives at every node, caustics included: paths that start at the surfaces.

A path starts at a random point of the surface that its node stands for, looks at one lamp, and goes on along one
direction drawn by the cosine, as the path tracer does it. A few paths of every node tell where the light is uncertain;
they are then thrown away (means of samples that decided their own number would be too low), and the others go there.
"""

from __future__ import annotations

import cv2
import numpy as np

from ...procedural.surroundings.colour import luminance
from .._mitsuba import dr, mi
from ..pictures.integrator import Start, trace, unshadowed
from ..pictures.sampler import Samples, four, samples
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.spectrum import draw_wavelengths
from .cache_points import Nodes, vertex_areas
from .grid_filter import smoothed
from .irradiance_cache import MOMENTS, StoredLight
from .lobes import schlick
from .mesh_filter import smoothed_meshes
from .sample_points import Starts, start_points, starts_of

#: Paths traced at a time. Each holds 48 bytes of results, so a pass stays near 100 MB.
PATHS_PER_PASS = 1 << 21
#: Paths of a group. The spread of a node's groups tells its variance.
GROUP = 4
#: Groups of the pilot; fewest and most groups of a node, over the average.
_PILOT, _LEAST, _MOST = 2, 0.25, 8.0
#: Error counts relative to a node's light plus this share of the mean light, so that the dark does not get it all.
_FLOOR = 0.1
#: Side of the square that the pilot's estimates are averaged over on the grid: two groups alone know little.
_SMOOTH = 9
#: First sample numbers of the pilot's paths, which the others never reach.
_PILOT_INDEX = 1 << 20


def gather_light(kernel: LoadedScene, nodes: Nodes, paths: int, seed: int) -> StoredLight:
    """Return the light that arrives at the nodes.

    Parameters
    ----------
    kernel : LoadedScene
        The scene, loaded with cut meshes.
    nodes : Nodes
        Where it is wanted.
    paths : int
        Paths of a node, on the average; at least two groups are taken of every one.
    seed : int
        32-bit seed.
    """
    starts, groups = starts_of(nodes), max(2.0, paths / GROUP)
    *pilot, _ = _gathered(kernel, starts, np.full(nodes.count, _PILOT), _PILOT_INDEX, seed)
    counts = _shared_out(nodes, *_level_and_variance(*pilot), groups)
    total, _, _, odd = _gathered(kernel, starts, counts, 0, seed)
    grid, half = nodes.grid_count, (0.5 * counts * GROUP)[:, None]
    halves = (total - odd)[grid:] / half[grid:], odd[grid:] / half[grid:]
    moments = np.concatenate([total[:grid] / (2.0 * half[:grid]), smoothed_meshes(nodes, halves)])
    for colour, vector in ((slice(0, 3), slice(6, 9)), (slice(3, 6), slice(9, 12))):  # sums become mean directions
        weight, sums = luminance(moments[:, colour])[:, None], moments[:, vector]
        moments[:, vector] = np.divide(sums, weight, out=np.zeros_like(sums), where=weight > 0.0)
    moments = moments.astype(np.float32)
    moments[:grid] = smoothed(moments[:grid], (nodes.axes[1].lines, nodes.axes[0].lines))
    return StoredLight(nodes, moments, counts * GROUP)


def _gathered(
    kernel: LoadedScene, starts: Starts, counts: np.ndarray, first: int, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Trace groups of every node.

    Returns sums of moments, squared sums of the groups' light, the counts, and sums of moments of every other group.
    """
    total, odd, square = np.zeros((len(counts), MOMENTS)), np.zeros((len(counts), MOMENTS)), np.zeros(len(counts))
    node = np.repeat(np.arange(len(counts), dtype=np.uint32), counts)
    rank = np.arange(len(node)) - np.repeat(np.cumsum(counts) - counts, counts)
    index, share = (first + rank * GROUP).astype(np.uint32), PATHS_PER_PASS // GROUP
    for begin in range(0, len(node), share):
        some = slice(begin, begin + share)
        sums, other = _one_pass(kernel, starts, node[some], index[some], seed), rank[some] % 2 == 1
        for k in range(MOMENTS):
            total[:, k] += np.bincount(node[some], sums[k], len(counts))
            odd[:, k] += np.bincount(node[some][other], sums[k][other], len(counts))
        square += np.bincount(node[some], sums[:3].mean(0) ** 2, len(counts))
    return total, square, counts, odd


def _level_and_variance(total: np.ndarray, square: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean of E's channels and the variance of that mean, estimated."""
    level = total[:, :3].mean(1) / (counts * GROUP)
    spread = np.maximum(square / (counts * GROUP**2) - level**2, 0.0)
    return level, spread / np.maximum(counts - 1, 1)


def _shared_out(nodes: Nodes, level: np.ndarray, variance: np.ndarray, groups: float) -> np.ndarray:
    """Return how many groups each node gets, an even number: in proportion to its relative error, within bounds."""
    shape, grid = (nodes.axes[1].lines, nodes.axes[0].lines), nodes.grid_count
    level, variance = level.copy(), variance.copy()
    for values in (level, variance):
        values[:grid] = cv2.blur(values[:grid].reshape(shape), (_SMOOTH, _SMOOTH)).ravel()
        values[grid:] = _over_neighbours(nodes, values[grid:])
    # (The filter's running sums leave rounding below zero.)
    error = np.sqrt(np.maximum(variance, 0.0)) / (level + _FLOOR * level.mean()) * _size(nodes)
    share = np.clip(error / max(error.mean(), 1e-12), _LEAST, _MOST)
    return 2 * np.maximum(np.rint(0.5 * share / share.mean() * groups), 1).astype(np.int64)


def _size(nodes: Nodes) -> np.ndarray:
    """Return the surface that each node stands for, at most 1, in fine cells: where many share a pixel, few will do."""
    each = vertex_areas(nodes) / nodes.fine**2
    return np.concatenate([np.ones(nodes.grid_count), np.clip(each, 0.0, 1.0)])


def _over_neighbours(nodes: Nodes, values: np.ndarray) -> np.ndarray:
    """Return means over the triangles round each vertex; vertices of no triangle, backs among them, keep theirs."""
    corners = nodes.triangles.ravel()
    mean = np.repeat(values[nodes.triangles].mean(1), 3)
    met = np.bincount(corners, minlength=len(values))
    return np.where(met > 0, np.bincount(corners, mean, len(values)) / np.maximum(met, 1), values)


def _one_pass(kernel: LoadedScene, starts: Starts, node: np.ndarray, index: np.ndarray, seed: int) -> np.ndarray:
    """Return the sums of the moments over each group, (12, groups) float64."""
    lane = dr.arange(mi.UInt32, len(node) * GROUP)
    group = lane // GROUP
    at, first = (dr.gather(mi.UInt32, mi.UInt32(values), group) for values in (node, index))
    points = samples(at, first + lane % GROUP, 1 << 14, seed)
    values = _arriving(kernel, starts, at, points)
    dr.eval(values)
    return np.stack([np.array(dr.block_sum(value, GROUP), np.float64) for value in values])


def _arriving(kernel: LoadedScene, starts: Starts, node: mi.UInt32, points: Samples) -> list[mi.Float]:
    """Return the moments that each path finds: E, E weighted with f, and the directions by luminance of both."""
    scene, offset = kernel.mi_scene, dr.opaque(mi.Float, kernel.offset)
    si = dr.zeros(mi.SurfaceInteraction3f, dr.width(node))
    si.p, si.n, ns, known = start_points(starts, node, points)
    si.wavelengths, weight = draw_wavelengths(mi.Float(0.5))
    a, b, c, d = four(points, mi.UInt32(1))

    ds, lamp = scene.sample_emitter_direction(si, mi.Point2f(a, b), False)
    cos = dr.dot(ns, ds.d)
    lit = known & (ds.pdf > 0.0) & (cos > 0.0) & (dr.dot(si.n, ds.d) > 0.0) & dr.any(lamp > 0.0)
    lit = unshadowed(scene, si, ds, offset, lit)
    share = dr.select(ds.delta, 1.0, ds.pdf / (ds.pdf + cos * dr.inv_pi))
    near = dr.select(lit, share * cos * lamp, 0.0)

    local = mi.warp.square_to_cosine_hemisphere(mi.Point2f(c, d))
    direction = mi.Frame3f(ns).to_world(local)
    # A direction along the surface itself would have no density, and its share of a lamp's light would be 0 / 0.
    start = Start(si, dr.maximum(local.z, 1e-6) * dr.inv_pi)
    found = trace(kernel, leave(si, direction, offset), weight, points, kernel.description.picture, start=start)
    # Where the shading normal leans out of the surface, half the directions lead into it.
    far = dr.select(known & (dr.dot(si.n, direction) > 0.0), dr.pi * found.radiance, 0.0)

    f_near, f_far = schlick(cos), schlick(local.z)
    by_near, by_far = mi.luminance(near) * ds.d, mi.luminance(far) * direction
    towards, towards_f = by_near + by_far, f_near * by_near + f_far * by_far
    return [*(near + far), *(f_near * near + f_far * far), *towards, *towards_f]
