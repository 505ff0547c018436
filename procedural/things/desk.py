"""Things of a desk: pens and pencils, phones, cables."""

from __future__ import annotations

import numpy as np

from ..materials.draw import paint_colour
from ..patterns.draw import INKS, SIDE, WOODS, metal, plain, plastic, surface
from ..props.revolution import rounded
from .parts import Part, Thing, some
from .solids import circle, faces_of_pieces, loft, moved, rotation, rounded_rectangle, slab, tube, turned

#: Length and diameter of ballpoint pens [m]; pencils are 175 mm x 7 mm new (ISO 9180 leaves the sizes free).
PEN, PEN_DIAMETER, PENCIL, PENCIL_ACROSS = (0.135, 0.150), (0.0085, 0.012), (0.09, 0.176), 0.0069
#: Height, width and thickness of phones [m]: 6.1 to 6.7 inch models.
PHONE, PHONE_ASPECT, PHONE_THICK = (0.142, 0.164), (0.465, 0.49), (0.0073, 0.0090)
#: Diameter of cables [m]: USB 3.5-4.5 mm, mains 6-7 mm; radius of their coils and number of turns.
CABLE, COIL, TURNS = (0.0034, 0.0065), (0.035, 0.065), (1.6, 3.6)


def pen(rng: np.random.Generator, wear: float) -> Thing:
    """Return a ballpoint pen or a pencil, lying along x."""
    return _pencil(rng, wear) if rng.random() < 0.45 else _ballpoint(rng, wear)


def _ballpoint(rng: np.random.Generator, wear: float) -> Thing:
    length, radius = rng.uniform(*PEN), rng.uniform(*PEN_DIAMETER) / 2
    tip, button = 0.018, 0.011
    corners = [(0.0, 0.0), (0.0006, 0.0), (0.0011, 0.003), (0.62 * radius, tip), (radius, tip + 0.012)]
    corners += [(radius, 0.40 * length), (1.06 * radius, 0.402 * length), (1.06 * radius, 0.42 * length)]
    corners += [(radius, 0.422 * length), (radius, length - button - 0.003), (0.7 * radius, length - button)]
    corners += [(0.52 * radius, length - button), (0.5 * radius, length - 0.001), (0.0, length)]
    pieces = rounded(corners, [0.0] * (len(corners) - 2))
    barrel = turned(pieces)
    low, index = np.array([piece.points[0, 1] for piece in pieces]), faces_of_pieces(barrel, pieces)
    height = low[index]
    shiny = (
        (height < tip - 1e-6)
        | (height >= 0.40 * length - 1e-6) & (height < 0.42 * length)
        | (height >= length - button - 0.003 - 1e-6)
    )
    clip = slab([rounded_rectangle(0.042, 0.0035, 0.0017)], 0.0008, 0.0002)
    clip = moved(clip, (0.0, radius + 0.0016, length - button - 0.025), rotation(1, np.pi / 2) @ rotation(0, np.pi / 2))
    bridge = slab([rounded_rectangle(0.0032, 0.0032, 0.0008)], 0.0022, 0.0002)
    bridge = moved(bridge, (0.0, radius + 0.0004, length - button - 0.007), rotation(0, np.pi / 2))
    lying, chrome = rotation(1, np.pi / 2), metal(rng, wear, "steel", 0.2)
    ink = plastic(rng, wear, INKS[rng.integers(len(INKS))] if rng.random() < 0.7 else paint_colour(rng))
    parts = [("barrel", some(barrel, ~shiny), ink), ("point and button", some(barrel, shiny), chrome)]
    parts += [("clip", clip, chrome), ("clip", bridge, chrome)]
    return Thing(tuple(Part(name, moved(mesh, turn=lying), material) for name, mesh, material in parts))


def _pencil(rng: np.random.Generator, wear: float) -> Thing:
    length, apothem = rng.uniform(*PENCIL), PENCIL_ACROSS / 2
    cone = rng.uniform(0.018, 0.024)
    turn = 2 * np.pi * np.arange(36) / 36
    six = apothem / np.cos((turn + np.pi / 6) % (np.pi / 3) - np.pi / 6)
    start = [0.0, 0.0006, length - cone]
    rings = [
        np.stack([six * f * np.cos(turn), six * f * np.sin(turn), np.full(36, z)], 1)
        for f, z in zip((0.94, 1.0, 1.0), start, strict=True)
    ]
    body = loft(np.array(rings), np.radians(20.0))
    point, lead_start = np.linspace(0.0, 1.0, 6), 0.68
    shape = [(1.0 - 0.9 * t, length - cone + cone * t) for t in point]
    sharpened = np.array(
        [
            np.stack([apothem * 0.995 * f * np.cos(turn), apothem * 0.995 * f * np.sin(turn), np.full(36, z)], 1)
            for f, z in shape
        ]
    )
    wood = loft(sharpened[point <= lead_start])
    last = 1.0 - 0.9 * 0.6
    tips = [(last + 0.004, length - cone * 0.4), (0.10, length - 0.0006), (0.03, length)]
    lead = loft(
        np.array(
            [np.stack([apothem * f * np.cos(turn), apothem * f * np.sin(turn), np.full(36, z)], 1) for f, z in tips]
        )
    )
    paint = surface(
        rng, "lacquer", "lacquer", [INKS[rng.integers(len(INKS))]], (0.05, 0.05), (0.15, 0.3), size=(96, 96), wear=wear
    )
    cedar = surface(rng, "cedar", "solid wood", WOODS["cherry"], (0.03, 0.02), (0.6, 0.8), size=(64, 64))
    lying = rotation(1, np.pi / 2)
    parts = (
        ("lacquered wood", body, paint),
        ("sharpened wood", wood, cedar),
        ("lead", lead, plain(rng, "graphite", (0.03, 0.03, 0.033), (0.35, 0.5))),
    )
    return Thing(tuple(Part(name, moved(mesh, turn=lying), material) for name, mesh, material in parts))


def phone(rng: np.random.Generator, wear: float) -> Thing:
    """Return a phone, lying with its screen up, switched off."""
    high = rng.uniform(*PHONE)
    wide, thick, corner = high * rng.uniform(*PHONE_ASPECT), rng.uniform(*PHONE_THICK), rng.uniform(0.007, 0.012)
    body = moved(slab([rounded_rectangle(high, wide, corner, 10)], thick, 0.0016), (0.0, 0.0, thick / 2))
    glass = moved(
        slab([rounded_rectangle(high - 0.003, wide - 0.003, corner - 0.0015, 10)], 0.0004, 0.0001),
        (0, 0, thick + 0.0001),
    )
    bump = slab([rounded_rectangle(0.036, 0.036, 0.009, 8)], 0.0016, 0.0004)
    bump = moved(bump, (high / 2 - 0.026, wide / 2 - 0.024, -0.0004))
    dark = surface(
        rng,
        "cover glass",
        "screen",
        [(0.006, 0.006, 0.007)],
        (high, wide),
        (0.02, 0.05),
        size=(2 * SIDE, SIDE),
        wear=0.4 * wear,
    )
    shell = plastic(rng, wear, (0.03, 0.03, 0.033) if rng.random() < 0.5 else paint_colour(rng))
    parts = [Part("shell", body, shell), Part("screen", glass, dark), Part("camera", bump, shell)]
    for x, y in ((0.008, 0.008), (-0.008, -0.008), (0.008, -0.008)):
        lens = moved(slab([circle(0.0062, 28)], 0.0010, 0.0002), (high / 2 - 0.026 + x, wide / 2 - 0.024 + y, -0.0014))
        parts.append(Part("lens", lens, dark))
    return Thing(tuple(parts))


def cable(rng: np.random.Generator, wear: float) -> Thing:
    """Return a cable that was coiled by hand, with a plug at each end."""
    radius, coil = rng.uniform(*CABLE) / 2, rng.uniform(*COIL)
    turns = rng.uniform(*TURNS)
    t = np.linspace(0.0, 1.0, int(70 * turns) + 40)
    angle = 2 * np.pi * turns * t
    wobble = sum(rng.normal(0.0, 0.05) * np.cos(k * angle / turns + rng.uniform(0, 6.28)) for k in (1.37, 2.61, 4.3))
    size = coil * (1.0 + wobble + rng.uniform(-0.2, 0.2) * (t - 0.5))
    # Each turn lies on the one before, and the ends lead away.
    free = np.clip((t - 0.88) / 0.12, 0.0, 1.0) ** 2 - np.clip((0.12 - t) / 0.12, 0.0, 1.0) ** 2
    size = size * (1.0 + 0.8 * np.abs(free))
    z = radius + 2.05 * radius * turns * t * (1.0 - np.clip((t - 0.88) / 0.12, 0.0, 1.0))
    path = np.stack([size * np.cos(angle), rng.uniform(0.75, 1.0) * size * np.sin(angle), z], 1)
    colour = ((0.02, 0.02, 0.022), (0.70, 0.69, 0.67), (0.20, 0.20, 0.21), paint_colour(rng))[rng.integers(4)]
    jacket = plain(rng, "PVC", colour, (0.35, 0.6))
    chrome = metal(rng, wear, "steel", 0.3)
    parts = [Part("cable", tube(path, radius, sides=9), jacket)]
    for end, inward in ((path[0], path[3]), (path[-1], path[-4])):
        out = end - inward
        across = np.arctan2(out[1], out[0])
        turn = rotation(2, float(across))
        grip = moved(
            slab([rounded_rectangle(0.022, 0.0115, 0.003)], 0.0065, 0.0012),
            turn @ [0.010, 0, 0] + [*end[:2], 0.0034],
            turn,
        )
        shell = moved(
            slab([rounded_rectangle(0.0075, 0.0083, 0.0006)], 0.0026, 0.0003),
            turn @ [0.0245, 0, 0] + [*end[:2], 0.0034],
            turn,
        )
        parts += [Part("plug", grip, jacket), Part("contacts", shell, chrome)]
    return Thing(tuple(parts))
