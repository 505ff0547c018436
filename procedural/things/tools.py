"""Tools: screwdrivers, spanners, pliers."""

from __future__ import annotations

import numpy as np

from ...core.mesh import Mesh
from ...core.model import Reflectance
from ..patterns.draw import metal, plain, plastic
from .parts import Part, Thing
from .solids import circle, loft, moved, slab, tube

#: Handle and blade of screwdrivers [m]: blades of 75-125 mm x 4-6 mm (ISO 2380-2: 5.5 x 100, 6.5 x 125 ...).
HANDLE, HANDLE_RADIUS, BLADE, BLADE_RADIUS = (0.085, 0.11), (0.012, 0.016), (0.070, 0.125), (0.0022, 0.0032)
#: Widths across flats of combination spanners [m] (ISO 272 series), lengths by DIN 3113 A are about these:
#: 8 -> 120 mm, 10 -> 140 mm, 13 -> 170 mm, 17 -> 205 mm.
SPANNERS = ((0.008, 0.120), (0.010, 0.140), (0.013, 0.170), (0.017, 0.205))
#: Length of combination pliers [m]: 160, 180 and 200 mm (DIN ISO 5746).
PLIERS = (0.160, 0.180, 0.200)
#: Colours of grips: red, yellow, blue, black, orange, green, linear Rec.709.
GRIPS: tuple[Reflectance, ...] = (
    (0.45, 0.02, 0.015),
    (0.72, 0.48, 0.02),
    (0.02, 0.09, 0.36),
    (0.025, 0.025, 0.027),
    (0.72, 0.20, 0.01),
    (0.02, 0.22, 0.06),
)


def screwdriver(rng: np.random.Generator, wear: float) -> Thing:
    """Return a screwdriver, lying along x: a fluted handle, a shaft, a flat or a crossed tip."""
    handle, radius = rng.uniform(*HANDLE), rng.uniform(*HANDLE_RADIUS)
    blade, thin = rng.uniform(*BLADE), rng.uniform(*BLADE_RADIUS)
    x = np.array([0, 0.004, 0.012, 0.03, 0.5, 0.62, 0.72, 0.80, 0.88, 0.95, 1.0, 1.0])
    r = np.array([0.45, 0.75, 0.93, 1.0, 0.98, 0.90, 0.72, 0.66, 0.70, 0.66, 0.50, 0.42]) * radius
    fluted = np.array([0, 0, 0.3, 1, 1, 0.8, 0.3, 0, 0, 0, 0, 0])
    turn = 2 * np.pi * np.arange(60) / 60
    lobes = int(rng.integers(5, 7))
    depth = 0.11 * np.abs(np.sin(lobes * turn / 2)) ** 0.7 - 0.11
    rings = _rings(x * handle, r[:, None] * (1.0 + fluted[:, None] * depth), turn)
    colour = GRIPS[rng.integers(len(GRIPS))]
    grip = plastic(rng, wear, colour)
    collar = loft(_rings(np.array([0.12, 0.121, 0.17, 0.171]) * handle, np.full((4, 1), 1.004 * radius), turn))
    shaft = _shaft(rng, handle - 0.004, blade, thin)
    return Thing(
        (
            Part("handle", moved(loft(rings), (0, 0, radius)), grip),
            Part("band", moved(collar, (0, 0, radius)), plain(rng, "plastic", GRIPS[rng.integers(6)], (0.3, 0.5))),
            Part("shaft", moved(shaft, (0, 0, radius)), metal(rng, wear, "steel", 0.5)),
        )
    )


def _shaft(rng: np.random.Generator, start: float, length: float, radius: float) -> Mesh:
    turn = 2 * np.pi * np.arange(24) / 24
    if rng.random() < 0.5:  # a flat tip
        x = np.array([0.0, 0.80, 0.86, 0.94, 1.0]) * length + start
        wide, high = np.array([1.0, 1.0, 1.15, 1.25, 1.15]) * radius, np.array([1.0, 1.0, 0.7, 0.3, 0.18]) * radius
        y, z = wide[:, None] * np.cos(turn), high[:, None] * np.sin(turn)
        return loft(np.stack([np.broadcast_to(x[:, None], y.shape), y, z], 2))
    x = np.array([0.0, 0.90, 0.925, 0.985, 1.0]) * length + start
    r = np.array([1.0, 1.0, 0.85, 0.35, 0.2]) * radius
    cross = 1.0 - np.array([0, 0, 0.4, 0.5, 0.4])[:, None] * np.abs(np.sin(2 * turn)) ** 1.5
    return loft(_rings(x, r[:, None] * cross, turn))


def _rings(x: np.ndarray, radius: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return rings about the x axis, (n, m, 3): radii (n, m) or (n, 1) over angles (m,)."""
    y, z = radius * np.cos(turn), radius * np.sin(turn)
    return np.stack([np.broadcast_to(x[:, None], y.shape), y, z], 2)


def spanner(rng: np.random.Generator, wear: float) -> Thing:
    """Return a combination spanner, lying: an open jaw at 15 degrees, a ring of twelve points, a waisted shaft."""
    import manifold3d

    flats, length = SPANNERS[rng.integers(len(SPANNERS))]
    length *= rng.uniform(0.97, 1.04)  # makers differ
    head, ring = 1.05 * flats, 0.78 * flats
    grip = 0.38 * flats
    jaw = manifold3d.CrossSection([circle(head, 48, (head, 0.0))])
    slot = manifold3d.CrossSection(
        [np.array([[-1.4, -0.5], [0.35, -0.5], [0.55, 0], [0.35, 0.5], [-1.4, 0.5]]) * flats]
    )
    slot = slot.rotate(15.0).translate((head, 0.0))
    shaft = np.array([[head, -1.25 * grip], [0.4 * length, -grip], [length - ring, -1.1 * grip]])
    shaft = manifold3d.CrossSection([np.concatenate([shaft, shaft[::-1] * [1, -1]])])
    eye = manifold3d.CrossSection([circle(ring, 48, (length - ring, 0.0))])
    turn = 2 * np.pi * np.arange(24) / 24
    points = np.where(np.arange(24) % 2, 0.535, 0.565) * flats
    hole = np.stack([points * np.cos(turn) + length - ring, points * np.sin(turn)], 1)
    section = (jaw + shaft + eye).offset(-0.3 * grip, manifold3d.JoinType.Round, 2.0, 32)
    # Grown back by a rounding: inner corners become fillets.
    section = section.offset(0.3 * grip, manifold3d.JoinType.Round, 2.0, 32)
    section = section.offset(0.6 * grip, manifold3d.JoinType.Round, 2.0, 32).offset(
        -0.6 * grip, manifold3d.JoinType.Round, 2.0, 32
    )
    section = (section - slot - manifold3d.CrossSection([hole])).simplify(6e-5)
    mesh = slab([np.asarray(contour, float) for contour in section.to_polygons()], 0.42 * flats, 0.0005)
    chrome = metal(rng, wear, "steel", 0.35)
    return Thing((Part("spanner", mesh, chrome),))


def pliers(rng: np.random.Generator, wear: float) -> Thing:
    """Return combination pliers, lying, closed: two jaws, a rivet, two handles in sleeves."""
    length = PLIERS[rng.integers(len(PLIERS))]
    jaw, thick = 0.24 * length, 0.052 * length
    half = np.array(
        [
            [0.0, 0.0006],
            [jaw, 0.0006],
            [jaw, 0.02 * length],
            [0.75 * jaw, 0.042 * length],
            [0.25 * jaw, 0.062 * length],
            [0.0, 0.068 * length],
            [-0.05 * length, 0.056 * length],
            [-0.09 * length, 0.038 * length],
            [-0.09 * length, 0.01 * length],
            [-0.02 * length, 0.0006],
        ]
    )
    steel = metal(rng, wear, "steel", 0.7)
    dark = steel.model_copy(update={"name": "burnished steel"}) if rng.random() < 0.5 else steel
    colour = GRIPS[rng.integers(len(GRIPS))]
    sleeve = plastic(rng, wear, colour)
    upper = slab([half], thick, 0.0007)
    lower = slab([half[::-1] * [1, -1]], thick, 0.0007)
    disc = slab([circle(0.036 * length, 40)], thick + 0.0012, 0.0008)
    gap = rng.uniform(0.020, 0.045) * length
    parts = [Part("jaw", moved(upper, (0, 0, thick / 2)), dark), Part("jaw", moved(lower, (0, 0, thick / 2)), dark)]
    parts.append(Part("rivet", moved(disc, (0, 0, thick / 2)), dark))
    t = np.linspace(0.0, 1.0, 26)
    reach = length - jaw - 0.06 * length
    for sign in (1.0, -1.0):
        bow = 0.026 * length + gap * np.sin(np.pi * np.clip(t, 0, 0.93)) + gap * 0.6 * t
        path = np.stack([-0.06 * length - reach * t, sign * bow, np.full_like(t, thick / 2)], 1)
        size = np.where(t < 0.12, 0.72, 1.0) * (1.0 + 0.12 * np.sin(np.pi * t)) * np.clip((1.02 - t) / 0.05, 0.25, 1.0)
        oval = np.stack(
            [
                0.030 * length * np.cos(2 * np.pi * np.arange(20) / 20),
                0.48 * thick * np.sin(2 * np.pi * np.arange(20) / 20),
            ],
            1,
        )
        parts.append(Part("handle", tube(path, size[:, None, None] * oval, up=(0.0, 0.0, 1.0)), sleeve))
    return Thing(tuple(parts))
