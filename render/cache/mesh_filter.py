"""The noise of the light stored on meshes, taken out scale by scale.

Light on a mesh is no picture that a denoiser could read. So it is parted into scales by diffusion over the surface
(an undecimated wavelet transform: Hammond, Vandergheynst, Gribonval 2011, "Wavelets on graphs via spectral graph
theory", here with powers of one smoothing step), and each scale is weakened as Wiener's filter would: by the share of
its power that is noise. How much is noise tell two halves of the paths, which are parted in the same way: their
difference has the noise of their mean, and nothing of the light.

A firefly, found by one path of one half, is all noise by that measure, and is spread over its surroundings. What is far
too bright for that would still make a spot there, and is spread over the whole of its mesh before.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from ...procedural.surroundings.colour import luminance
from .cache_points import Nodes, to_front, vertex_areas

#: Vertices that light diffuses to in a step, so far away at the most [m] and with normals that differ by at most so
#: much: as far as the edges of cut meshes are long, and less than round a box's edge.
_NEIGHBOURS, _REACH, _TURN = 12, 0.005, 0.4
#: Steps of diffusion between one scale and the next. Fewer leave coloured spots of a few centimetres round fireflies.
_STEPS = (1, 2, 4, 8, 16, 32)
#: Steps that powers are averaged over, and how much of the noise's is taken off: its own estimate has noise.
_AVERAGED, _MARGIN = 3, 1.5
#: A vertex is a firefly where it is so many times brighter than the darker halves round it, over `_AVERAGED` steps, and
#: one half of its paths has so many times the light of the other.
_STANDS_OUT, _LONE = 10.0, 4.0


def smoothed_meshes(nodes: Nodes, halves: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Return the light of a scene's meshes without its noise; its mean over the surface stays.

    Parameters
    ----------
    nodes : Nodes
        Where light is stored.
    halves : two (vertices, 12) float64
        Moments by half of the paths each, before directions are divided by the light.

    Returns
    -------
    (vertices, 12) float64
        Their mean, filtered. The light >= 0.
    """
    if len(nodes.positions) <= _NEIGHBOURS:
        return 0.5 * (halves[0] + halves[1])
    step = _diffusion(nodes)
    first, second = _without_fireflies(nodes, step, halves)
    light, noise = 0.5 * (first + second), luminance(0.5 * (first - second)[:, :3])
    result = np.zeros_like(light)
    for steps in _STEPS:
        softer, softer_noise = _repeated(step, steps, light), _repeated(step, steps, noise)
        detail, of_noise = light - softer, noise - softer_noise
        kept = _kept(step, luminance(detail[:, :3]), of_noise)
        result += kept[:, None] * detail
        # What is taken off goes on to the next scale, spread by the width of this one: no light gets lost.
        light = softer + _repeated(step, steps, (1.0 - kept)[:, None] * detail)
        noise = softer_noise + _repeated(step, steps, (1.0 - kept) * of_noise)
    result += light
    result[:, :6] = np.maximum(result[:, :6], 0.0)
    return result


def _without_fireflies(
    nodes: Nodes, step: csr_array, halves: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return both halves with what makes fireflies of vertices spread over their meshes."""
    levels = luminance(halves[0][:, :3]), luminance(halves[1][:, :3])
    dark, level = np.minimum(*levels), 0.5 * (levels[0] + levels[1])
    around = _repeated(step, _AVERAGED, dark)
    lone = (level > _STANDS_OUT * around) & (np.maximum(*levels) > _LONE * dark)
    kept = np.divide(around, level, out=np.ones_like(level), where=lone)[:, None]
    area, mesh = _areas(nodes), 2 * nodes.mesh.astype(np.int64) + nodes.back
    surplus = (area[:, None] * (1.0 - kept) * 0.5 * (halves[0] + halves[1])).T
    whole = np.maximum(np.bincount(mesh, area), 1e-12)
    even = np.stack([np.bincount(mesh, one, len(whole)) / whole for one in surplus], axis=1)[mesh]
    return kept * halves[0] + even, kept * halves[1] + even


def _areas(nodes: Nodes) -> np.ndarray:
    """Return the area of all vertices, none of them quite 0 [m^2]."""
    # (Backs have the triangles of their fronts.)
    return np.maximum(vertex_areas(nodes)[np.arange(len(nodes.positions)) - to_front(nodes)], 1e-12)


def _repeated(step: csr_array, steps: int, values: np.ndarray) -> np.ndarray:
    for _ in range(steps):
        values = step @ values
    return values


def _kept(step: csr_array, detail: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Return the share of each detail that is no noise."""
    power, of_noise = detail**2, noise**2
    for _ in range(_AVERAGED):
        power, of_noise = step @ power, step @ of_noise
    return np.clip(1.0 - _MARGIN * np.divide(of_noise, power, out=np.ones_like(power), where=power > 0.0), 0.0, 1.0)


def _diffusion(nodes: Nodes) -> csr_array:
    """Return one step of diffusion: rows sum to 1, and what one vertex gives another one gets, by area."""
    count = len(nodes.positions)
    area = _areas(nodes)
    # (Surfaces of other meshes are another world.)
    where = np.concatenate([nodes.positions / _REACH, nodes.normals / _TURN, 1e6 * nodes.mesh[:, None]], axis=1)
    distance, other = cKDTree(where).query(where, _NEIGHBOURS + 1, distance_upper_bound=2.0)
    here = np.repeat(np.arange(count), _NEIGHBOURS + 1)
    near = np.isfinite(distance.ravel()) & (other.ravel() != here)
    i, j, weight = here[near], other.ravel()[near], np.exp(-0.5 * distance.ravel()[near] ** 2)
    one_way = csr_array((weight, (i, j)), (count, count))
    both = one_way.maximum(one_way.T).tocoo()
    # What flows between two is the same both ways, and no more than either has to give.
    given = area / np.maximum(np.bincount(both.row, both.data, count), 1e-12)
    flow = both.data * np.minimum(given[both.row], given[both.col]) / area[both.row]
    stays = 1.0 - np.bincount(both.row, flow, count)
    rows, columns = (np.concatenate([x, np.arange(count)]) for x in (both.row, both.col))
    return csr_array((np.concatenate([flow, stays]), (rows, columns)), (count, count))
