"""Periodic noise on the unit tile: what is drawn at u = 0 continues at u = 1."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

#: Largest magnitude of two-dimensional gradient noise with unit gradients (at a cell's centre, all four pointing to
#: it: four corners, each with weight 1/4 and dot product sqrt(1/2)).
GRADIENT_PEAK = np.sqrt(0.5)


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
            place = rows[dy] * cells[0] + columns[dx]
            corners[dx, dy] = cosines[place] * (fx - dx) + sines[place] * (fy - dy)
    sx, sy = _fade(fx), _fade(fy)
    low = corners[0, 0] + sx * (corners[1, 0] - corners[0, 0])
    high = corners[0, 1] + sx * (corners[1, 1] - corners[0, 1])
    return (low + sy * (high - low)) / GRADIENT_PEAK


def fractal_noise(
    u: np.ndarray, v: np.ndarray, cells: tuple[int, int], octaves: int, rng: np.random.Generator
) -> np.ndarray:
    """Return a sum of `gradient_noise`, each octave twice as fine and half as strong, within [-1, 1].

    Half the strength per octave gives the 1/f spectrum of Perlin, "An image synthesizer" (SIGGRAPH 1985).
    """
    total = np.zeros(np.broadcast(u, v).shape)
    for octave in range(octaves):
        total += gradient_noise(u, v, (cells[0] << octave, cells[1] << octave), rng) * 0.5**octave
    return total / (2.0 - 0.5 ** (octaves - 1))


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
    distance, index = cKDTree(points, boxsize=1.0).query(np.stack([u % 1.0, v % 1.0], -1), k=2)
    return index[..., 0], distance[..., 1] - distance[..., 0]


def smoothstep(low: float, high: float, value: np.ndarray) -> np.ndarray:
    """Return the cubic step from 0 at `low` to 1 at `high`."""
    t = np.clip((value - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _fade(t: np.ndarray) -> np.ndarray:
    # Perlin 2002: its first and second derivatives vanish at the lattice, so no creases show.
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
