"""Square markers and calibration boards: black and white cells in a border, at random and of no dictionary."""

from __future__ import annotations

import numpy as np

from .grid import Grid, Layers
from .prints import Sheet, printed

#: White around a single marker, over the side of a cell [1]: detectors want one cell; scissors leave less.
QUIET = (0.25, 1.2)
#: Fraction of white cells inside a marker [1].
WHITE = (0.35, 0.65)
#: Side of a square of a board [m] (10-60 mm are common), and the white rim around the squares [m].
SQUARE, RIM = (0.012, 0.06), (0.005, 0.02)
#: Cells across markers of boards, with their borders [1]: 4 to 6 of data, as the common families have.
CELLS = (6, 9)
#: Diameter of the dots of a board over their distance [1].
DOT = (0.4, 0.7)


def marker(grid: Grid, colours: np.ndarray) -> Layers:
    """Return one marker, black on white, centred, with a white rim; its layout is its cells across, border included.

    The first colour is the paper, the last the ink.
    """
    cells = round(grid.layout[0])
    side = min(grid.width, grid.height)
    cell = side / (cells + 2.0 * grid.rng.uniform(*QUIET))
    sheet = Sheet(grid, colours[0])
    left, low = (0.5 * (whole - cell * cells) for whole in (grid.width, grid.height))
    sheet.stamp(marker_cells(grid.rng, cells), left, low, cell, colours[-1])
    return printed(grid, sheet.colour)


def marker_board(grid: Grid, colours: np.ndarray) -> Layers:
    """Return a board: markers in rows, a chessboard with markers or without, or dots; colours as for `marker`."""
    rng, sheet = grid.rng, Sheet(grid, colours[0])
    rim, square = rng.uniform(*RIM), min(rng.uniform(*SQUARE), min(grid.width, grid.height) / 4.0)
    across, up = (max(2, int((side - 2 * rim) / square)) for side in (grid.width, grid.height))
    left, low = 0.5 * (grid.width - across * square), 0.5 * (grid.height - up * square)
    kind = ("markers", "markers", "both", "chess", "dots")[int(rng.integers(5))]
    if kind == "dots":
        _dots(sheet, (left, low), square, (across, up), colours[-1])
        return printed(grid, sheet.colour)
    cells = int(rng.integers(*CELLS))
    picture = np.concatenate(
        [np.concatenate([_square(rng, kind, cells, (i + j) % 2) for i in range(across)], 1) for j in range(up)]
    )
    sheet.stamp(picture, left, low, square / (cells + 2), colours[-1])
    return printed(grid, sheet.colour)


def marker_cells(rng: np.random.Generator, cells: int) -> np.ndarray:
    """Return the ink of a marker's cells, (cells, cells) float32 of 0 and 1: a dark border, and random cells in it.

    Some inner cells are dark and some are white, whatever is drawn.
    """
    ink = np.ones((cells, cells), np.float32)
    inner = (cells - 2) ** 2
    dark = np.ones(inner, np.float32)
    dark[: int(np.clip(round(inner * rng.uniform(*WHITE)), 1, inner - 1))] = 0.0
    ink[1:-1, 1:-1] = rng.permutation(dark).reshape(cells - 2, cells - 2)
    return ink


def _square(rng: np.random.Generator, kind: str, cells: int, odd: int) -> np.ndarray:
    """Return the ink of a square of a board, a cell wider on each side than its marker."""
    square = np.zeros((cells + 2, cells + 2), np.float32)
    if kind != "markers" and odd:
        square[:] = 1.0
    elif kind != "chess":
        square[1:-1, 1:-1] = marker_cells(rng, cells)
    return square


def _dots(
    sheet: Sheet, corner: tuple[float, float], distance: float, count: tuple[int, int], colour: np.ndarray
) -> None:
    """Print a lattice of dots, all of one size."""
    grid, radius = sheet.grid, 0.5 * distance * sheet.rng.uniform(*DOT)
    x, y = grid.x - corner[0], grid.y - corner[1]
    r = np.hypot(x % distance - distance / 2, y % distance - distance / 2)
    within = (x > 0) & (x < count[0] * distance) & (y > 0) & (y < count[1] * distance)
    amount = np.clip((radius - r) / max(grid.texel) + 0.5, 0.0, 1.0) * within
    sheet.ink(amount.astype(np.float32), colour, slice(None), slice(None))
