"""Fills the irradiance cache: caustics by photons, all other light by paths from the surface around every cache point.

A path starts at a random point of the surface area of its cache point, samples one emitter (next-event estimation), and
continues in a cosine-distributed direction as the path tracer does. Without caustics all points are about as noisy, so
the number of paths follows the area that a point represents.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...procedural.surroundings.colour import luminance
from .._mitsuba import dr, mi
from ..pictures.integrator import PathOrigin, StoredCaustics, balance_heuristic, trace
from ..pictures.sampler import SobolSampler, sample_4d, sobol_sampler
from ..scene.emitters import sample_emitter, unoccluded
from ..scene.loaded_scene import LoadedScene
from ..scene.rays import leave
from ..scene.spectrum import draw_wavelengths
from .cache_filter import denoised_grid, denoised_meshes
from .cache_points import CachePoints, vertex_areas
from .irradiance_cache import MOMENTS, IrradianceCache, normalised
from .lobes import schlick
from .photon_map import photon_moments
from .sample_points import PointSampler, point_sampler, sample_points
from .stored_caustics import stored_caustics

#: Paths of one pass [1]. Each holds 48 bytes of results, so a pass stays near 100 MB.
PATHS_PER_PASS = 1 << 21
#: Paths of a group [1]. The variance between a point's groups gives that of its mean.
GROUP = 2
#: Fewest groups of a point [1]: two halves of its paths tell the filter of meshes what is noise.
_MIN_GROUPS = 2
#: Fewest paths of a mesh [1]. One has a relative noise of about 0.5, so that half of a small or distant object, lit
#: evenly, is right to 0.4 %.
_MESH_PATHS = 1 << 15
#: Surfaces that a path meets before Russian roulette begins [1]. The paths' ends hardly matter to a mean over a
#: hemisphere: against 16 surfaces a third less time, half a percent more variance (seed 104 of the preset `fast`).
_RR_DEPTH = 2


@dataclass(frozen=True, eq=False)
class _Sums:
    """Sums over the paths of every cache point."""

    counts: np.ndarray  #: (points,) groups
    moments: np.ndarray  #: (points, 12) over all groups
    odd_moments: np.ndarray  #: (points, 12) over every second group


def fill_cache(
    loaded: LoadedScene, points: CachePoints, paths: int, seed: int, photons: int = 1 << 20
) -> IrradianceCache:
    """Return the irradiance at the cache points.

    Parameters
    ----------
    loaded : LoadedScene
        The scene, loaded for the cache.
    points : CachePoints
        The cache points.
    paths : int
        Mean number of paths of a point; at least two groups of every point are traced.
    seed : int
        32-bit seed.
    photons : int
        Number of photons that caustics are made of.
    """
    photon_halves = photon_moments(loaded, points, photons, seed)
    caustics = 0.5 * (photon_halves[0] + photon_halves[1])
    gather = _Gather(loaded, point_sampler(points), stored_caustics(loaded, points, caustics), seed)
    counts = _group_counts(points, paths / GROUP)
    sums = _traced_groups(gather, counts)
    total, odd = sums.moments, sums.odd_moments
    grid, half = points.grid_count, (0.5 * counts * GROUP)[:, None]
    halves = (total - odd) / half, odd / half
    mean = 0.5 * (halves[0][:grid] + halves[1][:grid])
    of_paths, of_photons = ((first[grid:], second[grid:]) for first, second in (halves, photon_halves))
    meshes = denoised_meshes(points, of_paths, of_photons)
    moments = normalised(np.concatenate([mean + caustics[:grid], meshes])).astype(np.float32)
    noise = 0.5 * ((halves[0] - halves[1])[:grid, :6] + (photon_halves[0] - photon_halves[1])[:grid, :6])
    fraction = luminance(caustics[:grid, :3]) / np.maximum(luminance(moments[:grid, :3]), 1e-30)
    moments[:grid] = denoised_grid(moments[:grid], noise, fraction, (points.axes[1].lines, points.axes[0].lines))
    return IrradianceCache(points, moments, counts * GROUP, photons, caustics)


@dataclass(frozen=True, eq=False)
class _Gather:
    """What the paths of all passes share."""

    loaded: LoadedScene
    origins: PointSampler
    caustics: StoredCaustics
    seed: int


def _traced_groups(gather: _Gather, counts: np.ndarray) -> _Sums:
    """Trace groups of paths of every cache point."""
    total, odd = np.zeros((len(counts), MOMENTS)), np.zeros((len(counts), MOMENTS))
    point = np.repeat(np.arange(len(counts), dtype=np.uint32), counts)
    rank = np.arange(len(point)) - np.repeat(np.cumsum(counts) - counts, counts)
    index, groups_per_pass = (rank * GROUP).astype(np.uint32), PATHS_PER_PASS // GROUP
    for begin in range(0, len(point), groups_per_pass):
        part = slice(begin, begin + groups_per_pass)
        sums, other = _trace_pass(gather, point[part], index[part]), rank[part] % 2 == 1
        for k in range(MOMENTS):
            total[:, k] += np.bincount(point[part], sums[k], len(counts))
            odd[:, k] += np.bincount(point[part][other], sums[k][other], len(counts))
    return _Sums(counts, total, odd)


def _group_counts(points: CachePoints, groups: float) -> np.ndarray:
    """Return the number of groups of each cache point, even: in proportion to its area, and enough for each mesh."""
    weight = _relative_area(points)
    wanted, mesh = weight / weight.mean() * groups, points.mesh
    of_mesh = np.bincount(mesh, wanted[points.grid_count :])
    wanted[points.grid_count :] *= np.maximum(_MESH_PATHS / GROUP / np.maximum(of_mesh, 1e-12), 1.0)[mesh]
    return 2 * np.maximum(np.rint(0.5 * wanted), _MIN_GROUPS // 2).astype(np.int64)


def _relative_area(points: CachePoints) -> np.ndarray:
    """Return the area of each cache point in fine cells, at most 1: where many share a pixel, each needs few paths."""
    each = vertex_areas(points) / points.fine**2
    return np.concatenate([np.ones(points.grid_count), np.clip(each, 0.0, 1.0)])


def _trace_pass(gather: _Gather, point: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Return the sums of the moments over each group, (12, groups) float64."""
    lane = dr.arange(mi.UInt32, len(point) * GROUP)
    group = lane // GROUP
    at, first = (dr.gather(mi.UInt32, mi.UInt32(values), group) for values in (point, index))
    sampler = sobol_sampler(at, first + lane % GROUP, 1 << 14, gather.seed)
    values = _incident_moments(gather, at, sampler)
    dr.eval(values)
    return np.stack([np.array(dr.block_sum(value, GROUP), np.float64) for value in values])


def _incident_moments(gather: _Gather, point: mi.UInt32, sampler: SobolSampler) -> list[mi.Float]:
    """Trace one path of each lane's point; return E, E weighted with f, and the directions of both by luminance."""
    loaded, origins = gather.loaded, gather.origins
    offset = dr.opaque(mi.Float, loaded.offset)
    si = dr.zeros(mi.SurfaceInteraction3f, dr.width(point))
    start = sample_points(origins, point, sampler)
    si.p, si.n, ns = start.p, start.n, start.ns
    si.wavelengths, weight = draw_wavelengths(mi.Float(0.5))
    a, b, c, d = sample_4d(sampler, mi.UInt32(1))

    ds, emitted = sample_emitter(loaded.emitters, si, mi.Point2f(a, b))
    cos = dr.dot(ns, ds.d)
    lit = start.valid & (ds.pdf > 0.0) & (cos > 0.0) & (dr.dot(si.n, ds.d) > 0.0) & dr.any(emitted > 0.0)
    emitted = unoccluded(loaded.emitters, si, (ds, emitted), offset, lit)
    mis_weight = dr.select(ds.delta, 1.0, balance_heuristic(ds.pdf, cos * dr.inv_pi))
    direct = dr.select(lit, mis_weight * cos * emitted, 0.0)

    local = mi.warp.square_to_cosine_hemisphere(mi.Point2f(c, d))
    direction = mi.Frame3f(ns).to_world(local)
    # A direction along the surface would have the density 0, and the MIS weight of an emitter would be 0 / 0.
    origin = PathOrigin(si, dr.maximum(local.z, 1e-6) * dr.inv_pi, mi.Bool(False))
    picture = loaded.description.picture.model_copy(update={"rr_depth": _RR_DEPTH})
    found = trace(loaded, leave(si, direction, offset), weight, sampler, picture, origin, gather.caustics)
    # Where the shading normal is tilted, some directions lead into the surface.
    indirect = dr.select(start.valid & (dr.dot(si.n, direction) > 0.0), dr.pi * found.radiance, 0.0)

    f_direct, f_indirect = schlick(cos), schlick(local.z)
    by_direct, by_indirect = mi.luminance(direct) * ds.d, mi.luminance(indirect) * direction
    mean, mean_f = by_direct + by_indirect, f_direct * by_direct + f_indirect * by_indirect
    return [*(direct + indirect), *(f_direct * direct + f_indirect * indirect), *mean, *mean_f]
