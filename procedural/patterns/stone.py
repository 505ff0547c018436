"""Stone and tiles: granite, marble, concrete, terrazzo-like chips, tiles with joints."""

from __future__ import annotations

import numpy as np

from .grid import Grid, Layers, covered, flat_layers, mixed, ramp, sampled, step

#: Sizes of the grains of granite [m]: medium-grained rock has 1-5 mm (Le Maitre, "Igneous Rocks", 2002).
GRAIN = (0.0025, 0.006)
#: Sides of wall and worktop tiles sold [m], and the width of their joints (EN 13888: 2-5 mm for glazed tiles) [m].
TILE_SIDES, JOINT = (0.05, 0.10, 0.15, 0.20), (0.002, 0.004)
#: Rounding of a tile's edge, and depth of the joint below its face [m].
TILE_EDGE, JOINT_DEPTH = 0.002, 0.0007
#: Spread of the tone of tiles among each other [1].
TILE_TONE = 0.05


def granite(grid: Grid, colours: np.ndarray) -> Layers:
    """Polished granite: grains of each colour, which keep to a size, with dark mica between them."""
    size = grid.rng.uniform(*GRAIN)
    fields = [grid.noise(size * factor, 2) for factor in np.linspace(1.0, 0.6, len(colours))]
    # The last mineral is mica: smaller and rarer than the others.
    fields[-1] = fields[-1] - 0.8
    ranked = np.argmax(fields, axis=0)
    colour = colours[ranked].astype(np.float32) * (1.0 + 0.10 * grid.noise(0.0015)[..., None])
    colour *= 1.0 + 0.05 * grid.noise(0.12)[..., None]
    roughness = np.where(ranked == len(colours) - 1, np.float32(1.3), np.float32(1.0))
    return Layers(colour, roughness, np.zeros(grid.shape, np.float32))


def marble(grid: Grid, colours: np.ndarray) -> Layers:
    """Polished marble: clouds of the first colours, veins of the last one along folded noise."""
    dx, dy = (0.05 * grid.noise(0.9, 3) for _ in range(2))
    x, y = grid.x + dx, grid.y + dy
    clouds = sampled(grid.noise(0.6, 4), grid, x, y)
    bold = np.abs(sampled(grid.noise((1.2, 0.75), 4), grid, x, y))
    fine = np.abs(sampled(grid.noise(0.35, 3), grid, x, y))
    veins = 0.75 * (1.0 - step(0.0, 0.09, bold)) + 0.35 * (1.0 - step(0.0, 0.06, fine))
    halo = 0.25 * (1.0 - step(0.0, 0.5, bold))
    fade = step(-0.8, 1.2, grid.noise(0.75, 2))
    ground = ramp(np.clip(0.35 + 0.22 * clouds, 0.0, 1.0), colours[:-1])
    colour = mixed(ground, colours[-1], np.clip((veins + halo) * fade, 0.0, 0.9))
    return Layers(colour, 1.0 + 0.15 * veins * fade, np.zeros(grid.shape, np.float32))


def concrete(grid: Grid, colours: np.ndarray) -> Layers:
    """Cast concrete or mineral plaster: clouds, fine sand and a few open pores."""
    sand = grid.noise(0.0018)
    pores = step(2.4, 2.9, grid.noise(0.004))
    tone = 0.5 + 0.16 * grid.noise(0.40, 4) + 0.07 * sand
    colour = ramp(np.clip(tone, 0.0, 1.0), colours) * (1.0 - 0.45 * pores)[..., None]
    return Layers(colour, 1.0 + 0.08 * grid.noise(0.1, 2), 2e-5 * sand - 5e-4 * pores)


def terrazzo(grid: Grid, colours: np.ndarray) -> Layers:
    """Stone chips of the later colours, 2-12 mm wide, in a ground of the first; ground and polished."""
    layers = flat_layers(grid, colours[0])
    colour = layers.colour * (1.0 + 0.03 * grid.noise(0.002)[..., None])
    for size, threshold in ((0.003, 1.25), (0.007, 1.15), (0.013, 1.2)):
        for stone in colours[1:]:
            field = grid.noise(size * grid.rng.uniform(0.8, 1.2))
            chip = step(threshold + 0.35, threshold + 0.5, field)
            shade = stone * (1.0 + 0.12 * grid.noise(2 * size)[..., None])
            colour = colour + chip[..., None] * (shade.astype(np.float32) - colour)
    return Layers(colour, layers.roughness, layers.height)


def tiles(grid: Grid, colours: np.ndarray) -> Layers:
    """Glazed tiles of the first colours with joints of the last, square or in brick bond."""
    rng = grid.rng
    side = float(rng.choice([side for side in TILE_SIDES if side <= min(grid.width, grid.height) / 2]))
    bond, joint = rng.random() < 0.3, rng.uniform(*JOINT)
    up = 2 * max(1, round(grid.height / side / 2)) if bond else max(1, round(grid.height / side))
    across = max(1, round(grid.width / side / (2.0 if bond else 1.0)))
    wide, high = grid.width / across, grid.height / up
    row = np.minimum((grid.y / high).astype(int), up - 1)
    x = (grid.x + (0.5 * wide * (row % 2) if bond else 0.0)) % grid.width
    column = np.minimum((x / wide).astype(int), across - 1)
    inside_x, inside_y = x - column * wide, grid.y - row * high
    edge = np.minimum(np.minimum(inside_x, wide - inside_x), np.minimum(inside_y, high - inside_y))
    grout = covered(edge, joint / 2, max(grid.texel))
    tone = 1.0 + rng.normal(0.0, TILE_TONE, (up, across))[row, column] + 0.02 * grid.noise(0.05, 3)
    kinds = rng.integers(0, max(1, len(colours) - 1), (up, across))[row, column]
    glaze = colours[kinds] * tone[..., None]
    sand = colours[-1] * (1.0 + 0.08 * grid.noise(0.0015) + 0.06 * grid.noise(0.15, 2))[..., None]
    colour = glaze + grout[..., None] * (sand - glaze)
    # Cushioned tiles: each lies a little askew, and its edge is rounded.
    tilt = rng.normal(0.0, 0.0015, (2, up, across))
    height = tilt[0][row, column] * (inside_x - wide / 2) + tilt[1][row, column] * (inside_y - high / 2)
    height = height - JOINT_DEPTH * step(joint / 2 + TILE_EDGE, joint / 2, edge) + 4e-6 * grid.noise(0.012)
    return Layers(colour.astype(np.float32), (1.0 + 3.0 * grout).astype(np.float32), height.astype(np.float32))
