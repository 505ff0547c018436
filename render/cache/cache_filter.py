"""Denoises the irradiance cache: Open Image Denoise's light-map filter on the grid, a graph wavelet filter on meshes.

The light-map filter needs no guides: irradiance has no texture. Measured on `filled` at 320x240 against 320 paths a
cache point (docs/performance.md): the relative squared error of 64 paths a point falls from 0.0057 to 0.0005.

Irradiance on a mesh is not an image that a denoiser can read. So it is decomposed into scales by diffusion over the
surface (an undecimated wavelet transform: Hammond, Vandergheynst, Gribonval 2011, "Wavelets on graphs via spectral
graph theory", here with powers of one diffusion step), and each scale is attenuated by a Wiener filter: by the fraction
of its power that is noise. The noise is estimated from two halves of the paths, decomposed in the same way: half their
difference has the noise of their mean and no signal.

A firefly, found by one path of one half, is all noise by that measure, and is spread over its neighbourhood. Fireflies
that are too bright for that would still make a spot, and are spread before over all of their mesh that faces the same
way.
"""

from __future__ import annotations

from typing import TypeAlias

import cv2
import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from ...procedural.surroundings.colour import luminance
from ..pictures.denoise import blend, run_filter
from .cache_points import CachePoints, point_areas

#: The same moments by two halves of the paths or photons.
Halves: TypeAlias = tuple[np.ndarray, np.ndarray]
#: Side of the box over which light removed or added by the filter is returned, over the grid's longer side [1]. The
#: filter removes fireflies as noise: under an environment map with small bright lights the table lost 0.2 % of its
#: light (`hdri`).
SPREAD = 1 / 16
#: Standard deviations of the windows in which the fraction of caustics is averaged, and in which light that the filter
#: takes off caustics is returned [cells]. Under a sun of 0.27 degrees (seed 28) the filter took 1.9 % of the light off
#: the cores of caustics; half of that is left.
_CAUSTIC_SIGMA, _RETURN_SIGMA = 4.0, 2.0
#: Neighbours of a vertex in a diffusion step [1], their maximum distance [m] and maximum difference of normals [1]: as
#: long as the edges of refined meshes, and less than across the edge of a box.
_NEIGHBOURS, _REACH, _NORMAL_REACH = 12, 0.005, 0.4
#: Diffusion steps between one scale and the next [1]. Fewer leave coloured spots of a few centimetres around fireflies.
_STEPS = (1, 2, 4, 8, 16, 32)
#: Diffusion steps that powers are averaged over [1], and the factor on the estimated noise power [1], which has noise
#: itself.
_AVERAGING_STEPS, _NOISE_FACTOR = 3, 1.5
#: Smallest ratio of a firefly to the light around it by the darker half of all paths, averaged over `_AVERAGING_STEPS`
#: steps [1], and of the brighter half of its own paths to the darker one [1].
_MIN_CONTRAST, _MIN_HALF_RATIO = 10.0, 4.0
#: Weight of the number of a mesh's side in the neighbour search [1]: other sides and meshes are beyond any reach.
_MESH_DISTANCE = 1e6


def denoised_grid(moments: np.ndarray, noise: np.ndarray, caustics: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return the denoised moments of a grid.

    Where the filter takes off more than noise, as in bright and sharp caustics, less of it is applied
    (`pictures.denoise.blend`). What is taken off all the same is returned near by: within a few cells where light is of
    caustics, over a wide box where it is not.

    Parameters
    ----------
    moments : (rows * columns, 12) float32
        As `irradiance_cache.IrradianceCache.moments`.
    noise : (rows * columns, 6) float32
        Half the difference of the irradiance by two halves of the paths and photons, and of its part weighted with f:
        its square has the mean of the variance.
    caustics : (rows * columns,) float
        Fraction of each cell's light that is of caustics, with its noise.
    shape : (int, int)
        Rows and columns of the grid.

    Returns
    -------
    (rows * columns, 12) float32
        The irradiance is >= 0, and its sum is the same except for clamped negative values.
    """
    result, image_of = np.empty_like(moments), moments.reshape(*shape, -1)
    near = np.clip(_gaussian(caustics.reshape(shape), _CAUSTIC_SIGMA), 0.0, 1.0)[..., None]
    for first, directional in ((0, False), (3, False), (6, True), (9, True)):
        image = image_of[..., first : first + 3]
        filtered = _filtered(image, directional)
        if not directional:
            variance = np.square(noise[:, first : first + 3]).reshape(*shape, 3)
            filtered = blend(image, variance, filtered)
            removed = image - filtered
            filtered += _gaussian(near * removed, _RETURN_SIGMA)
            filtered = np.maximum(filtered + _box_filtered((1.0 - near) * removed, SPREAD * max(shape)), 0.0)
        result[:, first : first + 3] = filtered.reshape(-1, 3)
    return result


def _filtered(image: np.ndarray, directional: bool) -> np.ndarray:
    image = np.ascontiguousarray(image, np.float32)
    result = np.zeros_like(image)
    import pyoidn

    images = {pyoidn.OIDN_IMAGE_COLOR: image, pyoidn.OIDN_IMAGE_OUTPUT: result}
    run_filter("RTLightmap", images, directional=directional)
    return result


def _gaussian(image: np.ndarray, sigma: float) -> np.ndarray:
    """Return an image filtered with a Gaussian whose weights are mirrored at the borders: its sum stays."""
    return cv2.GaussianBlur(np.ascontiguousarray(image, np.float32), (0, 0), sigma, borderType=cv2.BORDER_REFLECT)


def _box_filtered(image: np.ndarray, width: float) -> np.ndarray:
    """Return a picture filtered with a box whose weights are normalised inside the picture; its sum stays.

    Parameters
    ----------
    image : (H, W, 3) float32
        The picture.
    width : float
        Side of the box [px], rounded to an odd number.
    """
    side = 2 * int(width / 2) + 1
    ones = np.ones(image.shape[:2], np.float32)
    inside = cv2.boxFilter(ones, -1, (side, side), borderType=cv2.BORDER_CONSTANT)
    return cv2.boxFilter(image / inside[..., None], -1, (side, side), borderType=cv2.BORDER_CONSTANT)


def denoised_meshes(points: CachePoints, paths: Halves, photons: Halves | None = None) -> np.ndarray:
    """Return the denoised irradiance of a scene's meshes; its mean over the surface stays.

    Parameters
    ----------
    points : CachePoints
        The cache points.
    paths : two (vertices, 12) float64
        Moments by half of the paths each, before directions are divided by the irradiance.
    photons : two (vertices, 12) float64, optional
        Moments by half of the photons each. They are filtered apart, so that the noise of paths does not blur caustics,
        and have no fireflies: all photons carry about as much.

    Returns
    -------
    (vertices, 12) float32
        The sum of both means, filtered. The irradiance is >= 0.
    """
    if len(points.positions) <= _NEIGHBOURS:
        return 0.5 * sum(paths if photons is None else (*paths, *photons), np.zeros_like(paths[0]))
    # In float32: the filter is bound by memory, and the noise is far above the rounding.
    step = diffusion_step(points).astype(np.float32)
    result = _by_scales(step, _without_fireflies(points, step, _single(paths)))
    return result if photons is None else result + _by_scales(step, _single(photons))


def _single(halves: Halves) -> Halves:
    return halves[0].astype(np.float32), halves[1].astype(np.float32)


def _by_scales(step: csr_array, halves: Halves) -> np.ndarray:
    """Return the mean of two halves with the details of each scale as far as they are not noise."""
    first, second = halves
    light, noise = 0.5 * (first + second), luminance(0.5 * (first - second)[:, :3])
    result = np.zeros_like(light)
    for steps in _STEPS:
        softer, softer_noise = _diffused(step, steps, light), _diffused(step, steps, noise)
        detail, of_noise = light - softer, noise - softer_noise
        kept = _kept(step, luminance(detail[:, :3]), of_noise)
        result += kept[:, None] * detail
        # The removed part is added to the next scale, diffused by the width of this one: no light is lost.
        light = softer + _diffused(step, steps, (1.0 - kept)[:, None] * detail)
        noise = softer_noise + _diffused(step, steps, (1.0 - kept) * of_noise)
    result += light
    result[:, :6] = np.maximum(result[:, :6], 0.0)
    return result


def _without_fireflies(points: CachePoints, step: csr_array, halves: Halves) -> Halves:
    """Return both halves with the excess of fireflies spread over their meshes (`_even`)."""
    levels = luminance(halves[0][:, :3]), luminance(halves[1][:, :3])
    dark, level = np.minimum(*levels), 0.5 * (levels[0] + levels[1])
    # Each half is averaged alone: where half of the paths find the sun, both averages have it, but of a few paths of a
    # vertex often one half has none.
    around = np.minimum(*(_diffused(step, _AVERAGING_STEPS, one) for one in levels))
    is_firefly = (level > _MIN_CONTRAST * around) & (np.maximum(*levels) > _MIN_HALF_RATIO * dark)
    kept = np.divide(around, level, out=np.ones_like(level), where=is_firefly)[:, None].astype(halves[0].dtype)
    even = _even(points, (1.0 - kept) * 0.5 * (halves[0] + halves[1])).astype(halves[0].dtype)
    return kept * halves[0] + even, kept * halves[1] + even


def _even(points: CachePoints, excess: np.ndarray) -> np.ndarray:
    """Return light spread over the vertices of each mesh that face the same way; its sum by area stays.

    A vertex faces each of the six directions along the axes by the fourth power of its normal's part, over the sum of
    these: the light of a side in the sun does not reach the one in the shade.
    """
    area, mesh = point_areas(points)[points.grid_count :], _sides(points)
    power = np.square(np.square(np.concatenate([points.normals, -points.normals], axis=1).clip(min=0.0)))
    result = np.zeros(excess.shape)
    for part in (power / np.maximum(power.sum(axis=1, keepdims=True), 1e-30)).T:
        weight = area * part
        whole = np.maximum(np.bincount(mesh, weight), 1e-12)
        means = np.stack([np.bincount(mesh, weight * one, len(whole)) / whole for one in excess.T], axis=1)
        result += part[:, None] * means[mesh]
    return result


def _diffused(step: csr_array, steps: int, values: np.ndarray) -> np.ndarray:
    """Return values after a number of diffusion steps."""
    for _ in range(steps):
        values = step @ values
    return values


def _kept(step: csr_array, detail: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Return the Wiener factor of each detail: the fraction of its power that is signal."""
    power, of_noise = detail**2, noise**2
    for _ in range(_AVERAGING_STEPS):
        power, of_noise = step @ power, step @ of_noise
    return np.clip(
        1.0 - _NOISE_FACTOR * np.divide(of_noise, power, out=np.ones_like(power), where=power > 0.0), 0.0, 1.0
    )


def _sides(points: CachePoints) -> np.ndarray:
    """Return a number for each side of each mesh, by vertex, int64."""
    return 2 * points.mesh.astype(np.int64) + points.back


def diffusion_step(points: CachePoints) -> csr_array:
    """Return the matrix of one diffusion step: rows sum to 1, and the flow between two vertices is equal by area."""
    count = len(points.positions)
    area = point_areas(points)[points.grid_count :]
    # Open meshes have two sides. Within a thin plate the back of one face looks as the front of the other one does.
    mesh = _MESH_DISTANCE * _sides(points)[:, None]
    features = np.concatenate([points.positions / _REACH, points.normals / _NORMAL_REACH, mesh], axis=1)
    distance, other = cKDTree(features).query(features, _NEIGHBOURS + 1, distance_upper_bound=2.0)
    here = np.repeat(np.arange(count), _NEIGHBOURS + 1)
    near = np.isfinite(distance.ravel()) & (other.ravel() != here)
    i, j, weight = here[near], other.ravel()[near], np.exp(-0.5 * distance.ravel()[near] ** 2)
    one_way = csr_array((weight, (i, j)), (count, count))
    both = one_way.maximum(one_way.T).tocoo()
    # The flow between two vertices is symmetric, and at most what either contains.
    given = area / np.maximum(np.bincount(both.row, both.data, count), 1e-12)
    flow = both.data * np.minimum(given[both.row], given[both.col]) / area[both.row]
    stays = 1.0 - np.bincount(both.row, flow, count)
    rows, columns = (np.concatenate([x, np.arange(count)]) for x in (both.row, both.col))
    return csr_array((np.concatenate([flow, stays]), (rows, columns)), (count, count))
