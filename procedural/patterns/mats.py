"""Mats: cutting mats with a grid of centimetres, printed place mats, and rubber mats with ribs or studs."""

from __future__ import annotations

import numpy as np

from .grid import Grid, Layers, covered, flat_layers, step
from .plain import lacquer
from .prints import Sheet, printed

#: Distance of the lines of cutting mats [m], their half width, and that of every fifth [m]; the rim outside them [m].
GRID, THIN, BOLD, RIM = 0.010, 0.00015, 0.0004, (0.008, 0.016)
#: Height of the numbers along a cutting mat's rim [m].
DIGITS = 0.0035
#: Distance of ribs and studs of rubber mats, and their height [m]: bar mats have studs of 6-10 mm.
RIBS, RIB_HEIGHT = (0.003, 0.012), 0.0008


def cutting_mat(grid: Grid, colours: np.ndarray) -> Layers:
    """Return a cutting mat of the first colour, with lines of the last every 10 mm, bold ones every 50 mm."""
    base, rng = lacquer(grid, colours), grid.rng
    sheet = Sheet(grid, colours[0])
    rim = rng.uniform(*RIM)
    across, up = (int((side - 2 * rim) / GRID) for side in (grid.width, grid.height))
    left, low = 0.5 * (grid.width - across * GRID), 0.5 * (grid.height - up * GRID)
    lines = np.maximum(_lines(grid.x - left, across, grid.texel[0]), _lines(grid.y - low, up, grid.texel[1]))
    x, y = grid.x - left, grid.y - low
    inside = (x > -BOLD) & (x < across * GRID + BOLD) & (y > -BOLD) & (y < up * GRID + BOLD)
    sheet.ink((lines * inside).astype(np.float32), colours[-1], slice(None), slice(None))
    for number in range(0, across + 1, 5):
        sheet.word(left + number * GRID - 0.002, low - 1.5 * DIGITS, 0.005, DIGITS, colours[-1], 2)
    for number in range(0, up + 1, 5):
        sheet.word(left - 0.0065, low + number * GRID - 0.5 * DIGITS, 0.005, DIGITS, colours[-1], 2)
    if rng.random() < 0.5:
        sheet.word(left + 0.01, low + (up - 2.6) * GRID, 0.06, 0.012, colours[-1], int(rng.integers(4, 9)))
    return Layers(sheet.colour, base.roughness, base.height + 3e-6 * grid.noise(0.0018))


def place_mat(grid: Grid, colours: np.ndarray) -> Layers:
    """Return a printed place mat: a border, and rings, stripes, lozenges or dots of the other colours on the first."""
    sheet, rng = Sheet(grid, colours[0]), grid.rng
    _middle(sheet, colours)
    if rng.random() < 0.6:
        edge = np.minimum(np.minimum(grid.x, grid.width - grid.x), np.minimum(grid.y, grid.height - grid.y))
        place = 0.0
        for _ in range(int(rng.integers(1, 4))):
            place, half = place + rng.uniform(0.006, 0.02), rng.uniform(0.0005, 0.006)
            amount = covered(np.abs(edge - place), half, max(grid.texel))
            sheet.ink(amount, colours[int(rng.integers(1, len(colours)))], slice(None), slice(None))
    return printed(grid, sheet.colour)


def ribbed_rubber(grid: Grid, colours: np.ndarray) -> Layers:
    """Return a rubber mat of the first colour with ribs along x, ribs in a lattice, or studs."""
    rng, layers = grid.rng, flat_layers(grid, colours[0])
    pitch, kind = rng.uniform(*RIBS), int(rng.integers(3))
    x, y = (np.abs(place % pitch / pitch - 0.5) for place in (grid.x, grid.y))
    if kind == 0:
        raised = np.broadcast_to(step(0.15, 0.35, y), grid.shape)
    elif kind == 1:
        raised = step(0.25, 0.42, np.maximum(np.broadcast_to(x, grid.shape), y))
    else:
        raised = step(0.40, 0.25, np.hypot(x, y))
    shade = (0.72 + 0.38 * raised) * (1.0 + 0.05 * grid.noise(0.002) + 0.04 * grid.noise(0.05, 3))
    height = RIB_HEIGHT * min(1.0, pitch / 0.006) * raised
    return Layers(layers.colour * shade[..., None], layers.roughness, height.astype(np.float32))


def _lines(place: np.ndarray, count: int, texel: float) -> np.ndarray:
    """Return how much lines `GRID` apart cover texels at a place [m], every fifth and the last one bold."""
    number = np.clip(np.round(place / GRID), 0, count)
    distance = np.abs(place - number * GRID)
    bold = (number % 5 == 0) | (number == count)
    return np.where(bold, covered(distance, BOLD, texel), covered(distance, THIN, texel))


def _middle(sheet: Sheet, colours: np.ndarray) -> None:
    """Print what is within the border of a place mat."""
    grid, rng, kind = sheet.grid, sheet.rng, int(sheet.rng.integers(5))
    x, y = grid.x - grid.width / 2, grid.y - grid.height / 2
    pitch, soft = rng.uniform(0.012, 0.06), max(grid.texel)
    if kind == 0:  # rings
        r = np.hypot(x / grid.width, y / grid.height) * min(grid.width, grid.height)
        wave = np.abs(r % pitch - pitch / 2)
    elif kind == 1:  # stripes
        wave = np.broadcast_to(np.abs((x if rng.random() < 0.5 else y) % pitch - pitch / 2), grid.shape)
    elif kind == 2:  # lozenges
        wave = 0.5 * (np.abs((x + y) % pitch - pitch / 2) + np.abs((x - y) % pitch - pitch / 2))
    elif kind == 3:  # dots
        wave = np.hypot(x % pitch - pitch / 2, y % pitch - pitch / 2)
    else:  # clouds
        wave = np.abs(grid.noise(pitch, 3)) * 0.3 * pitch
    amount = np.clip((rng.uniform(0.1, 0.35) * pitch - wave) / soft + 0.5, 0.0, 1.0)
    sheet.ink(amount.astype(np.float32), colours[1], slice(None), slice(None))
