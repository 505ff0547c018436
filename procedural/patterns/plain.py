"""Surfaces of one material without a drawing: brushed metal, laminate, plastic, paper, glaze, foam, chequers."""

from __future__ import annotations

import numpy as np

from .grid import Grid, Layers, covered, flat_layers, ramp, step

#: Length and width of the marks of brushing [m]: grit 120-240 leaves lines of 0.05-0.2 mm, seen as bundles.
BRUSH = (0.06, 0.0004)
#: Distance of the waves of orange peel on lacquer and moulded plastic [m]; their height [m].
PEEL, PEEL_HEIGHT = 0.002, 1.5e-6
#: Side of a square of a chequered surface [m]: chess boards have 30-57 mm, oilcloth 10-40 mm.
SQUARE = (0.015, 0.05)
#: Diameters of the pores of cellulose sponges [m].
PORES = (0.0012, 0.004)


def brushed(grid: Grid, colours: np.ndarray) -> Layers:
    """Metal brushed along x."""
    lines = 0.7 * grid.noise(BRUSH) + 0.5 * grid.noise((BRUSH[0] / 3, 2 * BRUSH[1]))
    tone = 1.0 + 0.03 * lines + 0.02 * grid.noise(0.15, 2)
    layers = flat_layers(grid, colours[0])
    height = 6e-7 * lines * min(1.0, grid.texel[1] / BRUSH[1])
    return Layers(layers.colour * tone[..., None], 1.0 + 0.10 * lines + 0.08 * grid.noise(0.1, 3), height)


def polished_metal(grid: Grid, colours: np.ndarray) -> Layers:
    """Metal that was polished and then used: faint waves and hairlines in all directions."""
    layers = flat_layers(grid, colours[0])
    roughness = 1.0 + 0.25 * np.clip(grid.noise(0.02, 3), -1.5, 3.0)
    return Layers(layers.colour, roughness.astype(np.float32), 1e-6 * grid.noise(0.006))


def laminate(grid: Grid, colours: np.ndarray) -> Layers:
    """Laminate: fine speckles, or clouds, under a textured coat."""
    speckle = step(0.8, 1.4, grid.noise(0.0018)) - 0.6 * step(1.0, 1.6, grid.noise(0.003))
    tone = 0.5 + 0.35 * speckle + 0.06 * grid.noise(0.10, 4)
    grain = grid.noise(0.0022)
    return Layers(ramp(np.clip(tone, 0.0, 1.0), colours), 1.0 + 0.08 * grid.noise(0.08, 3), 2.5e-6 * grain)


def lacquer(grid: Grid, colours: np.ndarray) -> Layers:
    """Paint, enamel or moulded plastic of one colour, with orange peel."""
    layers = flat_layers(grid, colours[0])
    tone = 1.0 + 0.015 * grid.noise(0.05, 3)
    return Layers(layers.colour * tone[..., None], 1.0 + 0.10 * grid.noise(0.03, 3), PEEL_HEIGHT * grid.noise(PEEL))


def glaze(grid: Grid, colours: np.ndarray) -> Layers:
    """Glazed ceramic: the first colour, bands of the others, specks of iron, and a glaze of uneven thickness."""
    layers = flat_layers(grid, colours[0])
    specks = step(2.6, 3.0, grid.noise(0.0016)) * float(grid.rng.random() < 0.4)
    cloud = grid.noise(0.03, 3)
    colour = layers.colour * (1.0 + 0.02 * cloud - 0.6 * specks)[..., None]
    return Layers(colour, 1.0 + 0.12 * cloud, 4e-6 * grid.noise(0.008))


def paper(grid: Grid, colours: np.ndarray) -> Layers:
    """Paper or cardboard: fibres, and clouds of uneven pulp."""
    fibres = 0.5 * grid.noise((0.003, 0.0006)) + 0.5 * grid.noise((0.0006, 0.003))
    tone = 0.5 + 0.12 * fibres + 0.12 * grid.noise(0.01, 2) + 0.05 * grid.noise(0.06, 2)
    return Layers(ramp(np.clip(tone, 0.0, 1.0), colours), np.ones(grid.shape, np.float32), 6e-6 * fibres)


def page_edges(grid: Grid, colours: np.ndarray) -> Layers:
    """Leaves of a book at their cut edge, along x, in sections, of uneven tone."""
    leaves = 0.6 * grid.noise((0.3, 0.0005)) + 0.5 * grid.noise((0.15, 0.0012))
    sections = grid.noise((1.0, 0.004))
    tone = 0.5 + 0.18 * leaves + 0.10 * sections + 0.08 * grid.noise(0.03, 2)
    return Layers(ramp(np.clip(tone, 0.0, 1.0), colours), np.ones(grid.shape, np.float32), 4e-5 * leaves)


def foam(grid: Grid, colours: np.ndarray) -> Layers:
    """Sponge: open pores of several sizes."""
    pores = np.zeros(grid.shape, np.float32)
    for size in np.geomspace(*PORES, 3):
        pores = np.maximum(pores, step(0.9, 1.7, grid.noise(float(size))))
    shade = (1.0 - 0.6 * pores) * (1.0 + 0.05 * grid.noise(0.02, 2))
    return Layers(colours[0] * shade[..., None], np.ones(grid.shape, np.float32), -8e-4 * pores)


def fleece(grid: Grid, colours: np.ndarray) -> Layers:
    """Scouring fleece: fibres in a tangle, or rubber with a matt grain."""
    fibres = sum((np.abs(grid.noise(size)) for size in ((0.006, 0.0007), (0.0007, 0.006), (0.002, 0.002))), start=0.0)
    tone = np.clip(0.75 + 0.22 * (np.asarray(fibres, np.float32) - 1.5), 0.3, 1.4)
    return Layers(colours[0] * tone[..., None], np.ones(grid.shape, np.float32), 1.5e-4 * tone.astype(np.float32))


def chequer(grid: Grid, colours: np.ndarray) -> Layers:
    """Squares of two colours in turn."""
    size = grid.rng.uniform(*SQUARE)
    across, up = (2 * max(1, round(side / size / 2)) for side in (grid.width, grid.height))
    column, row = (grid.x / grid.width * across).astype(int), (grid.y / grid.height * up).astype(int)
    tone = 1.0 + grid.rng.normal(0.0, 0.03, (up, across))[row % up, column % across] + 0.02 * grid.noise(0.01, 3)
    colour = colours[(column + row) % 2] * tone[..., None]
    return Layers(colour.astype(np.float32), 1.0 + 0.08 * grid.noise(0.05, 2), PEEL_HEIGHT * grid.noise(PEEL))


def banded(grid: Grid, colours: np.ndarray) -> Layers:
    """Glaze with painted bands around it (along x) near the upper edge, as on plates and mugs."""
    layers = glaze(grid, colours)
    colour = layers.colour
    place = grid.height * grid.rng.uniform(0.70, 0.92)
    for number, paint in enumerate(colours[1:]):
        half = grid.rng.uniform(0.0006, 0.004)
        distance = np.abs(grid.y - place + 0.0002 * grid.noise((0.04, 1.0)))
        amount = covered(distance, half, grid.texel[1]) * (0.85 + 0.1 * np.clip(grid.noise(0.01), -1, 1))
        colour = colour + amount[..., None] * (paint.astype(np.float32) - colour)
        place -= 0.006 + 0.006 * number
    return Layers(colour, layers.roughness, layers.height)
