"""Wood: boards cut from trunks, so that the grain runs along them, in arches or in lines, as the cut gives it."""

from __future__ import annotations

import numpy as np

from .grid import Grid, Layers, covered, ramp, step

#: Widths of the boards of a top [m]: of planks, and of the staves of glued worktops (40-45 mm in the trade), and the
#: lengths of staves [m].
PLANK_WIDTH, STAVE_WIDTH, STAVE_LENGTH = (0.07, 0.18), (0.038, 0.05), (0.2, 0.7)
#: Growth rings of temperate woods are 1-6 mm apart (Hoadley, "Understanding Wood", 2000) [m].
RING_SPACING = (0.002, 0.006)
#: Depth of the pith below the board's face, and its offset over the board's width: near and under the board the cut
#: shows arches, far beside it straight lines. [m], [1]
PITH_DEPTH, PITH_OFFSET = (0.01, 0.09), 1.6
#: How much the trunk's axis leans from the board's face [rad]: of this the arches' length comes.
PITH_SLOPE = 0.05
#: Half of the width of a joint [m]: glued joints are hairlines, planks have gaps of a millimetre.
GLUED, GAP = 0.00015, (0.0005, 0.001)
#: Length and width of pores [m]: vessels of oak and ash, cut lengthwise.
PORE = (0.012, 0.001)
#: Spread of the tone of boards among each other [1].
BOARD_TONE = 0.14


def planks(grid: Grid, colours: np.ndarray) -> Layers:
    """Boards side by side over the whole length of the picture, with narrow gaps."""
    width = grid.rng.uniform(*PLANK_WIDTH)
    return _boards(grid, colours, width, None, grid.rng.uniform(*GAP))


def staves(grid: Grid, colours: np.ndarray) -> Layers:
    """Short staves glued to a panel, as worktops are made."""
    return _boards(grid, colours, grid.rng.uniform(*STAVE_WIDTH), STAVE_LENGTH, GLUED)


def solid_wood(grid: Grid, colours: np.ndarray) -> Layers:
    """One piece of wood or veneer, without joints."""
    return _boards(grid, colours, 4.0 * grid.height, None, 0.0)


def _boards(grid: Grid, colours: np.ndarray, width: float, lengths: tuple[float, float] | None, gap: float) -> Layers:
    # Twice the rows, averaged in the end: rings are hardly wider than a texel.
    fine = Grid(grid.width, grid.height, grid.columns, 2 * grid.rows, grid.rng, grid.wear)
    count = max(1, round(fine.height / width))
    board, across, along = _layout(fine, count, lengths)
    ring, radius_slope = _rings(fine, board, across, fine.height / count)
    fibres = fine.noise((0.12, 0.003)) * 0.5 + fine.noise((0.6, 0.015)) * 0.5
    pores = step(1.1, 2.0, fine.noise(PORE))
    tone = fine.rng.normal(0.0, BOARD_TONE, int(board.max()) + 1).astype(np.float32)[board]
    tone = tone + 0.22 + 0.42 * ring + 0.10 * fibres + 0.10 * fine.noise((1.2, 0.12)) + 0.30 * pores * radius_slope
    colour = ramp(np.clip(tone, 0.0, 1.0), colours)
    joint = covered(across, gap, fine.texel[1]) if gap else np.zeros(fine.shape, np.float32)
    if along is not None:
        joint = np.maximum(joint, covered(along, GLUED, fine.texel[0]))
    colour = colour * (1.0 - 0.85 * joint)[..., None]
    roughness = 1.0 + 0.12 * fibres - 0.1 * ring + 0.35 * pores + 0.3 * joint
    height = 1e-5 * ring - 4e-5 * pores + 6e-6 * fibres
    if gap > GLUED:
        height = height - 3e-4 * step(0.0025, 0.0, across) - 4e-4 * joint
    return Layers(*(_halved(layer) for layer in (colour, roughness.astype(np.float32), height.astype(np.float32))))


def _layout(
    grid: Grid, count: int, lengths: tuple[float, float] | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Return the number of each texel's board, the distance from its long edges and, of staves, from their ends [m]."""
    width = grid.height / count
    row = np.minimum((grid.y / width).astype(int), count - 1)
    inside = grid.y - row * np.float32(width)
    across = np.broadcast_to(np.minimum(inside, np.float32(width) - inside), grid.shape)
    if count == 1:
        across = np.full(grid.shape, np.float32(1.0))
    if lengths is None:
        return np.broadcast_to(row, grid.shape), across, None
    board, along, first = np.empty(grid.shape, int), np.empty(grid.shape, np.float32), 0
    for number in range(count):
        pieces = max(1, round(grid.width / grid.rng.uniform(*lengths)))
        ends = np.sort((np.arange(pieces) + grid.rng.uniform(0.1, 0.9, pieces)) * (grid.width / pieces))
        index = np.searchsorted(ends, grid.x[0])
        near = np.abs(grid.x[0][:, None] - np.concatenate([ends, ends - grid.width, ends + grid.width])).min(1)
        here = row[:, 0] == number
        board[here], along[here] = first + index % pieces, near
        first += pieces
    return board, across, along


def _rings(grid: Grid, board: np.ndarray, across: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the growth rings [0, 1], late wood 1, and how far each texel is from a cut along the rings [0, 1]."""
    rng, boards = grid.rng, int(board.max()) + 1
    offset = rng.uniform(-PITH_OFFSET, PITH_OFFSET, boards) * min(width, 0.3)
    depth = np.exp(rng.uniform(np.log(PITH_DEPTH[0]), np.log(PITH_DEPTH[1]), boards))
    slope, spacing = rng.normal(0.0, PITH_SLOPE, boards), rng.uniform(*RING_SPACING, boards)
    middle = np.floor(grid.y / np.float32(width)) * width + width / 2 if width < grid.height else grid.height / 2
    y = (grid.y - middle + offset[board]).astype(np.float32)
    z = (depth[board] + slope[board] * grid.x + 0.006 * grid.noise((1.2, 0.5))).astype(np.float32)
    radius = np.sqrt(y * y + z * z)
    wavy = radius + 0.0022 * grid.noise((0.55, 0.08)) + 0.0006 * grid.noise((0.15, 0.02))
    phase = wavy / spacing[board].astype(np.float32) % 1.0
    # A ring darkens slowly through the summer and ends abruptly in winter.
    ring = phase**2 * (1.0 - step(0.86, 1.0, phase))
    # Rings finer than two texels would only be moire.
    seen = step(1.2, 3.0, spacing[board] / grid.texel[1]) * np.float32(1.0)
    return ring * seen + 0.3 * (1.0 - seen), (np.abs(z) / np.maximum(radius, 1e-4)).astype(np.float32)


def _halved(layer: np.ndarray) -> np.ndarray:
    return 0.5 * (layer[0::2] + layer[1::2])
