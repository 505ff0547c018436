"""What every pattern starts from: a grid of texels in metres, noise on it with features of a stated size, and wear."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Standard deviation of each octave of noise over that of the one before [1]: a 1/f spectrum.
_OCTAVE = 0.5
#: Mean distance between zeros of a cubic B-spline through independent numbers, over the distance of its knots [1]:
#: Rice's formula, pi sqrt(-R(0) / R''(0)), where the autocorrelation R is the B-spline of degree 7, R(0) = 2416/5040
#: and R''(0) = -2/3.
_FEATURE = 2.664
#: Standard deviation of that spline in two dimensions, over that of the numbers and averaged over its phase [1]: R(0).
_SPREAD = 2416.0 / 5040.0


@dataclass(frozen=True, eq=False)
class Grid:
    """The texels of one repeat of a pattern.

    Parameters
    ----------
    width, height : float
        What the picture shows [m].
    columns, rows : int
        Its size [px]; row 0 is the lower edge.
    rng : numpy.random.Generator
        Source of everything random in the pattern.
    wear : float
        0 new, 1 worn.
    layout : tuple of float
        What a print is laid out for (`SurfaceTexture.layout`).
    """

    width: float
    height: float
    columns: int
    rows: int
    rng: np.random.Generator
    wear: float = 0.0
    layout: tuple[float, ...] = ()

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.rows, self.columns

    @property
    def texel(self) -> tuple[float, float]:
        """Size of a texel along x and y [m]."""
        return self.width / self.columns, self.height / self.rows

    @property
    def x(self) -> np.ndarray:
        """Places of the texels' centres along x, (1, columns) float32 [m]."""
        return ((np.arange(self.columns, dtype=np.float32) + 0.5) * np.float32(self.texel[0]))[None]

    @property
    def y(self) -> np.ndarray:
        """Places of the texels' centres along y, (rows, 1) float32 [m]."""
        return ((np.arange(self.rows, dtype=np.float32) + 0.5) * np.float32(self.texel[1]))[:, None]

    def noise(self, size: float | tuple[float, float], octaves: int = 1) -> np.ndarray:
        """Return noise with features of a size along x and y [m], periodic, of about unit variance; float32.

        A feature goes from one zero to the next. It is a uniform cubic B-spline through random numbers. Octaves whose
        features are below a texel are left out, because they would only be grain.
        """
        wide, high = (size, size) if isinstance(size, int | float) else size
        total, weight, power = np.zeros(self.shape, np.float32), 1.0, 0.0
        for octave in range(octaves):
            cells = [
                max(1, round(_FEATURE * side / feature * 2**octave))
                for side, feature in ((self.width, wide), (self.height, high))
            ]
            if octave and (cells[0] > self.columns and cells[1] > self.rows):
                break
            total += np.float32(weight) * self._spline(min(cells[0], self.columns), min(cells[1], self.rows))
            power += weight**2
            weight *= _OCTAVE
        return total / np.float32(np.sqrt(power))

    def _spline(self, across: int, up: int) -> np.ndarray:
        lattice = self.rng.standard_normal((up, across), dtype=np.float32)
        return _stretched(_stretched(lattice, self.rows, 0), self.columns, 1) / np.float32(_SPREAD)

    def white(self) -> np.ndarray:
        """Return independent normal numbers for all texels, (rows, columns) float32."""
        return self.rng.standard_normal(self.shape, dtype=np.float32)


@dataclass(frozen=True, eq=False)
class Layers:
    """What a pattern says of each texel; the first row is the lower edge.

    Parameters
    ----------
    colour : (h, w, 3) float32
        Reflectance, linear Rec.709; clipped by the caller.
    roughness : (h, w) float32
        Factor on the material's roughness.
    height : (h, w) float32
        Relief [m].
    coverage : (h, w) float32, optional
        How much of a texel hides what lies below it [1]; without it all of each.
    """

    colour: np.ndarray
    roughness: np.ndarray
    height: np.ndarray
    coverage: np.ndarray | None = None


def flat_layers(grid: Grid, colour: np.ndarray) -> Layers:
    """Return layers of a colour, (3,) or (h, w, 3), that is even in roughness and flat."""
    shade = np.broadcast_to(np.asarray(colour, np.float32), (*grid.shape, 3)).copy()
    return Layers(shade, np.ones(grid.shape, np.float32), np.zeros(grid.shape, np.float32))


def step(low: float, high: float, value: np.ndarray) -> np.ndarray:
    """Return the cubic step from 0 at `low` to 1 at `high`, float32."""
    t = np.clip((value - np.float32(low)) / np.float32(high - low), 0.0, 1.0)
    return (t * t * (3.0 - 2.0 * t)).astype(np.float32)


def covered(distance: np.ndarray, half: float, texel: float) -> np.ndarray:
    """Return how much of each texel a line covers [1], from the distance to its middle and half of its width [m]."""
    return np.clip((half - distance) / texel + 0.5, 0.0, min(1.0, 2.0 * half / texel)).astype(np.float32)


def ramp(t: np.ndarray, colours: np.ndarray) -> np.ndarray:
    """Return the colours interpolated along `t` in [0, 1], first to last, in linear light; (..., 3) float32."""
    knots = np.linspace(0.0, 1.0, len(colours))
    return np.stack([np.interp(t, knots, colours[:, channel]) for channel in range(3)], -1).astype(np.float32)


def mixed(colour: np.ndarray, other: np.ndarray, amount: np.ndarray) -> np.ndarray:
    """Return `colour` (h, w, 3) with an amount (h, w) of another colour over it."""
    return colour + amount[..., None] * (np.asarray(other, np.float32) - colour)


def sampled(picture: np.ndarray, grid: Grid, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return a picture of the grid at other places [m], bilinear and repeated at its edges."""
    column, row = x / np.float32(grid.texel[0]) - 0.5, y / np.float32(grid.texel[1]) - 0.5
    left, below = np.floor(column).astype(np.int32), np.floor(row).astype(np.int32)
    fx, fy = column - left, row - below
    left, right = left % grid.columns, (left + 1) % grid.columns
    below, above = below % grid.rows, (below + 1) % grid.rows
    low = picture[below, left] * (1 - fx) + picture[below, right] * fx
    high = picture[above, left] * (1 - fx) + picture[above, right] * fx
    return low * (1 - fy) + high * fy


def _stretched(lattice: np.ndarray, count: int, axis: int) -> np.ndarray:
    """Return the periodic uniform cubic B-spline through lattice values along an axis, at `count` texels' centres."""
    cells = lattice.shape[axis]
    place = (np.arange(count) + 0.5) * (cells / count)
    base = np.floor(place).astype(np.int64)
    t = (place - base).astype(np.float32)
    weights = ((1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3)
    shape = (-1, 1) if axis == 0 else (1, -1)
    total = None
    for shift, weight in enumerate(weights):
        part = np.take(lattice, (base + shift - 1) % cells, axis) * (weight / np.float32(6.0)).reshape(shape)
        total = part if total is None else total + part
    assert total is not None
    return total
