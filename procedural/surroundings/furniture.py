"""Furniture along the walls of a room: cupboards, shelves with books or bottles, kitchens, benches, curtains.

Sizes follow kitchen furniture (EN 1116: 60 cm deep, 90 cm high with a worktop of 4 cm, a plinth of 10 cm), laboratory
benches (EN 13150: 90 cm high, 75 cm deep) and what furniture shops sell. What has no source is chosen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ...core.model import Reflectance
from ..description.surroundings import Block, Detail, RoomPart, Wall, Window
from .room_geometry import ALONG, WALL_FACES
from .rooms import paint, wood

# Depth of base units, worktop and wall units; heights of plinth, worktop, its thickness, and of wall units [m].
_BASE_DEPTH, _TOP_DEPTH, _UNIT_DEPTH = 0.58, 0.62, 0.34
_PLINTH, _WORKTOP, _TOP_THICKNESS, _UNITS = 0.10, 0.90, 0.04, (1.42, 2.12)
# Width of a cupboard's doors, gap between them, their thickness; a handle's length, thickness and distance [m].
_DOOR, _GAP, _FRONT = (0.40, 0.60), 0.004, 0.018
_HANDLE, _HANDLE_WIDTH, _HANDLE_OUT = 0.13, 0.012, 0.03
# Shelves: depth, thickness of boards, distance between them [m]; books and bottles.
_SHELF_DEPTH, _BOARD, _SHELF_PITCH = 0.30, 0.02, (0.30, 0.38)
_BOOK_WIDTH, _BOOK_HEIGHT, _BOOK_DEPTH = (0.015, 0.055), (0.18, 0.28), (0.13, 0.24)
_BOTTLE_WIDTH, _BOTTLE_HEIGHT = (0.06, 0.14), (0.12, 0.26)
# Share of a shelf that is filled, and how many books stand between two gaps.
_FILLED, _BOOK_RUN = 0.8, (4, 14)
# Height and thickness of skirting boards [m].
_SKIRTING, _SKIRTING_DEPTH = 0.08, 0.014
# Radiators: depth of the gap and of the panel, foot, height below the sill [m]. Curtains: width of a fold, folds.
_RADIATOR_GAP, _RADIATOR_DEPTH, _RADIATOR_FOOT, _RADIATOR_TOP = 0.04, 0.09, 0.12, 0.12
_FOLD, _FOLDS, _CURTAIN_DEPTH, _CURTAIN_OVER = 0.055, (4, 8), 0.10, 0.12
# Handles and legs are of steel or painted black; lab benches have white fronts and dark tops.
_STEEL: Reflectance = (0.45, 0.45, 0.46)
_BLACK: Reflectance = (0.03, 0.03, 0.03)
_WHITE: Reflectance = (0.75, 0.75, 0.73)


@dataclass(eq=False)  # filled step by step while a room is drawn
class Furniture:
    """What stands in a room so far."""

    size: tuple[float, float, float]  #: of the room [m]
    blocks: list[Block] = field(default_factory=list)
    details: list[Detail] = field(default_factory=list)


@dataclass(frozen=True)
class Place:
    """A stretch of wall: coordinates are along the wall, away from it, and up [m]."""

    furniture: Furniture
    wall: Wall
    start: float  #: along the wall [m]

    def box(
        self,
        low: tuple[float, float, float],
        high: tuple[float, float, float],
        colour: Reflectance,
        part: RoomPart = "furniture",
        finish: str = "plain",
    ) -> None:
        """Add a small body."""
        a, b = self._bounds(low, high)
        pose = np.eye(4)
        pose[:3, 3] = 0.5 * (a + b)
        size = _three(b - a)
        self.furniture.details.append(
            Detail(
                part=part, room_T_detail=pose, size=size, colour=colour, finish="wood" if finish == "wood" else "plain"
            )
        )

    def cylinder(self, foot: tuple[float, float, float], size: tuple[float, float, float], colour: Reflectance) -> None:
        """Add an upright cylinder by the middle of its foot, its diameters along and away from the wall, its height."""
        place, _ = self._bounds(foot, foot)
        pose = np.eye(4)
        pose[:3, 3] = place + np.array([0.0, 0.0, 0.5 * size[2]])
        along, away = (size[0], size[1]) if WALL_FACES[self.wall] // 2 == 1 else (size[1], size[0])
        extent = (along, away, size[2])
        self.furniture.details.append(
            Detail(part="furniture", shape="cylinder", room_T_detail=pose, size=extent, colour=colour)
        )

    def block(self, low: tuple[float, float, float], high: tuple[float, float, float], colour: Reflectance) -> None:
        """Add a large body, which the room's map shows as well."""
        a, b = self._bounds(low, high)
        self.furniture.blocks.append(Block(lower=_three(a), upper=_three(b), colour=colour))

    def _bounds(
        self, low: tuple[float, float, float], high: tuple[float, float, float]
    ) -> tuple[np.ndarray, np.ndarray]:
        face = WALL_FACES[self.wall]
        axis, along = face // 2, ALONG[face // 2][0]
        points = np.empty((2, 3))
        for row, place in zip(points, (low, high), strict=True):
            row[along], row[2] = self.start + place[0], place[2]
            row[axis] = self.furniture.size[axis] - place[1] if face % 2 == 0 else place[1]
        return points.min(axis=0), points.max(axis=0)


def _three(values: np.ndarray) -> tuple[float, float, float]:
    first, second, third = map(float, values)
    return first, second, third


@dataclass(frozen=True)
class Style:
    """Colours that the furniture of a room shares."""

    front: Reflectance
    top: Reflectance
    handle: Reflectance
    finish: str  #: of fronts: "plain" or "wood"
    cloth: Reflectance


def draw_style(rng: np.random.Generator, use: str) -> Style:
    """Draw the colours of a room's furniture."""
    wooden = rng.random() < (0.15 if use == "laboratory" else 0.5)
    front = wood(rng) if wooden else (_WHITE if use == "laboratory" else paint(rng, (0.15, 0.75), 0.15))
    top = wood(rng) if use == "kitchen" and rng.random() < 0.4 else paint(rng, (0.04, 0.5), 0.06)
    return Style(
        front, top, _STEEL if rng.random() < 0.6 else _BLACK, "wood" if wooden else "plain", paint(rng, (0.2, 0.7), 0.3)
    )


#: An item: adds itself at a place with a width [m].
Item = Callable[[Place, np.random.Generator, Style, float], None]


def base_units(place: Place, rng: np.random.Generator, style: Style, width: float) -> None:
    """Add kitchen base units under a worktop."""
    top = _WORKTOP - _TOP_THICKNESS
    place.block((0.0, 0.0, _PLINTH), (width, _BASE_DEPTH, top), style.front)
    place.box((0.0, 0.0, 0.0), (width, _BASE_DEPTH - 0.05, _PLINTH), _BLACK)
    place.box((-0.01, 0.0, top), (width + 0.01, _TOP_DEPTH, _WORKTOP), style.top)
    drawers = rng.random(8) < 0.35
    for number, (x0, x1) in enumerate(_doors(rng, width)):
        edges = [_PLINTH, 0.36, 0.62, top] if drawers[number % 8] else [_PLINTH, top]
        for z0, z1 in pairwise(edges):
            _front(place, style, (x0, z0, x1, z1), _BASE_DEPTH, across=True)


def wall_units(place: Place, rng: np.random.Generator, style: Style, width: float) -> None:
    """Add kitchen wall units over base units."""
    base_units(place, rng, style, width)
    low, high = _UNITS[0], min(_UNITS[1], place.furniture.size[2] - 0.1)
    place.block((0.0, 0.0, low), (width, _UNIT_DEPTH, high), style.front)
    for x0, x1 in _doors(rng, width):
        _front(place, style, (x0, low, x1, high), _UNIT_DEPTH, across=False)


def tall_cupboard(place: Place, rng: np.random.Generator, style: Style, width: float) -> None:
    """Add a cupboard or a refrigerator with full-height doors."""
    high, depth = float(rng.uniform(1.75, 2.1)), float(rng.uniform(0.4, 0.62))
    place.block((0.0, 0.0, 0.06), (width, depth, high), style.front)
    place.box((0.02, 0.0, 0.0), (width - 0.02, depth - 0.04, 0.06), _BLACK)
    for x0, x1 in _doors(rng, width):
        split = float(rng.choice([0.06, 1.1]))
        for z0, z1 in ((0.06, split), (split, high)):
            if z1 - z0 > 0.1:
                _front(place, style, (x0, z0, x1, z1), depth, across=False)


def sideboard(place: Place, rng: np.random.Generator, style: Style, width: float) -> None:
    """Add a sideboard on legs, with a vase or two boxes on it."""
    foot, high, depth = float(rng.uniform(0.08, 0.2)), float(rng.uniform(0.72, 0.9)), float(rng.uniform(0.36, 0.46))
    place.block((0.0, 0.01, foot), (width, depth, high), style.front)
    place.box((-0.015, 0.0, high), (width + 0.015, depth + 0.03, high + 0.022), style.front, finish="wood")
    for x in (0.05, width - 0.09):
        for d in (0.05, depth - 0.09):
            place.box((x, d, 0.0), (x + 0.04, d + 0.04, foot), style.handle)
    for x0, x1 in _doors(rng, width):
        _front(place, style, (x0, foot, x1, high), depth, across=False)
    top = high + 0.022
    for x in np.arange(0.15, width - 0.15, 0.45):
        if rng.random() < 0.6:
            girth, tall = float(rng.uniform(*_BOTTLE_WIDTH)), float(rng.uniform(0.12, 0.35))
            place.cylinder((float(x), 0.5 * depth, top), (girth, girth, tall), paint(rng, (0.05, 0.8), 0.35))


def book_shelf(place: Place, rng: np.random.Generator, style: Style, width: float) -> None:
    """Add open shelves with books."""
    _shelves(place, rng, style, (width, 0.0, float(rng.uniform(1.7, 2.15))), _books)


def bottle_bench(place: Place, rng: np.random.Generator, style: Style, width: float) -> None:
    """Add a laboratory bench with drawers, and shelves with bottles and boxes over it."""
    top = _WORKTOP - 0.03
    place.box((0.0, 0.0, top), (width, 0.75, _WORKTOP), _BLACK)
    for x in (0.02, width - 0.06):
        place.box((x, 0.68, 0.0), (x + 0.04, 0.72, top), _STEEL)
    unit = min(width - 0.1, 1.2)
    place.block((0.05, 0.0, _PLINTH), (0.05 + unit, 0.55, top - 0.02), style.front)
    for x0, x1 in _doors(rng, unit):
        for z0, z1 in ((_PLINTH, 0.35), (0.35, 0.6), (0.6, top - 0.02)):
            _front(place, style, (0.05 + x0, z0, 0.05 + x1, z1), 0.55, across=True)
    for x in np.arange(0.2, width - 0.15, 0.4):
        if rng.random() < 0.5:
            w, d, h = (float(rng.uniform(*r)) for r in ((0.1, 0.3), (0.15, 0.3), (0.1, 0.35)))
            place.box((float(x), 0.3, _WORKTOP), (float(x) + w, 0.3 + d, _WORKTOP + h), paint(rng, (0.1, 0.8), 0.15))
    _shelves(place, rng, style, (width, 1.35, 2.1), _bottles)


def _shelves(
    place: Place,
    rng: np.random.Generator,
    style: Style,
    extent: tuple[float, float, float],
    fill: Callable[[Place, np.random.Generator, tuple[float, float, float], float], None],
) -> None:
    """Add sides, boards and a back of a shelf over a width, between two heights; `fill` puts things on each board."""
    width, low, high = extent
    high = min(high, place.furniture.size[2] - 0.1)
    pitch = float(rng.uniform(*_SHELF_PITCH))
    levels = np.arange(max(low, 0.05), high - 0.2, pitch)
    for x in (0.0, width - _BOARD):
        place.box((x, 0.0, low), (x + _BOARD, _SHELF_DEPTH, high), style.front, finish=style.finish)
    place.box((_BOARD, 0.0, low), (width - _BOARD, 0.008, high), style.front)
    for z in (*levels, high - _BOARD):
        board = (_BOARD, 0.008, float(z)), (width - _BOARD, _SHELF_DEPTH, float(z) + _BOARD)
        place.box(*board, style.front, finish=style.finish)
    for z in levels:
        fill(place, rng, (_BOARD + 0.01, width - _BOARD - 0.01, float(z) + _BOARD), pitch - _BOARD)


def _books(place: Place, rng: np.random.Generator, board: tuple[float, float, float], room: float) -> None:
    x, end, z = board
    while x < end - 0.06:
        count = int(rng.integers(*_BOOK_RUN))
        series = paint(rng, (0.03, 0.6), 0.6)
        for _ in range(count):
            w, h, d = (float(rng.uniform(*r)) for r in (_BOOK_WIDTH, _BOOK_HEIGHT, _BOOK_DEPTH))
            if x + w > end:
                break
            colour = series if rng.random() < 0.3 else paint(rng, (0.03, 0.75), 0.6)
            place.box((x, 0.02, z), (x + w - 0.001, 0.02 + d, z + min(h, room - 0.02)), colour)
            x += w
        if rng.random() > _FILLED:
            x += float(rng.uniform(0.05, 0.35))


def _bottles(place: Place, rng: np.random.Generator, board: tuple[float, float, float], room: float) -> None:
    x, end, z = board
    while x < end - _BOTTLE_WIDTH[1]:
        w, h = float(rng.uniform(*_BOTTLE_WIDTH)), min(float(rng.uniform(*_BOTTLE_HEIGHT)), room - 0.04)
        if rng.random() < _FILLED:
            colour = (0.16, 0.07, 0.02) if rng.random() < 0.3 else paint(rng, (0.2, 0.8), 0.25)
            place.cylinder((x + 0.5 * w, 0.15, z), (w, w, 0.75 * h), colour)
            place.cylinder(
                (x + 0.5 * w, 0.15, z + 0.75 * h), (0.45 * w, 0.45 * w, 0.25 * h), paint(rng, (0.03, 0.7), 0.6)
            )
        x += w + float(rng.uniform(0.005, 0.04))


def _doors(rng: np.random.Generator, width: float) -> list[tuple[float, float]]:
    """Return the doors of a cupboard: equal parts of its width."""
    count = max(1, round(width / float(rng.uniform(*_DOOR))))
    return [(width * k / count, width * (k + 1) / count) for k in range(count)]


def _front(
    place: Place, style: Style, rectangle: tuple[float, float, float, float], depth: float, across: bool
) -> None:
    """Add a door or the front of a drawer, with its handle."""
    x0, z0, x1, z1 = rectangle
    half, out = 0.5 * _GAP, depth + _FRONT
    place.box((x0 + half, depth, z0 + half), (x1 - half, out, z1 - half), style.front, finish=style.finish)
    if across:
        x, z = 0.5 * (x0 + x1), z1 - 0.05
        low, high = (x - 0.5 * _HANDLE, z - 0.5 * _HANDLE_WIDTH), (x + 0.5 * _HANDLE, z + 0.5 * _HANDLE_WIDTH)
    else:
        x, z = x1 - 0.045, min(max(1.05, z0 + 0.1), z1 - 0.1)
        low, high = (x - 0.5 * _HANDLE_WIDTH, z - 0.5 * _HANDLE), (x + 0.5 * _HANDLE_WIDTH, z + 0.5 * _HANDLE)
    place.box((low[0], out, low[1]), (high[0], out + _HANDLE_OUT, high[1]), style.handle)


def skirting(furniture: Furniture, wall: Wall, length: float, windows: tuple[Window, ...], colour: Reflectance) -> None:
    """Add skirting boards along a wall, with gaps at windows that reach the floor."""
    place = Place(furniture, wall, 0.0)
    gaps = sorted(
        (w.centre[0] - 0.5 * w.size[0], w.centre[0] + 0.5 * w.size[0])
        for w in windows
        if w.wall == wall and w.centre[1] - 0.5 * w.size[1] < _SKIRTING + 0.05
    )
    start = 0.0
    for low, high in [*gaps, (length, length)]:
        if low - start > 0.02:
            place.box((start, 0.0, 0.0), (low, _SKIRTING_DEPTH, _SKIRTING), colour, part="wall")
        start = high


def at_window(furniture: Furniture, rng: np.random.Generator, window: Window, style: Style) -> None:
    """Add what belongs to a window: a radiator under it, curtains beside it."""
    place = Place(furniture, window.wall, window.centre[0])
    half, sill = 0.5 * window.size[0], window.centre[1] - 0.5 * window.size[1]
    if sill > 0.6 and rng.random() < 0.7:
        top, depth = sill - _RADIATOR_TOP, _RADIATOR_GAP + _RADIATOR_DEPTH
        for x in np.arange(-0.45 * window.size[0], 0.45 * window.size[0] - 0.04, 0.05):
            place.box((float(x), _RADIATOR_GAP, _RADIATOR_FOOT), (float(x) + 0.042, depth, top), _WHITE)
    if rng.random() < 0.5:
        top = min(window.centre[1] + 0.5 * window.size[1] + _CURTAIN_OVER, furniture.size[2] - 0.03)
        foot, folds = (0.03 if sill < 0.3 or rng.random() < 0.5 else sill - 0.15), int(rng.integers(*_FOLDS))
        for side in (-1.0, 1.0):
            for k in range(folds):
                x = side * (half + 0.02 - 0.8 * _FOLD * (k - 0.3 * folds))
                d = _CURTAIN_DEPTH + 0.02 * (k % 2)
                place.cylinder((x, d, foot), (_FOLD, 0.05, top - foot), style.cloth)
        place.box((-half - 0.25, _CURTAIN_DEPTH, top), (half + 0.25, _CURTAIN_DEPTH + 0.02, top + 0.02), style.handle)
