"""Procedural rooms: drawn from a seed. `room_map` bakes them to a map of radiance.

Radiance is in kcd/m^2. It comes from real figures: an overcast sky of 10 to 25 klx has a mean luminance of 3 to 8
(E / pi); a 0.6 m square ceiling panel of 3500 lm has 3.1 (flux / (pi A)); a studio soft box of 10000 lm and 0.6 x 0.9 m
has 5.9 (`lamps` has the ranges). The light on the walls follows from these by `room_light`.

The ranges below are chosen, where no source is given, so that furnished rooms from a kitchen to a hall are covered.
"""

from __future__ import annotations

import numpy as np

from ...core.model import Reflectance
from ..description.surroundings import Block, Panel, RoomEnvironment, Wall, Window
from .colour import black_body
from .lamps import LAMPS

#: Height of the table top over the floor [m] (dining and work tables: 0.72 to 0.76).
TABLE_HEIGHT = 0.74
# Side and height of a room [m], and the place of the table as a fraction of the sides.
_ROOM_SIDE, _ROOM_HEIGHT, _TABLE_PLACE = (3.5, 9.0), (2.4, 3.6), (0.35, 0.65)
# Width of floor boards [m]; parquet strips to wide planks.
_BOARD_WIDTH = (0.08, 0.25)

# Reflectance of wall paint, of an accent wall and of a ceiling (EN 12464-1 recommends walls of 0.5 to 0.8 and ceilings
# of 0.7 to 0.9), and the largest relative deviation of a primary from grey.
_WALL_PAINT, _WALL_CHROMA = (0.45, 0.8), 0.08
_ACCENT_PAINT, _ACCENT_CHROMA, _ACCENT_PROBABILITY = (0.1, 0.5), 0.4, 0.4
_CEILING_PAINT, _CEILING_CHROMA = (0.75, 0.85), 0.02
# No paint reflects less than black velvet or more than fresh white paint.
_PAINT_LIMITS = (0.02, 0.9)
# Green reflectance of wood from dark walnut to pale ash; relative excess of red and deficit of blue at warmth 1.
_WOOD_LEVEL, _WOOD_WARMTH, _WOOD_RED, _WOOD_BLUE = (0.08, 0.45), (0.2, 0.6), 0.4, 0.8

# Colour temperature [K] (overcast 5500 to clear shade 8000) and luminance [kcd/m^2] of the sky outside.
_SKY_TEMPERATURE, _SKY_RADIANCE = (5500.0, 8000.0), (2.5, 8.0)
# Windows: least pitch of a row [m], width over pitch, sill of a French window and of others [m], height [m], distance
# of the lintel to the ceiling [m], largest number of mullions.
_WINDOW_PITCH, _WINDOW_FILL = 1.5, (0.45, 0.85)
_LOW_SILL, _SILL, _WINDOW_HEIGHT, _LINTEL, _MOST_BARS = 0.1, (0.7, 1.0), (1.2, 2.2), 0.25, 3
# Walls with windows: at most 2.
_MOST_WINDOW_WALLS = 2
# Ceiling lamps: probability, sides of the usual panels [m], their spacing [m] and colour temperature [K] (warm white to
# daylight white); their flux is that of `lamps.LAMPS`.
_LAMP_PROBABILITY, _LAMP_SIZES = 0.6, ((0.6, 0.6), (1.2, 0.3), (0.3, 1.2), (1.2, 0.6))
_LAMP_SPACING, _LAMP_TEMPERATURE = (1.8, 3.0), (3300.0, 5500.0)
# Soft boxes: probability, side [m], place along the wall as a fraction, height of the centre over the floor and its
# distance to the ceiling [m], colour temperature [K]; their flux is that of `lamps.LAMPS`.
_SOFT_BOX_PROBABILITY, _SOFT_BOX_SIDE, _SOFT_BOX_PLACE = 0.3, (0.5, 1.2), (0.25, 0.75)
_SOFT_BOX_HEIGHT, _SOFT_BOX_TOP = 1.2, 0.7
_SOFT_BOX_TEMPERATURE = (4000.0, 6500.0)

# Doors and pictures on walls without windows: distance from the corner [m], least free length [m], gap between two [m].
_PANEL_START, _PANEL_ROOM, _PANEL_GAP = (0.2, 0.6), 0.6, (0.3, 1.5)
# A door leaf is about 0.9 x 2.05 m.
_DOOR_PROBABILITY, _DOOR_WIDTH, _DOOR_HEIGHT = 0.25, 0.9, 2.05
# Pictures: width, height and height of the centre over the floor [m] (hung at eye height); width of the frame [m];
# reflectance and chroma of frame and picture.
_PICTURE_WIDTH, _PICTURE_HEIGHT, _PICTURE_CENTRE, _FRAME_WIDTH = (0.3, 1.1), (0.3, 0.9), (1.3, 1.7), 0.03
_FRAME_PAINT, _FRAME_CHROMA, _PICTURE_PAINT, _PICTURE_CHROMA = (0.05, 0.2), 0.2, (0.1, 0.7), 0.35

# Furniture along the walls: number, depth and width [m], usual heights [m] (bench, sideboard, shelf, cupboard), their
# relative spread, greatest height in front of windows [m]; probability of wood, reflectance and chroma of paint.
_BLOCK_COUNT, _BLOCK_DEPTH, _BLOCK_WIDTH = (3, 7), (0.3, 0.7), (0.4, 1.8)
_BLOCK_HEIGHTS, _BLOCK_SPREAD, _BLOCK_UNDER_WINDOW = (0.45, 0.8, 1.2, 1.9), (0.85, 1.1), 0.8
_BLOCK_WOOD_PROBABILITY, _BLOCK_PAINT, _BLOCK_CHROMA = 0.5, (0.1, 0.7), 0.2

_SIDES: tuple[Wall, Wall, Wall, Wall] = ("+x", "-x", "+y", "-y")


def draw_room(rng: np.random.Generator) -> RoomEnvironment:
    """Draw a room with windows, lamps, wall panels and furniture; the table stands well inside."""
    size = (float(rng.uniform(*_ROOM_SIDE)), float(rng.uniform(*_ROOM_SIDE)), float(rng.uniform(*_ROOM_HEIGHT)))
    eye = (size[0] * float(rng.uniform(*_TABLE_PLACE)), size[1] * float(rng.uniform(*_TABLE_PLACE)), TABLE_HEIGHT)
    windows = draw_windows(rng, size)
    return RoomEnvironment(
        size=size,
        eye=eye,
        wall_colours=draw_colours(rng),
        windows=windows,
        panels=draw_panels(rng, size, windows),
        blocks=_draw_blocks(rng, size, windows),
        board_width=float(rng.choice([0.0, rng.uniform(*_BOARD_WIDTH)])),
        seed=int(rng.integers(2**31)),
        rotation=float(rng.uniform(0.0, 2.0 * np.pi)),
    )


def draw_colours(rng: np.random.Generator) -> tuple[Reflectance, ...]:
    """Draw the reflectance of walls, ceiling and floor: light paint, in some rooms one wall of a strong colour."""
    wall = paint(rng, _WALL_PAINT, _WALL_CHROMA)
    walls = [wall] * 4
    if rng.uniform() < _ACCENT_PROBABILITY:
        walls[int(rng.integers(4))] = paint(rng, _ACCENT_PAINT, _ACCENT_CHROMA)
    return (*walls, paint(rng, _CEILING_PAINT, _CEILING_CHROMA), wood(rng))


def paint(rng: np.random.Generator, level: tuple[float, float], chroma: float) -> Reflectance:
    """Draw a paint: a grey level from a range, with each primary off by up to the fraction ``chroma``."""
    colour = rng.uniform(*level) * (1.0 + chroma * rng.uniform(-1.0, 1.0, size=3))
    red, green, blue = np.clip(colour, *_PAINT_LIMITS)
    return float(red), float(green), float(blue)


def wood(rng: np.random.Generator) -> Reflectance:
    """Draw a brown from pale ash to dark walnut."""
    level, warmth = rng.uniform(*_WOOD_LEVEL), rng.uniform(*_WOOD_WARMTH)
    return float(level * (1.0 + _WOOD_RED * warmth)), float(level), float(level * (1.0 - _WOOD_BLUE * warmth))


def draw_windows(rng: np.random.Generator, size: tuple[float, float, float]) -> tuple[Window, ...]:
    """Draw windows on up to two walls, ceiling lamps and a soft box; at least one window or lamp."""
    lamps = _ceiling_lamps(rng, size) if rng.uniform() < _LAMP_PROBABILITY else []
    walls = rng.permutation(4)[: int(rng.integers(0 if lamps else 1, _MOST_WINDOW_WALLS + 1))]
    sky = black_body(rng.uniform(*_SKY_TEMPERATURE)) * rng.uniform(*_SKY_RADIANCE)
    windows = [item for wall in walls for item in _wall_windows(rng, size, _SIDES[wall], sky)]
    if rng.uniform() < _SOFT_BOX_PROBABILITY:
        free: list[Wall] = [side for number, side in enumerate(_SIDES) if number not in walls]
        windows.append(_soft_box(rng, size, free[int(rng.integers(len(free)))]))
    return tuple(windows + lamps)


def _wall_windows(
    rng: np.random.Generator, size: tuple[float, float, float], wall: Wall, sky: np.ndarray
) -> list[Window]:
    """Draw a row of equal windows, evenly spaced along a wall."""
    length = _length(size, wall)
    count = int(rng.integers(1, max(2, int(length / _WINDOW_PITCH))))
    pitch = length / count
    width = pitch * rng.uniform(*_WINDOW_FILL)
    sill = rng.choice([_LOW_SILL, rng.uniform(*_SILL)])
    high = min(size[2] - _LINTEL, sill + rng.uniform(*_WINDOW_HEIGHT)) - sill
    bars = int(rng.integers(0, _MOST_BARS + 1))
    return [
        Window(
            wall=wall, centre=(pitch * (k + 0.5), sill + high / 2), size=(width, high), radiance=_triple(sky), bars=bars
        )
        for k in range(count)
    ]


def _ceiling_lamps(rng: np.random.Generator, size: tuple[float, float, float]) -> list[Window]:
    """Draw a regular grid of equal ceiling panels."""
    side = _LAMP_SIZES[int(rng.integers(len(_LAMP_SIZES)))]
    counts = [max(1, int(size[axis] / rng.uniform(*_LAMP_SPACING))) for axis in (0, 1)]
    radiance = _radiance(rng, "panel", side, _LAMP_TEMPERATURE)
    return [
        Window(
            kind="lamp",
            wall="ceiling",
            centre=(size[0] * (i + 0.5) / counts[0], size[1] * (j + 0.5) / counts[1]),
            size=side,
            radiance=radiance,
        )
        for i in range(counts[0])
        for j in range(counts[1])
    ]


def _soft_box(rng: np.random.Generator, size: tuple[float, float, float], wall: Wall) -> Window:
    width, high = rng.uniform(*_SOFT_BOX_SIDE), rng.uniform(*_SOFT_BOX_SIDE)
    along = _length(size, wall) * rng.uniform(*_SOFT_BOX_PLACE)
    centre = (along, rng.uniform(_SOFT_BOX_HEIGHT, size[2] - _SOFT_BOX_TOP))
    radiance = _radiance(rng, "soft-box", (width, high), _SOFT_BOX_TEMPERATURE)
    return Window(kind="lamp", wall=wall, centre=centre, size=(width, high), radiance=radiance)


def _radiance(
    rng: np.random.Generator, kind: str, size: tuple[float, float], temperature: tuple[float, float]
) -> tuple[float, float, float]:
    """Draw the radiance of an even diffuser with the flux of a kind of lamp [kcd/m^2]."""
    level = 1e-3 * rng.uniform(*LAMPS[kind].flux) / (np.pi * size[0] * size[1])
    return _triple(black_body(rng.uniform(*temperature)) * level)


def draw_panels(
    rng: np.random.Generator, size: tuple[float, float, float], windows: tuple[Window, ...]
) -> tuple[Panel, ...]:
    """Draw a door and pictures on the walls that have no window."""
    with_windows = {window.wall for window in windows}
    panels: list[Panel] = []
    for wall in _SIDES:
        if wall in with_windows:
            continue
        length, x = _length(size, wall), rng.uniform(*_PANEL_START)
        while x < length - _PANEL_ROOM:
            if rng.uniform() < _DOOR_PROBABILITY:
                width, high, centre = _DOOR_WIDTH, _DOOR_HEIGHT, 0.5 * _DOOR_HEIGHT
                colours = [wood(rng)]
            else:
                width, high = rng.uniform(*_PICTURE_WIDTH), rng.uniform(*_PICTURE_HEIGHT)
                centre = rng.uniform(*_PICTURE_CENTRE)
                colours = [paint(rng, _FRAME_PAINT, _FRAME_CHROMA), paint(rng, _PICTURE_PAINT, _PICTURE_CHROMA)]
            for layer, colour in enumerate(colours):
                # The picture lies inside its frame.
                inner = (width - 2 * _FRAME_WIDTH * layer, high - 2 * _FRAME_WIDTH * layer)
                panels.append(Panel(wall=wall, centre=(x + width / 2, centre), size=inner, colour=colour))
            x += width + rng.uniform(*_PANEL_GAP)
    return tuple(panels)


def _draw_blocks(
    rng: np.random.Generator, size: tuple[float, float, float], windows: tuple[Window, ...]
) -> tuple[Block, ...]:
    """Draw furniture along the walls, away from the table, and low in front of windows."""
    with_windows = {window.wall for window in windows}
    blocks: list[Block] = []
    for _ in range(int(rng.integers(_BLOCK_COUNT[0], _BLOCK_COUNT[1] + 1))):
        axis, far = int(rng.integers(2)), bool(rng.integers(2))
        depth, width = rng.uniform(*_BLOCK_DEPTH), rng.uniform(*_BLOCK_WIDTH)
        high = float(rng.choice(_BLOCK_HEIGHTS))
        start = rng.uniform(0.0, size[1 - axis] - width)
        wall: Wall = _SIDES[2 * axis + (not far)]
        high = min(high * rng.uniform(*_BLOCK_SPREAD), _BLOCK_UNDER_WINDOW if wall in with_windows else size[2])
        lower, upper = [0.0, 0.0, 0.0], [0.0, 0.0, high]
        lower[axis], upper[axis] = (size[axis] - depth, size[axis]) if far else (0.0, depth)
        lower[1 - axis], upper[1 - axis] = start, start + width
        colour = wood(rng) if rng.uniform() < _BLOCK_WOOD_PROBABILITY else paint(rng, _BLOCK_PAINT, _BLOCK_CHROMA)
        blocks.append(Block(lower=_triple(lower), upper=_triple(upper), colour=colour))
    return tuple(blocks)


def _length(size: tuple[float, float, float], wall: Wall) -> float:
    return size[1] if wall in ("+x", "-x") else size[0]


def _triple(values: np.ndarray | list[float]) -> tuple[float, float, float]:
    first, second, third = map(float, values)
    return first, second, third
