"""Labels of bottles and jars, and the print of laboratory glass: scales with numbers, and marks."""

from __future__ import annotations

import colorsys

import numpy as np

from ..description.bodies import Prop
from ..description.material import OpaqueMaterial, UniformTexture, VertexColours
from .attach import opaque_part
from .host import Host
from .patches import Area, bars_mesh, label_mesh

#: Side of a label's cells [m], the outline's slope up to which a label lies on it [1], its least height [m].
_CELL, _STRAIGHT, _LEAST = 7e-4, 0.06, 0.02
#: Height of a label, of the straight part; how much of the circumference it covers [turns]; how often it goes around.
_HEIGHT, _COVER, _AROUND = (0.5, 0.92), (0.28, 0.6), 0.25
#: Reflectance of paper, linear [1]; of white, brown and black enamel.
_PAPER = (0.74, 0.73, 0.70)
ENAMELS = {"white enamel": (0.78, 0.78, 0.77), "brown enamel": (0.12, 0.035, 0.012), "black enamel": (0.02, 0.02, 0.02)}
#: Nominal volumes of laboratory glass [m^3] (ISO 3819, ISO 1042, ISO 1773).
NOMINALS = tuple(1e-6 * v for v in (25, 50, 100, 150, 250, 400, 500, 600, 800, 1000, 2000))
#: The highest graduation is at most this part of the brimful volume, the lowest this part of the highest [1].
_MOST, _LEAST_MARK = 0.86, 0.2
#: Long and short lines of a scale, their thickness, height and stroke of its numbers [m].
_LONG, _SHORT, _LINE, _DIGIT, _STROKE = 0.011, 0.006, 6e-4, 3.6e-3, 5.5e-4
#: Segments of digits: upper, upper right, lower right, lower, lower left, upper left, middle.
_SEGMENTS = (
    "1111110",
    "0110000",
    "1101101",
    "1111001",
    "0110011",
    "1011011",
    "1011111",
    "1110000",
    "1111111",
    "1111011",
)


def draw_label(rng: np.random.Generator, host: Host) -> Prop | None:
    """Draw a paper label on the straight part of the outside; None where there is no such part."""
    low, high = host.straight(_STRAIGHT)
    height, cover, around = rng.uniform(*_HEIGHT), rng.uniform(*_COVER), rng.random() < _AROUND
    middle, place = rng.uniform(0.4, 0.6), rng.uniform()
    style = rng.integers(2**31)
    if high - low < _LEAST / _HEIGHT[0]:
        return None
    size = height * (high - low)
    centre = low + 0.5 * size + middle * (high - low - size)
    if host.fold > 1:  # on the middle of a side
        place, cover, around = _side(host, int(rng.integers(host.fold))), 0.66 / host.fold, False
    cover = 1.0 if around else cover
    area = Area(place - 0.5 * cover, place + 0.5 * cover, centre - 0.5 * size, centre + 0.5 * size)
    radius = float(host.radius(np.array(centre)))
    rows, columns = max(8, round(size / _CELL)), max(8, round(2.0 * np.pi * radius * cover / _CELL))
    cells = _printed(np.random.default_rng(style), rows, columns)
    material = OpaqueMaterial(name="printed paper", base_colour=VertexColours(), roughness=0.6)
    return opaque_part(host.body.name, "label", label_mesh(host, area, cells, np.array(_PAPER)), material, np.zeros(3))


def _side(host: Host, number: int) -> float:
    """Return the place around of the middle of a flat side [turns]: where the outside is nearest to the axis."""
    u = np.arange(360) / 360.0
    low, high = host.straight(_STRAIGHT)
    points, _ = host.points(u, np.full_like(u, 0.5 * (low + high)))
    near = np.hypot(points[:, 0], points[:, 1])
    start = float(u[int(near[: 360 // host.fold].argmin())])
    return start + number / host.fold


def _printed(rng: np.random.Generator, rows: int, columns: int) -> np.ndarray:
    """Return the cells of a label: a ground, a band, a mark, lines of words, and a bar code."""
    hue, cells = rng.uniform(), np.tile(np.array(_PAPER), (rows, columns, 1))
    ground, ink = _colour(hue, rng.uniform(0.3, 0.8), rng.uniform(0.3, 0.9)), np.array([0.03, 0.03, 0.035])
    if rng.random() < 0.5:
        cells[:] = ground
        ink = np.array(_PAPER) if ground.mean() < 0.2 else ink
    accent = _colour(hue + rng.uniform(0.3, 0.7), 0.8, rng.uniform(0.3, 0.8))
    edge = max(1, rows // 18)
    cells[:edge], cells[-edge:] = accent, accent
    low, high = sorted(rng.integers(rows // 2, rows - edge, 2).tolist())
    cells[low : max(high, low + 2)] = accent
    y, x = np.mgrid[:rows, :columns]
    size = 0.18 * min(rows, columns)
    cells[(y - 0.78 * rows) ** 2 + (x - 0.5 * columns) ** 2 < size**2] = ink
    _words(rng, cells, (int(0.5 * rows), int(0.6 * rows)), ink, (3, 6))
    for line in range(max(1, int(0.28 * rows) // 4)):
        _words(rng, cells, (edge + 2 + 4 * line, edge + 4 + 4 * line), ink, (1, 4))
    return cells


def _words(
    rng: np.random.Generator, cells: np.ndarray, lines: tuple[int, int], ink: np.ndarray, lengths: tuple[int, int]
) -> None:
    """Print words as strokes of ink between two rows."""
    columns = cells.shape[1]
    place, end = max(2, columns // 10), columns - max(2, columns // 10)
    while place < end:
        length = int(rng.integers(lengths[0], lengths[1] + 1))
        cells[lines[0] : lines[1], place : min(place + length, end)] = ink
        place += length + 1 + int(rng.random() < 0.3)


def _colour(hue: float, saturation: float, value: float) -> np.ndarray:
    """Return a printing colour, linear Rec.709."""
    srgb = np.array(colorsys.hsv_to_rgb(hue % 1.0, saturation, value))
    return np.clip(srgb**2.2, 0.013, 0.871)


def draw_scale(rng: np.random.Generator, host: Host) -> Prop | None:
    """Draw the graduations of a beaker or a conical flask, at the heights of their volumes; None where none fit."""
    place, names = rng.uniform(0.2, 0.8), list(ENAMELS)
    name = names[int(rng.choice(len(names), p=(0.8, 0.1, 0.1)))]
    nominal = max((v for v in NOMINALS if v <= _MOST * host.brimful), default=None)
    if nominal is None:
        return None
    step = nominal / (10 if nominal > 1.6e-4 else 5)
    areas: list[Area] = []
    for number in range(1, round(nominal / step) + 1):
        volume = number * step
        if volume < _LEAST_MARK * nominal:
            continue
        z = host.level_of(volume)
        long = number % 2 == 0
        areas.append(_bar(host, place, 0.0, _LONG if long else _SHORT, z, _LINE))
        if long or nominal <= 1.6e-4:
            areas += _number(host, place, 0.5 * _LONG + 2.0 * _STROKE, z, round(1e6 * volume))
    material = OpaqueMaterial(name=name, base_colour=UniformTexture(colour=ENAMELS[name]), roughness=0.5)
    return opaque_part(host.body.name, "print", bars_mesh(host, areas), material, np.zeros(3))


def draw_mark(rng: np.random.Generator, host: Host) -> Prop | None:
    """Draw the ring mark of a volumetric flask in its neck; None where its volume is not there."""
    names = list(ENAMELS)
    name = names[int(rng.integers(len(names)))]
    fitting = [v for v in NOMINALS if v <= 0.97 * host.brimful]
    volume = max(fitting, default=0.0)
    if volume < 0.8 * host.brimful:
        volume = 0.9 * host.brimful
    z = host.level_of(volume)
    ring = Area(0.0, 1.0, z - 0.5 * _LINE, z + 0.5 * _LINE)
    material = OpaqueMaterial(name=name, base_colour=UniformTexture(colour=ENAMELS[name]), roughness=0.5)
    return opaque_part(host.body.name, "print", bars_mesh(host, [ring]), material, np.zeros(3), symmetric=True)


def _bar(host: Host, place: float, along: float, width: float, z: float, height: float) -> Area:
    """Return a bar whose middle is `along` [m] to the left of a place, seen from outside."""
    around = 2.0 * np.pi * float(host.radius(np.array(z)))
    middle = place - along / around
    return Area(middle - 0.5 * width / around, middle + 0.5 * width / around, z - 0.5 * height, z + 0.5 * height)


def _number(host: Host, place: float, gap: float, z: float, value: int) -> list[Area]:
    """Return the strokes of a number to the left of a line's left end."""
    wide, strokes = 0.55 * _DIGIT, []
    text = str(value)
    for k, digit in enumerate(text):
        middle = gap + (len(text) - 1 - k) * (wide + 2.5 * _STROKE) + 0.5 * wide
        half, right, left = 0.5 * (_DIGIT - _STROKE), middle - 0.5 * wide, middle + 0.5 * wide
        # Strokes end before those across them, so that no two are in one place.
        flat, tall = wide - 1.6 * _STROKE, half - 1.6 * _STROKE
        places = (
            (middle, half, flat, _STROKE),
            (right, 0.5 * half, _STROKE, tall),
            (right, -0.5 * half, _STROKE, tall),
            (middle, -half, flat, _STROKE),
            (left, -0.5 * half, _STROKE, tall),
            (left, 0.5 * half, _STROKE, tall),
            (middle, 0.0, flat, _STROKE),
        )
        lit = _SEGMENTS[int(digit)]
        strokes += [
            _bar(host, place, along, width, z + up, height)
            for (along, up, width, height), on in zip(places, lit, strict=True)
            if on == "1"
        ]
    return strokes
