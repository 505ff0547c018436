"""Woven cloth: plain weave with threads of a stated width, in one colour, striped, checked, or with a border."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .grid import Grid, Layers

ColourIndex = Callable[[np.ndarray], np.ndarray]
"""From the places of threads [m] to the numbers of their colours."""

#: Width of a thread [m]: table linen has 12-25 threads per centimetre, coarse linen and canvas 8-12.
THREAD = (0.0005, 0.0012)
#: Width of a check or stripe [m]: gingham is sold with checks of 3-25 mm.
CHECK = (0.006, 0.03)
#: Spread of the tone of threads among each other, and of their height, relative to the width [1].
THREAD_TONE, RELIEF = 0.05, 0.16


def plain_weave(grid: Grid, colours: np.ndarray) -> Layers:
    """Cloth of one colour: warp of the first, weft of the second."""
    return _woven(grid, np.stack([colours[0], colours[-1]]), _one, _one)


def checked(grid: Grid, colours: np.ndarray) -> Layers:
    """Gingham: bands of two colours in warp and weft, which mix where they cross."""
    size = grid.rng.uniform(*CHECK)
    return _woven(grid, colours[:2], _bands(grid.width, size), _bands(grid.height, size))


def striped(grid: Grid, colours: np.ndarray) -> Layers:
    """Stripes of a second colour along y: groups of a wide and two narrow ones, as tea towels have."""
    repeat = grid.width / max(1, round(grid.width / grid.rng.uniform(0.06, 0.13)))
    wide, narrow = grid.rng.uniform(0.08, 0.2) * repeat, grid.rng.uniform(0.02, 0.04) * repeat

    def index(place: np.ndarray) -> np.ndarray:
        x = np.abs(place % repeat - repeat / 2)
        return ((x < wide) | (np.abs(x - 1.6 * wide) < narrow)).astype(int)

    return _woven(grid, colours[:2], index, _one)


def _one(place: np.ndarray) -> np.ndarray:
    return np.zeros(place.shape, int)


def _bands(length: float, size: float) -> ColourIndex:
    count = 2 * max(1, round(length / size / 2))
    return lambda place: (place / length * count).astype(int) % 2


def _woven(grid: Grid, colours: np.ndarray, warp_colour: ColourIndex, weft_colour: ColourIndex) -> Layers:
    """Return a plain weave; the functions give the number of a thread's colour from its place [m]."""
    rng = grid.rng
    wanted = rng.uniform(*THREAD)
    warps, wefts = (2 * max(2, round(side / wanted / 2)) for side in (grid.width, grid.height))
    wide, high = grid.width / warps, grid.height / wefts
    # Threads wander by a fraction of their width.
    x = (grid.x + 0.25 * wide * grid.noise((0.01, 0.04))) % grid.width
    y = (grid.y + 0.25 * high * grid.noise((0.04, 0.01))) % grid.height
    column, row = np.minimum((x / wide).astype(int), warps - 1), np.minimum((y / high).astype(int), wefts - 1)
    over = (column + row) % 2 == 0
    across, along = np.sin(np.pi * (x / wide % 1.0)), np.sin(np.pi * (y / high % 1.0))
    section = np.where(over, across * (0.55 + 0.45 * along), along * (0.55 + 0.45 * across)).astype(np.float32)
    # What is finer than a texel or two is seen as its mean.
    seen = np.float32(np.clip(min(wide / grid.texel[0], high / grid.texel[1]) / 2.0 - 0.4, 0.0, 1.0))
    tones = rng.normal(0.0, THREAD_TONE, (2, max(warps, wefts))).astype(np.float32)
    warp = colours[warp_colour((np.arange(warps) + 0.5) * wide)][column] * (1 + tones[0][column])[..., None]
    weft = colours[weft_colour((np.arange(wefts) + 0.5) * high)][row] * (1 + tones[1][row])[..., None]
    thread = np.where(over[..., None], warp, weft)
    thread = seen * thread + (1 - seen) * 0.5 * (warp + weft)
    shade = seen * (0.45 + 0.75 * section) + (1 - seen) * 0.9
    slub = 1.0 + 0.025 * grid.noise((0.004, 0.03)) + 0.03 * grid.noise(0.06, 2)
    colour = thread * (shade * slub)[..., None]
    height = RELIEF * min(wide, high) * section * seen + 2e-5 * grid.noise(0.006)
    return Layers(colour.astype(np.float32), np.ones(grid.shape, np.float32), height.astype(np.float32))
