"""Skins of fruit: patterns on the directions from a fruit's middle, so that nothing is stretched or has a pole.

A picture holds the six faces of a cube around the fruit, three across and two up, in the order of `cube_directions`.
"""

from __future__ import annotations

import numpy as np

from ..materials.noise import value_noise
from .grid import Grid, Layers, mixed, ramp, step

#: Distance of the oil glands in the peel of oranges and lemons, over the fruit's diameter [1]: 1-1.5 mm on 70 mm.
GLAND_SPACING = 0.017
#: Lenticels on an apple [1]: some hundred pale dots of under a millimetre.
LENTICELS = 500
#: Golden angle [rad]: turns from point to point of a spiral that covers a sphere evenly.
_GOLDEN = np.pi * (3.0 - np.sqrt(5.0))


def cube_directions(columns: int, rows: int) -> np.ndarray:
    """Return the unit directions of the texels of six cube faces, three across and two up, (rows, columns, 3).

    The outermost texels of a face lie on its edges, so that faces that meet have the same texels there: no seams.
    """
    s, t = (np.tan((np.linspace(0.0, 1.0, count) - 0.5) * np.pi / 2) for count in (columns // 3, rows // 2))
    out = np.empty((2, len(t), 3, len(s), 3))
    for face in range(6):
        axis, sign = face // 2, 1.0 if face % 2 == 0 else -1.0
        first, second = ((axis + 1) % 3, (axis + 2) % 3)[:: 1 if sign > 0 else -1]
        block = out[face // 3, :, face % 3]
        block[..., axis], block[..., first], block[..., second] = sign, s[None], t[:, None]
    directions = out.reshape(rows, columns, 3)
    return directions / np.linalg.norm(directions, axis=2, keepdims=True)


def citrus(grid: Grid, colours: np.ndarray) -> Layers:
    """Orange or lemon: the first colour, tinted towards the second at places, with glands as pits in the peel."""
    d = cube_directions(grid.columns, grid.rows)
    seed = int(grid.rng.integers(2**31))
    near = _nearest(_spiral(grid, GLAND_SPACING), d)
    pit = 1.0 - step(0.15, 0.75, near / np.float32(GLAND_SPACING))
    cloud = value_noise(d * 2.5, seed) + 0.5 * value_noise(d * 7.0, seed + 1) - 0.75
    colour = ramp(np.clip(0.35 + 0.9 * cloud, 0.0, 1.0), colours[:2])
    colour = colour * (1.0 - 0.16 * pit + 0.06 * (value_noise(d * 60.0, seed + 2) - 0.5))[..., None]
    # The calyx: a green-brown button at the top, and a scar at the bottom.
    colour = mixed(colour, colours[-1], step(0.09, 0.05, _from_axis(d)) * (d[..., 2] > 0))
    colour = mixed(colour, 0.5 * colours[-1], 0.6 * step(0.05, 0.02, _from_axis(d)) * (d[..., 2] < 0))
    return Layers(colour, (1.0 + 0.25 * pit).astype(np.float32), (-1.3e-4 * pit).astype(np.float32))


def apple(grid: Grid, colours: np.ndarray) -> Layers:
    """Apple: ground colour (first), blush of the second on the sunny side in streaks, russet (last) around the stem."""
    d = cube_directions(grid.columns, grid.rows)
    seed = int(grid.rng.integers(2**31))
    azimuth = np.arctan2(d[..., 1], d[..., 0])
    # Streaks run from stem to calyx: noise over the azimuth's circle, hardly over the height.
    ring = np.stack([np.cos(azimuth), np.sin(azimuth), 0.10 * d[..., 2]], -1)
    streaks = value_noise(ring * 34.0, seed) + 0.6 * value_noise(ring * 80.0, seed + 1) - 0.8
    sun = d @ _unit(grid.rng.normal(size=3) + np.array([0.0, 0.0, 0.5]))
    cover = grid.rng.uniform(-0.5, 0.8)
    blush = step(-0.5, 0.8, sun + cover + 0.9 * streaks + 0.7 * (value_noise(d * 3.0, seed + 2) - 0.5))
    ground = colours[0] * (1.0 + 0.25 * (value_noise(d * 4.0, seed + 3) - 0.5))[..., None]
    red = colours[1] * (1.0 + 0.35 * streaks)[..., None]
    colour = ground + blush[..., None] * (red - ground)
    dots = step(0.0075, 0.003, _nearest(_unit(grid.rng.normal(size=(LENTICELS, 3))), d))
    colour = mixed(colour, np.array((0.60, 0.48, 0.26)), 0.4 * dots)
    russet = step(0.42, 0.10, _from_axis(d) + 0.22 * streaks) * (d[..., 2] > 0)
    colour = mixed(colour, colours[-1], 0.8 * russet)
    rough = 1.0 + 0.8 * russet + 0.2 * (value_noise(d * 6.0, seed + 4) - 0.5)
    return Layers(colour.astype(np.float32), rough.astype(np.float32), (3e-5 * dots).astype(np.float32))


def banana(grid: Grid, colours: np.ndarray) -> Layers:
    """Banana along x: yellow, green towards the ends, dark tips, ridges along it, brown flecks where it is ripe."""
    ripe = grid.rng.uniform(0.0, 1.0)
    end = np.minimum(grid.x, grid.width - grid.x) / grid.width
    green = step(0.30, 0.0, end) * (1.0 - ripe) * 0.9 + 0.10 * np.clip(grid.noise((0.12, 0.03), 2), -1, 1)
    colour = ramp(np.clip(np.broadcast_to(green, grid.shape), 0.0, 1.0), colours[:2])
    ridge = np.abs((grid.y / grid.height * 5.0 + 0.5) % 1.0 - 0.5) / 5.0 * grid.height
    edge = step(0.0016, 0.0003, ridge + 0.0004 * grid.noise((0.03, 0.01)))
    colour = colour * (1.0 - 0.22 * edge)[..., None]
    flecks = step(1.9 - 0.7 * ripe, 2.6, grid.noise((0.006, 0.0025), 2)) + 0.5 * step(2.0, 2.6, grid.noise(0.0012))
    bruise = step(1.6 - 0.3 * ripe, 2.6, grid.noise((0.03, 0.015), 3)) * 0.6
    colour = mixed(colour, colours[-1], np.clip(0.8 * ripe * flecks + ripe * bruise + 0.25 * edge * ripe, 0.0, 0.9))
    tip = step(0.035, 0.015, end + 0.006 * grid.noise(0.01, 2))
    colour = mixed(colour, colours[-1], 0.9 * np.broadcast_to(tip, grid.shape))
    return Layers(colour.astype(np.float32), 1.0 + 0.1 * grid.noise(0.02, 2), 2e-5 * grid.noise(0.004))


def _spiral(grid: Grid, spacing: float) -> np.ndarray:
    """Return directions about `spacing` radians-over-two apart, jittered from a golden spiral, (n, 3)."""
    count = round(4.0 * np.pi / (2.0 * spacing) ** 2 / 0.87)
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    turn, r = _GOLDEN * np.arange(count), np.sqrt(1.0 - z * z)
    points = np.stack([r * np.cos(turn), r * np.sin(turn), z], 1)
    return _unit(points + grid.rng.normal(0.0, 0.35 * spacing, points.shape))


def _nearest(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return half of the distance of each direction from the nearest point [1], over a diameter of 1."""
    from scipy.spatial import cKDTree  # here, as it takes long to load

    distance, _ = cKDTree(points).query(directions.reshape(-1, 3), k=1)
    return (0.5 * distance).reshape(directions.shape[:2]).astype(np.float32)


def _from_axis(directions: np.ndarray) -> np.ndarray:
    return np.hypot(directions[..., 0], directions[..., 1]).astype(np.float32)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
