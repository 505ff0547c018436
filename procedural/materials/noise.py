"""Noise: gradient noise and Voronoi cells, periodic on the unit tile, and hashed value noise in space.

The two kinds of noise serve two purposes. A texture is a tile that repeats, so its lattice is periodic and small, and
its gradients are drawn. An environment is a field over directions or points without a period, so its lattice values
are hashed from the coordinates and a seed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

#: Largest magnitude of two-dimensional gradient noise with unit gradients (at a cell's centre, all four pointing to
#: it: four corners, each with weight 1/4 and dot product sqrt(1/2)).
GRADIENT_PEAK = np.sqrt(0.5)

# Odd 32-bit multipliers that spread lattice coordinates over the hash (Teschner et al., "Optimized Spatial Hashing
# for Collision Detection of Deformable Objects", VMV 2003) and the multipliers of Murmur3's 32-bit finaliser.
_HASH_MULTIPLIERS = np.array([73856093, 19349663, 83492791], dtype=np.uint32)
_MIX_MULTIPLIERS = (np.uint32(0x85EBCA6B), np.uint32(0xC2B2AE35))


def tile_grid(resolution: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the texture coordinates (u, v) of the pixel centres of a square tile, each (n, n) float64 in (0, 1)."""
    centres = (np.arange(resolution) + 0.5) / resolution
    u, v = np.meshgrid(centres, centres)
    return u, v


def gradient_noise(u: np.ndarray, v: np.ndarray, cells: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Return gradient noise in [-1, 1] with period 1 in u and v.

    Perlin, "Improving noise" (SIGGRAPH 2002), with unit gradients of random angle on a periodic lattice.

    Parameters
    ----------
    u, v : (...) float
        Where to evaluate; any real numbers.
    cells : (int, int)
        Lattice cells per period along u and along v.
    rng : numpy.random.Generator
        Source of the gradients.
    """
    angles = rng.uniform(0.0, 2.0 * np.pi, (cells[1], cells[0]))
    x, y = u * cells[0], v * cells[1]
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = x - column, y - row
    cosines, sines = np.cos(angles).ravel(), np.sin(angles).ravel()  # on the lattice, which is smaller than a picture
    columns, rows = (column % cells[0], (column + 1) % cells[0]), (row % cells[1], (row + 1) % cells[1])
    corners = {}
    for dx in (0, 1):
        for dy in (0, 1):
            index = rows[dy] * cells[0] + columns[dx]
            corners[dx, dy] = cosines[index] * (fx - dx) + sines[index] * (fy - dy)
    sx, sy = _fade(fx), _fade(fy)
    low = corners[0, 0] + sx * (corners[1, 0] - corners[0, 0])
    high = corners[0, 1] + sx * (corners[1, 1] - corners[0, 1])
    return (low + sy * (high - low)) / GRADIENT_PEAK


def fractal_gradient_noise(
    u: np.ndarray, v: np.ndarray, cells: tuple[int, int], octaves: int, rng: np.random.Generator
) -> np.ndarray:
    """Return a sum of octaves of `gradient_noise`, each twice as fine and half as strong, within [-1, 1].

    Half the strength per octave gives the 1/f spectrum of Perlin, "An image synthesizer" (SIGGRAPH 1985).
    """
    return _fractal(lambda k: gradient_noise(u, v, (cells[0] << k, cells[1] << k), rng), octaves)


def value_noise(points: np.ndarray, seed: int) -> np.ndarray:
    """Return value noise: random values on the integer lattice, joined by smooth steps.

    Parameters
    ----------
    points : (..., 3) float
        Where to evaluate; features are about one unit wide.
    seed : int
        Selects the lattice values.

    Returns
    -------
    (...) float32
        In [0, 1], mean 1/2.
    """
    base = np.floor(points)
    f = (points - base).astype(np.float32)
    f = f * f * (3.0 - 2.0 * f)
    # The hash takes one axis after the other, so the eight corners have its first steps in common.
    bits, cell = np.full(f.shape[:-1], seed & 0xFFFFFFFF, dtype=np.uint32), base.astype(np.int64)
    return _interpolated(bits, cell, f, 0)


def fractal_value_noise(points: np.ndarray, seed: int, octaves: int) -> np.ndarray:
    """Return a sum of octaves of `value_noise`, each twice as fine and half as strong; in [0, 1], (...) float32."""
    return _fractal(lambda k: value_noise(points * 2.0**k, seed + k), octaves)


def lattice(cell: np.ndarray, seed: int) -> np.ndarray:
    """Return a random value in [0, 1) for each lattice point (..., 3) int, (...) float32."""
    bits = np.full(cell.shape[:-1], seed & 0xFFFFFFFF, dtype=np.uint32)
    for axis in range(3):
        bits = _hash_step(bits, cell[..., axis], axis)
    return _unit(bits)


def cellular(u: np.ndarray, v: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return Voronoi cells on the tile with wrapped edges (Worley, "A cellular texture basis function", 1996).

    Parameters
    ----------
    u, v : (...) float
        Where to evaluate.
    points : (k, 2) float
        Feature points in [0, 1).

    Returns
    -------
    (...) int
        Index of the nearest point.
    (...) float
        Distance from the cell's edge, as second nearest minus nearest distance [tile].
    """
    from scipy.spatial import cKDTree  # requests are parsed without it

    distance, index = cKDTree(points, boxsize=1.0).query(np.stack([u % 1.0, v % 1.0], -1), k=2)
    return index[..., 0], distance[..., 1] - distance[..., 0]


def smoothstep(low: float, high: float, value: np.ndarray) -> np.ndarray:
    """Return the cubic step from 0 at `low` to 1 at `high`."""
    t = np.clip((value - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _fade(t: np.ndarray) -> np.ndarray:
    # Perlin 2002: its first and second derivatives vanish at the lattice, so no creases show.
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


def _fractal(octave: Callable[[int], np.ndarray], octaves: int) -> np.ndarray:
    """Return the sum of octaves k = 0, 1, ... with weights 2^-k, divided by the sum of the weights."""
    total = octave(0)
    for k in range(1, octaves):
        total += octave(k) * 0.5**k
    return total / (2.0 - 0.5 ** (octaves - 1))


def _interpolated(bits: np.ndarray, cell: np.ndarray, f: np.ndarray, axis: int) -> np.ndarray:
    """Return the lattice values interpolated along this axis and those after it."""
    if axis == 3:
        return _unit(bits)
    low = _interpolated(_hash_step(bits, cell[..., axis], axis), cell, f, axis + 1)
    high = _interpolated(_hash_step(bits, cell[..., axis] + 1, axis), cell, f, axis + 1)
    return low + (high - low) * f[..., axis]


def _hash_step(bits: np.ndarray, coordinate: np.ndarray, axis: int) -> np.ndarray:
    return _mixed(bits ^ (coordinate.astype(np.uint32) * _HASH_MULTIPLIERS[axis]))


def _unit(bits: np.ndarray) -> np.ndarray:
    # 24 bits are what a float32 holds exactly.
    return (bits >> np.uint32(8)).astype(np.float32) * np.float32(2.0**-24)


def _mixed(bits: np.ndarray) -> np.ndarray:
    """Return bits mixed by the 32-bit finaliser of Murmur3."""
    bits = (bits ^ (bits >> np.uint32(16))) * _MIX_MULTIPLIERS[0]
    bits = (bits ^ (bits >> np.uint32(13))) * _MIX_MULTIPLIERS[1]
    return bits ^ (bits >> np.uint32(16))
