"""What sticks to tables or was spilt on them, with an outline of its own: stickers, tape, stains."""

from __future__ import annotations

import numpy as np

from .grid import Grid, Layers, flat_layers, step
from .prints import Sheet, printed

#: Width of the ring that a wet foot leaves [m], and of the zone in which a stain's edge wanders, over its size [1].
FOOT, RAGGED = (0.002, 0.005), 0.06
#: How much a stain hides what is under it [1]: from a dried drop of tea to coffee.
STAINING = (0.25, 0.7)
#: How far the torn ends of a tape wander [m], and the period of hazard tape's stripes along it [m].
TORN, STRIPES = 0.0015, (0.04, 0.1)
#: How much of what is below is hidden by tape [1]: packing tape is clear, masking tape and vinyl are not.
OPACITY = (0.35, 1.0)


def sticker(grid: Grid, colours: np.ndarray) -> Layers:
    """Return a sticker, round or with rounded corners, of the first colour with a ring, a word and small text."""
    sheet, rng = Sheet(grid, colours[0]), grid.rng
    width, height = grid.width, grid.height
    if rng.random() < 0.5:
        sheet.rectangle(0.0, rng.uniform(0.2, 0.4) * height, width, rng.uniform(0.6, 0.8) * height, colours[1])
    if rng.random() < 0.5:
        sheet.ellipse(width / 2, height / 2, 0.45 * width, 0.45 * height, colours[2 % len(colours)], 0.85)
    sheet.word(0.15 * width, 0.38 * height, 0.7 * width, 0.24 * height, None, int(rng.integers(3, 8)))
    layers = printed(grid, sheet.colour)
    power = 2.0 if rng.random() < 0.5 else 10.0
    r = (np.abs(2 * grid.x / width - 1) ** power + np.abs(2 * grid.y / height - 1) ** power) ** (1.0 / power)
    edge = (1.0 - r) * min(width, height) / 2
    return Layers(layers.colour, layers.roughness, layers.height, _soft(edge, grid))


def tape(grid: Grid, colours: np.ndarray) -> Layers:
    """Return a strip of tape along x with torn ends: plain, with oblique stripes of two colours, or with words."""
    sheet, rng, kind = Sheet(grid, colours[0]), grid.rng, int(grid.rng.integers(4))
    if kind == 0:
        period = rng.uniform(*STRIPES)
        place = np.abs((grid.x + grid.y) % period - period / 2) - period / 4
        sheet.ink(_soft(place, grid), colours[1], slice(None), slice(None))
    elif kind == 1:
        step_ = 3.0 * grid.height
        for number in range(int(grid.width / step_)):
            sheet.word((number + 0.2) * step_, 0.25 * grid.height, 0.6 * step_, 0.5 * grid.height, None, 6)
    layers = printed(grid, sheet.colour)
    ends = np.minimum(grid.x, grid.width - grid.x) - TORN * (1.0 + np.clip(grid.noise((1.0, 0.004)), -1.0, 1.0))
    opacity = 1.0 if kind == 0 else rng.uniform(*OPACITY)
    return Layers(layers.colour, layers.roughness, layers.height, _soft(ends, grid) * np.float32(opacity))


def stain(grid: Grid, colours: np.ndarray) -> Layers:
    """Return a stain of the first colour: one ring or two of wet feet, or something spilt, darker at its edge."""
    rng, layers = grid.rng, flat_layers(grid, colours[0])
    half = 0.5 * min(grid.width, grid.height)
    wander = RAGGED * half * grid.noise(0.6 * half, 2)
    amount = np.zeros(grid.shape, np.float32)
    if rng.random() < 0.5:
        for _ in range(int(rng.integers(1, 3))):
            radius, width = rng.uniform(0.65, 0.9) * half, rng.uniform(*FOOT)
            away = 0.95 * half - radius
            x, y = (side / 2 + away * rng.uniform(-1.0, 1.0) for side in (grid.width, grid.height))
            ring = np.abs(np.hypot(grid.x - x, grid.y - y) - radius)
            part = step(0.2, -0.6, grid.noise(0.9 * half, 2)) * 0.8 + 0.2
            amount = np.maximum(amount, step(1.2 * width, 0.3 * width, ring + 0.2 * np.abs(wander)) * part)
    else:
        r = np.hypot((grid.x - grid.width / 2) / grid.width, (grid.y - grid.height / 2) / grid.height) * 2 * half
        edge = 0.72 * half - r + 3.0 * wander
        amount = step(-0.0006, 0.0012, edge) * (0.5 + 0.5 * step(0.006, 0.0, edge))
        amount = amount * step(half, 0.95 * half, r)
    amount = (amount * rng.uniform(*STAINING)).astype(np.float32)
    colour = layers.colour * (1.0 + 0.1 * grid.noise(0.4 * half, 2))[..., None]
    return Layers(colour, layers.roughness, layers.height, amount)


def _soft(distance: np.ndarray, grid: Grid) -> np.ndarray:
    """Return how much of each texel lies within an edge, from the distance inwards from it [m]; (h, w) float32."""
    amount = np.clip(distance / max(grid.texel) + 0.5, 0.0, 1.0)
    return np.ascontiguousarray(np.broadcast_to(amount, grid.shape), np.float32)
