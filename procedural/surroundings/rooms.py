"""Procedural rooms as environments: drawn, and baked to a map of radiance.

Radiance is in kcd/m^2, from real figures: an overcast sky of 10 to 25 klx has a mean luminance of 3 to 8 (E / pi); a
0.6 m square ceiling panel of 3500 lm has 3.1 (flux / (pi A)); a studio soft box of 10000 lm and 0.6 x 0.9 m has 5.9.
The walls follow from those by `room_light`.
"""

from __future__ import annotations

import numpy as np

from ...core.model import Reflectance
from ..description.surroundings import Block, Panel, RoomEnvironment, Wall, Window
from ..materials.noise import fractal_value_noise as fractal_noise
from ..materials.noise import lattice
from .colour import black_body
from .room_geometry import WALL_FACES, Boxes, boxes_of, cast, face_coordinates, in_rectangle
from .room_light import bar_radiance, glow, sample, solve
from .sphere import texel_directions

#: Height of the table top over the floor [m] (dining and work tables: 0.72 to 0.76).
TABLE_HEIGHT = 0.74
# Samples per texel and direction; their mean is the texel.
_SUPERSAMPLING = 2
# Rows of the map that are cast at once: keeps memory under 100 MB.
_STRIP = 32
_SIDES: tuple[Wall, Wall, Wall, Wall] = ("+x", "-x", "+y", "-y")


def draw_room(rng: np.random.Generator) -> RoomEnvironment:
    """Draw a room with windows, lamps, wall panels and furniture; the table stands well inside."""
    size = (float(rng.uniform(3.5, 9.0)), float(rng.uniform(3.5, 9.0)), float(rng.uniform(2.4, 3.6)))
    eye = (size[0] * float(rng.uniform(0.35, 0.65)), size[1] * float(rng.uniform(0.35, 0.65)), TABLE_HEIGHT)
    windows = _draw_windows(rng, size)
    return RoomEnvironment(
        size=size,
        eye=eye,
        wall_colours=_draw_colours(rng),
        windows=windows,
        panels=_draw_panels(rng, size, windows),
        blocks=_draw_blocks(rng, size, windows),
        board_width=float(rng.choice([0.0, rng.uniform(0.08, 0.25)])),
        seed=int(rng.integers(2**31)),
        rotation=float(rng.uniform(0.0, 2.0 * np.pi)),
    )


def bake_room(environment: RoomEnvironment, height: int = 512) -> np.ndarray:
    """Return the radiance of a room seen from its table, without ``rotation`` and ``strength``.

    Parameters
    ----------
    environment : RoomEnvironment
        The room.
    height : int
        Rows of the map.

    Returns
    -------
    (height, 2 * height, 3) float32
        Linear Rec.709 [kcd/m^2], laid out as `sphere` says; each texel is the mean of 2 x 2 rays.
    """
    boxes = boxes_of(environment)
    grids = solve(environment, boxes)
    eye = np.array([environment.eye], dtype=np.float32)
    places = (np.arange(_SUPERSAMPLING) + 0.5) / _SUPERSAMPLING
    out = np.zeros((height, 2 * height, 3), dtype=np.float32)
    for start in range(0, height, _STRIP):
        rows = slice(start, min(start + _STRIP, height))
        for offset in ((u, v) for u in places for v in places):
            directions = texel_directions(height, rows, offset).reshape(-1, 3)
            out[rows] += _radiance(environment, boxes, grids, eye, directions).reshape(out[rows].shape)
    return out / np.float32(_SUPERSAMPLING**2)


def _radiance(
    room: RoomEnvironment, boxes: Boxes, grids: np.ndarray, eye: np.ndarray, directions: np.ndarray
) -> np.ndarray:
    faces, points = cast(boxes, eye, directions)
    coordinates = face_coordinates(faces, points)
    irradiance = sample(grids, boxes, faces, coordinates)
    radiance = irradiance * _reflectance(room, boxes, faces, points, coordinates) / np.float32(np.pi)
    for window in room.windows:
        on = np.flatnonzero(faces == WALL_FACES[window.wall])
        shining, kind = glow(window, coordinates[on], directions[on], room.seed)
        radiance[on[kind == 1]] = shining[kind == 1]
        radiance[on[kind == 2]] = bar_radiance(irradiance[on[kind == 2]])
    return radiance


def _reflectance(
    room: RoomEnvironment, boxes: Boxes, faces: np.ndarray, points: np.ndarray, coordinates: np.ndarray
) -> np.ndarray:
    """Return the reflectance with its small variation, (n, 3) float32."""
    reflectance = boxes.reflectance[faces]
    for panel in room.panels:
        on = np.flatnonzero(faces == WALL_FACES[panel.wall])
        on = on[in_rectangle(coordinates[on], panel.centre, panel.size)]
        reflectance[on] = np.array(panel.colour, dtype=np.float32)
    # Plaster and paint differ by some percent over decimetres.
    factor = 0.94 + 0.12 * fractal_noise(points * 3.0, room.seed, 3)
    if room.board_width > 0.0:
        floor = faces == 5
        factor[floor] *= _boards(points[floor], room.board_width, room.seed)
    return np.clip(reflectance * factor[:, None], 0.0, 1.0)


def _boards(points: np.ndarray, width: float, seed: int) -> np.ndarray:
    """Return the factor of floor boards along x: each board its own shade, grain along it, a dark joint."""
    across = points[:, 1] / width
    board = np.floor(across).astype(np.int64)
    shade = 0.75 + 0.5 * lattice(np.stack([board, 0 * board, 0 * board], axis=1), seed + 7)
    grain = 0.85 + 0.3 * fractal_noise(points * np.array([2.0, 40.0, 1.0]) + board[:, None] * 17.0, seed + 8, 2)
    # The joint is 3 mm wide.
    joint = np.abs(across - np.round(across)) * width < 0.0015
    return shade * grain * np.where(joint, 0.3, 1.0)


def _draw_colours(rng: np.random.Generator) -> tuple[Reflectance, ...]:
    """Draw the reflectance of walls, ceiling and floor: light paint, one wall perhaps of a strong colour."""
    wall = _paint(rng, (0.45, 0.8), 0.08)
    walls = [wall] * 4
    if rng.uniform() < 0.4:
        walls[int(rng.integers(4))] = _paint(rng, (0.1, 0.5), 0.4)
    return (*walls, _paint(rng, (0.75, 0.85), 0.02), _wood(rng))


def _paint(rng: np.random.Generator, level: tuple[float, float], chroma: float) -> Reflectance:
    """Draw a paint: a grey of some reflectance, each primary off by up to a share."""
    colour = rng.uniform(*level) * (1.0 + chroma * rng.uniform(-1.0, 1.0, size=3))
    red, green, blue = np.clip(colour, 0.02, 0.9)
    return float(red), float(green), float(blue)


def _wood(rng: np.random.Generator) -> Reflectance:
    """Draw a brown from pale ash to dark walnut."""
    level, warmth = rng.uniform(0.08, 0.45), rng.uniform(0.2, 0.6)
    return float(level * (1.0 + 0.4 * warmth)), float(level), float(level * (1.0 - 0.8 * warmth))


def _draw_windows(rng: np.random.Generator, size: tuple[float, float, float]) -> tuple[Window, ...]:
    """Draw windows on one or two walls, ceiling lamps, and perhaps a soft box: at least one shines."""
    lamps = _ceiling_lamps(rng, size) if rng.uniform() < 0.6 else []
    walls = rng.permutation(4)[: int(rng.integers(0 if lamps else 1, 3))]
    sky = black_body(rng.uniform(5500.0, 8000.0)) * rng.uniform(2.5, 8.0)
    windows = [item for wall in walls for item in _wall_windows(rng, size, _SIDES[wall], sky)]
    if rng.uniform() < 0.3:
        free: list[Wall] = [side for number, side in enumerate(_SIDES) if number not in walls]
        windows.append(_soft_box(rng, size, free[int(rng.integers(len(free)))]))
    return tuple(windows + lamps)


def _wall_windows(
    rng: np.random.Generator, size: tuple[float, float, float], wall: Wall, sky: np.ndarray
) -> list[Window]:
    """Draw a row of equal windows that share a wall's length."""
    length = _length(size, wall)
    count = int(rng.integers(1, max(2, int(length / 1.5))))
    pitch = length / count
    width = pitch * rng.uniform(0.45, 0.85)
    sill = rng.choice([0.1, rng.uniform(0.7, 1.0)])
    high = min(size[2] - 0.25, sill + rng.uniform(1.2, 2.2)) - sill
    bars = int(rng.integers(0, 4))
    return [
        Window(
            wall=wall, centre=(pitch * (k + 0.5), sill + high / 2), size=(width, high), radiance=_triple(sky), bars=bars
        )
        for k in range(count)
    ]


def _ceiling_lamps(rng: np.random.Generator, size: tuple[float, float, float]) -> list[Window]:
    """Draw a regular field of equal ceiling panels."""
    side = ((0.6, 0.6), (1.2, 0.3), (0.3, 1.2), (1.2, 0.6))[int(rng.integers(4))]
    counts = [max(1, int(size[axis] / rng.uniform(1.8, 3.0))) for axis in (0, 1)]
    radiance = _triple(black_body(rng.uniform(3300.0, 5500.0)) * rng.uniform(2.0, 6.0))
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
    width, high = rng.uniform(0.5, 1.2), rng.uniform(0.5, 1.2)
    centre = (_length(size, wall) * rng.uniform(0.25, 0.75), rng.uniform(1.2, size[2] - 0.7))
    radiance = _triple(black_body(rng.uniform(4000.0, 6500.0)) * rng.uniform(4.0, 12.0))
    return Window(kind="lamp", wall=wall, centre=centre, size=(width, high), radiance=radiance)


def _draw_panels(
    rng: np.random.Generator, size: tuple[float, float, float], windows: tuple[Window, ...]
) -> tuple[Panel, ...]:
    """Draw a door and pictures on the walls that have no window."""
    taken = {window.wall for window in windows}
    panels: list[Panel] = []
    for wall in _SIDES:
        if wall in taken:
            continue
        length, x = _length(size, wall), rng.uniform(0.2, 0.6)
        while x < length - 0.6:
            if rng.uniform() < 0.25:
                width, high, centre = 0.9, 2.05, 1.025
                colours = [_wood(rng)]
            else:
                width, high, centre = rng.uniform(0.3, 1.1), rng.uniform(0.3, 0.9), rng.uniform(1.3, 1.7)
                colours = [_paint(rng, (0.05, 0.2), 0.2), _paint(rng, (0.1, 0.7), 0.35)]
            for shrink, colour in enumerate(colours):
                # The picture lies inside its frame, 3 cm wide.
                inner = (width - 0.06 * shrink, high - 0.06 * shrink)
                panels.append(Panel(wall=wall, centre=(x + width / 2, centre), size=inner, colour=colour))
            x += width + rng.uniform(0.3, 1.5)
    return tuple(panels)


def _draw_blocks(
    rng: np.random.Generator, size: tuple[float, float, float], windows: tuple[Window, ...]
) -> tuple[Block, ...]:
    """Draw furniture along the walls, clear of the table (1.2 m away at least), and low under windows."""
    lit = {window.wall for window in windows}
    blocks: list[Block] = []
    for _ in range(int(rng.integers(3, 8))):
        axis, far = int(rng.integers(2)), bool(rng.integers(2))
        depth, width, high = rng.uniform(0.3, 0.7), rng.uniform(0.4, 1.8), float(rng.choice([0.45, 0.8, 1.2, 1.9]))
        start = rng.uniform(0.0, size[1 - axis] - width)
        wall: Wall = _SIDES[2 * axis + (not far)]
        high = min(high * rng.uniform(0.85, 1.1), 0.8 if wall in lit else size[2])
        lower, upper = [0.0, 0.0, 0.0], [0.0, 0.0, high]
        lower[axis], upper[axis] = (size[axis] - depth, size[axis]) if far else (0.0, depth)
        lower[1 - axis], upper[1 - axis] = start, start + width
        colour = _wood(rng) if rng.uniform() < 0.5 else _paint(rng, (0.1, 0.7), 0.2)
        blocks.append(Block(lower=_triple(lower), upper=_triple(upper), colour=colour))
    return tuple(blocks)


def _length(size: tuple[float, float, float], wall: Wall) -> float:
    return size[1] if wall in ("+x", "-x") else size[0]


def _triple(values: np.ndarray | list[float]) -> tuple[float, float, float]:
    first, second, third = map(float, values)
    return first, second, third
