"""Fruit: apples, oranges, lemons and bananas, as solids that no two share."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...core.mesh import Mesh
from ...core.model import Reflectance
from ..description.material import OpaqueMaterial, SurfacePattern
from ..materials.noise import value_noise
from ..patterns.draw import plain, surface
from ..props.blocks import face_grids
from ..props.normals import creased
from .parts import Part, Thing
from .solids import tube

Radius = Callable[[np.ndarray], np.ndarray]
"""From directions (n, 3) to radii (n,), in any unit."""

#: Diameters of table fruit [m]: marketing standards of the EU (543/2011) ask for apples from 60 mm, oranges from 53 mm
#: and lemons from 45 mm on; shops have these.
APPLE, ORANGE, LEMON = (0.062, 0.085), (0.063, 0.088), (0.050, 0.062)
#: Length of a banana along its outer curve and its thickness [m]: 543/2011's companion for bananas (1333/2011) asks
#: for 14 cm and 27 mm at least.
BANANA_LENGTH, BANANA_GIRTH = (0.15, 0.19), (0.031, 0.038)
#: Texels along a face of the cube of a skin [px]: 0.4 mm on an apple.
FACE = 150
#: Steps along an edge of the cube: 6 x 2 x 28^2 triangles, 2 mm on an apple.
STEPS = 28
#: Ground colours of skins and what is over them, matched by eye to ripe fruit, linear Rec.709.
_GREEN, _YELLOW, _RED, _DARK_RED = (0.27, 0.38, 0.05), (0.62, 0.50, 0.12), (0.42, 0.035, 0.03), (0.20, 0.012, 0.018)
_RUSSET = (0.26, 0.17, 0.07)
_ORANGES = ((0.72, 0.26, 0.018), (0.78, 0.36, 0.03), (0.10, 0.12, 0.035))
_LEMONS = ((0.78, 0.58, 0.05), (0.72, 0.60, 0.07), (0.14, 0.13, 0.04))
_BANANAS = ((0.74, 0.52, 0.065), (0.40, 0.46, 0.075), (0.055, 0.030, 0.014))


def apple(rng: np.random.Generator, wear: float) -> Thing:
    """Return an apple, standing: broad shoulders, hollows for stem and calyx, five faint ribs, a stem."""
    diameter = rng.uniform(*APPLE)
    tall, cavity, ribs = rng.uniform(0.82, 0.98), rng.uniform(0.20, 0.3), rng.uniform(0.0, 0.035)

    def radius(d: np.ndarray) -> np.ndarray:
        off_axis = np.hypot(d[:, 0], d[:, 1])
        azimuth = np.arctan2(d[:, 1], d[:, 0])
        top = cavity * np.exp(-((off_axis / 0.30) ** 2)) * (d[:, 2] > 0)
        low = 0.6 * cavity * np.exp(-((off_axis / 0.26) ** 2)) * (d[:, 2] < 0)
        # Widest above the middle, narrow at the foot.
        return (1.0 + 0.07 * d[:, 2]) * (1.0 - top - low) * (1.0 - ribs * (1 - off_axis) * np.cos(5 * azimuth))

    body = _fruit(rng, diameter, tall, radius, bumps=0.03)
    skins = ((_GREEN, _RED), (_YELLOW, _RED), (_GREEN, _GREEN), (_RED, _DARK_RED), (_YELLOW, _DARK_RED))
    ground, blush = skins[rng.integers(len(skins))]
    skin = _skin(rng, "apple skin", [ground, blush, _RUSSET], diameter, (0.22, 0.38), wear)
    hollow = float(body.vertices[np.hypot(*body.vertices[:, :2].T) < 0.05 * diameter][:, 2].max())
    start = np.array([0.0, 0.0, hollow - 0.002])
    lean = rng.normal(0.0, 0.004, 2)
    rise = rng.uniform(0.012, 0.022)
    path = start + np.linspace(0.0, 1.0, 8)[:, None] ** [[1.6, 1.6, 1.0]] * [*lean, rise]
    thick = np.array([1.1, 1.0, 0.9, 0.85, 0.85, 0.9, 1.1, 1.4]) * 0.0011
    stem = tube(path, thick, up=(1.0, 0.0, 0.0), sides=8)
    return Thing((Part("fruit", body, skin), Part("stem", stem, plain(rng, "wood", (0.10, 0.06, 0.03), (0.7, 0.9)))))


def orange(rng: np.random.Generator, wear: float) -> Thing:
    """Return an orange: a sphere a little flat at its ends."""
    diameter = rng.uniform(*ORANGE)
    body = _fruit(rng, diameter, rng.uniform(0.90, 1.0), lambda d: 1.0 - 0.05 * np.exp(-((_off(d) / 0.15) ** 2)), 0.02)
    return Thing((Part("fruit", body, _skin(rng, "citrus skin", _ORANGES, diameter, (0.32, 0.45), wear)),))


def lemon(rng: np.random.Generator, wear: float) -> Thing:
    """Return a lemon: an ellipsoid with a nipple at one end and a neck at the other, lying along x."""
    diameter = rng.uniform(*LEMON)
    nipple, neck = rng.uniform(0.12, 0.26), rng.uniform(0.03, 0.10)

    def radius(d: np.ndarray) -> np.ndarray:
        ends = nipple * np.exp(-((_off(d) / 0.22) ** 2)) * (d[:, 2] < 0)
        ends = ends + neck * np.exp(-((_off(d) / 0.3) ** 2)) * (d[:, 2] > 0)
        return 1.0 + ends

    body = _fruit(rng, diameter, rng.uniform(1.12, 1.3), radius, 0.04)
    lying = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    assert body.normals is not None
    body = Mesh("part", body.vertices @ lying.T, body.faces, body.normals @ lying.T, body.uv)
    return Thing((Part("fruit", body, _skin(rng, "citrus skin", _LEMONS, diameter, (0.3, 0.42), wear)),))


def banana(rng: np.random.Generator, wear: float) -> Thing:
    """Return a banana, lying on its side: five-sided, curved, with a stalk at one end and a tip at the other."""
    length, girth = rng.uniform(*BANANA_LENGTH), rng.uniform(*BANANA_GIRTH)
    bend = rng.uniform(0.7, 1.35)  # the turn from end to end [rad]
    t = np.linspace(0.0, 1.0, 48)
    # Straighter towards the stalk.
    angle = bend * (t - 0.5 + 0.12 * (t - 0.5) ** 2)
    step = length / (len(t) - 1)
    path = np.cumsum(np.stack([np.cos(angle), np.sin(angle), np.zeros_like(t)], 1) * step, axis=0)
    body = np.clip(np.minimum((t - 0.10) / 0.20, (1.0 - t) / 0.16), 0.0, 1.0)
    thick = girth / 2 * np.where(t < 0.5, 0.26 + 0.74 * _eased(body), 0.16 + 0.84 * np.sqrt(_eased(body)))
    turn = 2 * np.pi * np.arange(40) / 40
    five = 1.0 + 0.045 * np.cos(5 * turn)
    section = np.stack([np.cos(turn), np.sin(turn)], 1) * five[:, None]
    solid = tube(path, thick[:, None, None] * section, up=(0.0, 0.0, 1.0))
    assert solid.uv is not None
    extent = (float(length), float(solid.uv[:, 0].max()))
    swapped = Mesh("part", solid.vertices, solid.faces, solid.normals, solid.uv[:, ::-1])
    skin = surface(rng, "banana skin", "banana skin", _BANANAS, extent, (0.4, 0.55), size=(384, 192), wear=0.3 * wear)
    return Thing((Part("fruit", swapped, skin),))


def _fruit(rng: np.random.Generator, diameter: float, tall: float, radius: Radius, bumps: float) -> Mesh:
    """Return a star-shaped fruit, its radius a function of the direction, with coordinates on a cube's faces."""
    directions, faces, across = face_grids(STEPS)
    rounding = 1.0 + bumps * (value_noise(directions * 1.3 + 7.0, int(rng.integers(2**31)))[:, None] - 0.5)
    points = directions * radius(directions)[:, None] * rounding * [1.0, 1.0, tall]
    points *= diameter / np.ptp(points[:, :2], axis=0).max()
    face = np.repeat(np.arange(6), len(across) // 6)
    # The outermost texels' centres lie on a face's edges (`skins.cube_directions`).
    inner = 0.5 / FACE + across * (1.0 - 1.0 / FACE)
    uv = (np.stack([face % 3, face // 3], 1) + inner) / [3, 2]
    vertices, faces, normals, uv = creased(points.astype(np.float32).astype(float), faces, uv, np.pi)
    return Mesh("part", vertices, faces, normals, uv)


def _skin(
    rng: np.random.Generator,
    pattern: SurfacePattern,
    colours: Sequence[Reflectance],
    diameter: float,
    roughness: tuple[float, float],
    wear: float,
) -> OpaqueMaterial:
    quarter = np.pi / 4 * diameter
    extent, size = (float(3 * quarter), float(2 * quarter)), (3 * FACE, 2 * FACE)
    return surface(rng, pattern, pattern, colours, extent, roughness, size=size, wear=0.3 * wear, atlas=True)


def _off(directions: np.ndarray) -> np.ndarray:
    return np.hypot(directions[:, 0], directions[:, 1])


def _eased(t: np.ndarray) -> np.ndarray:
    return t * t * (3.0 - 2.0 * t)
