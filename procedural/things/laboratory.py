"""Things of a laboratory: racks for test tubes, stands with clamps."""

from __future__ import annotations

import numpy as np

from ..patterns.draw import metal, plain, plastic, wooden
from .parts import Part, Thing
from .solids import circle, moved, projected, rotation, rounded_rectangle, slab, tube

#: Racks: tubes in a row and rows, distance of tubes and width of holes [m]; for tubes of 16 mm: holes of 17.5-20 mm.
TUBES, PITCH, HOLE = (4, 9), (0.023, 0.029), (0.0175, 0.020)
#: Height of the upper board and thickness of boards of racks [m].
RACK_HEIGHT, BOARD = (0.060, 0.085), (0.005, 0.009)
#: Base and rod of a small stand [m]: bases of 140 x 90 to 210 x 130 mm, rods of 8-12 mm (DIN 12892 has larger too).
BASE, BASE_ASPECT, ROD, ROD_RADIUS = (0.12, 0.16), (0.62, 0.72), (0.25, 0.38), (0.004, 0.006)


def rack(rng: np.random.Generator, wear: float) -> Thing:
    """Return a rack for test tubes, standing: a board with holes over one with dimples, between two sides."""
    count, rows, pitch, hole = (
        int(rng.integers(*TUBES)),
        int(rng.integers(1, 3)),
        rng.uniform(*PITCH),
        rng.uniform(*HOLE),
    )
    long_side, deep = count * pitch + 0.008, rows * pitch + 0.012
    height, thick = rng.uniform(*RACK_HEIGHT), rng.uniform(*BOARD)
    places = [
        ((number - (count - 1) / 2) * pitch, (row - (rows - 1) / 2) * pitch)
        for number in range(count)
        for row in range(rows)
    ]
    outline = rounded_rectangle(long_side, deep, 0.002, 2)
    holes = [circle(hole / 2, 28, place)[::-1] for place in places]
    made = wooden(rng, (0.3, 0.12), wear) if rng.random() < 0.5 else plastic(rng, wear)
    levels = (height - thick / 2, 0.55 * height) if rng.random() < 0.5 else (height - thick / 2,)
    parts = [Part("board with holes", moved(slab([outline, *holes], thick, 0.0006), (0, 0, z)), made) for z in levels]
    parts.append(Part("floor", moved(slab([outline], thick, 0.0006), (0, 0, thick / 2)), made))
    for sign in (-1.0, 1.0):
        side = slab([rounded_rectangle(height, deep, 0.002, 2)], thick, 0.0006)
        upright = moved(side, (sign * (long_side / 2 + thick / 2 + 0.0001), 0.0, height / 2), rotation(1, np.pi / 2))
        parts.append(Part("side", projected(upright), made))
    return Thing(tuple(parts))


def stand(rng: np.random.Generator, wear: float) -> Thing:
    """Return a stand with a rod, a boss and a clamp with two fingers."""
    wide = rng.uniform(*BASE)
    deep, rod, radius = wide * rng.uniform(*BASE_ASPECT), rng.uniform(*ROD), rng.uniform(*ROD_RADIUS)
    enamel = plastic(rng, wear, ((0.10, 0.11, 0.115), (0.03, 0.10, 0.22), (0.35, 0.36, 0.36))[rng.integers(3)])
    enamel = enamel.model_copy(update={"name": "enamelled cast iron"})
    steel, cast = (
        metal(rng, wear, "steel", 0.6),
        metal(rng, wear, "aluminium", 1.0).model_copy(update={"name": "cast aluminium"}),
    )
    base = moved(slab([rounded_rectangle(wide, deep, 0.008)], 0.009, 0.002), (0, 0, 0.0045))
    foot = -wide / 2 + 0.022
    upright = tube(
        np.array([[foot, 0, 0.0092], [foot, 0, rod / 2], [foot, 0, rod]]), radius, up=(1.0, 0.0, 0.0), sides=24
    )
    level = rod * rng.uniform(0.5, 0.8)
    boss = moved(slab([rounded_rectangle(0.030, 0.026, 0.004)], 0.026, 0.002), (foot + 0.004, 0.002, level))
    arm_end = rng.uniform(0.055, 0.080)
    arm = tube(
        np.array([[foot + 0.012, 0, level], [foot + 0.03, 0, level], [foot + arm_end, 0, level]]), 0.0035, sides=16
    )
    parts = [Part("base", base, enamel), Part("rod", upright, steel), Part("boss", boss, cast), Part("arm", arm, steel)]
    for screw, end in (
        ((foot + 0.004, 0.013, level), (0.0, 0.020, 0.0)),
        ((foot + arm_end - 0.01, 0.004, level), (0.0, 0.017, 0.0)),
    ):
        start = np.array(screw)
        path = start + np.linspace(0, 1, 3)[:, None] * np.array(end)
        parts.append(Part("screw", tube(path, 0.0025, up=(0.0, 0.0, 1.0), sides=12), steel))
        wing = slab([rounded_rectangle(0.020, 0.0055, 0.0025)], 0.004, 0.001)
        parts.append(Part("wing", moved(wing, start + np.array(end), rotation(0, np.pi / 2)), cast))
    grip = rng.uniform(0.010, 0.018)
    cork = plain(rng, "cork", (0.40, 0.26, 0.14), (0.85, 1.0))
    for sign in (-1.0, 1.0):
        t = np.linspace(0.0, 1.0, 22)
        x = foot + arm_end - 0.004 + 0.055 * t
        y = sign * (0.003 + grip * np.clip(np.sin(np.pi * np.clip(t * 0.9, 0, 1)) ** 0.7, 0, 1) + 0.002)
        path = np.stack([x, y, np.full_like(t, level)], 1)
        section = rounded_rectangle(0.004, 0.012, 0.0012, 3)
        parts.append(Part("finger", tube(path, section, up=(0.0, 0.0, 1.0)), cast))
        inner = path[8:17] - [0.0, sign * 0.0028, 0.0]
        parts.append(Part("lining", tube(inner, rounded_rectangle(0.0015, 0.011, 0.0005, 2), up=(0.0, 0.0, 1.0)), cork))
    return Thing(tuple(parts))
