"""Everyday shapes of random proportions, made without files.

Proportions are chosen by eye after everyday objects unless a source is named; a rounding is the radius of an edge.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...core.mesh import Mesh
from .blocks import extrusion, rounded_box, stone, superellipsoid
from .revolution import arc, revolve, rounded

# Boxes: least side over the longest, and the rounding of edges over the shortest side.
_BOX_SIDE, _BOX_ROUNDING = 0.35, (0.02, 0.12)
# Books: width and thickness over the height (formats run from 2:3 to 4:5), bulge of the back over the thickness.
_BOOK_WIDTH, _BOOK_THICKNESS, _BOOK_BULGE = (0.67, 0.8), (0.10, 0.25), (0.1, 0.3)
# Prisms: numbers of sides (without the end), height over width of flat ones, width over height of tall ones.
_PRISM_SIDES, _FLAT_PRISM, _TALL_PRISM = (3, 9), (0.3, 1.0), (0.4, 1.0)
# Cylinders: least shorter over longer side, and the rounding over the radius (or half of the height).
_CYLINDER_SIDE, _CYLINDER_ROUNDING = 0.3, (0.02, 0.1)
# Cans: radius over height; width of the rim [m] (double seams are about 3 mm high), depth of the lid over that width.
_CAN_RADIUS, _CAN_RIM, _CAN_DEPTH = (0.25, 0.48), (0.0015, 0.003), (1.0, 1.6)
# Cones: least shorter over longer side, and the radius of the top over that of the base.
_CONE_SIDE, _CONE_TOP = 0.45, (0.05, 0.6)
# Rings: radius of the tube over that of its centre line.
_RING_TUBE = (0.15, 0.4)
# Capsules: length over width.
_CAPSULE_LENGTH = (1.3, 3.0)
# Cups: height over the longest side; radius of the rim over the longest side where the height is the longest; radius
# of the base over that of the rim; wall thickness [m] (stoneware mugs have 3-5 mm); rounding of the heel over the wall.
_CUP_HEIGHT, _CUP_RIM, _CUP_BASE, _CUP_WALL, _CUP_HEEL = (
    (0.7, 1.0),
    (0.36, 0.5),
    (0.6, 0.95),
    (0.0025, 0.005),
    (0.2, 0.6),
)
# Superellipsoids: least side over the longest, and the power: 2 is an ellipsoid, 5 a bar of soap.
_PILLOW_SIDE, _PILLOW_POWER = 0.4, (2.0, 5.0)
# Stones: least side over the longest, and the standard deviation of the radius, relative (`blocks.stone`).
_STONE_SIDE, _STONE_ROUGHNESS = 0.45, (0.04, 0.12)


@dataclass(frozen=True)
class Shape:
    """A closed solid in its object frame (origin at the centre of its bounding box).

    Parameters
    ----------
    mesh : Mesh
        Watertight, with normals and texture coordinates.
    category : str
        Name of the kind of shape, as in `SHAPES`.
    symmetric : bool
        Whether it is a solid of revolution about z.
    texture_unit : float
        Length on the surface of one unit of texture coordinate [m]. Whole numbers of repeats per unit leave no seam
        around a solid of revolution.
    """

    mesh: Mesh
    category: str
    symmetric: bool
    texture_unit: float


def draw_shape(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Draw a shape.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws.
    longest : float
        Longest side of its bounding box [m].
    name : str
        Name of the mesh.
    """
    category = tuple(SHAPES)[rng.integers(len(SHAPES))]
    return SHAPES[category](rng, longest, name)


def box(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a package or a toy block: sides of 0.35-1 of the longest, edges rounded by 2-12 % of the shortest."""
    size = _shuffled(rng, longest, _BOX_SIDE)
    mesh, unit = rounded_box(name, size, rng.uniform(*_BOX_ROUNDING) * min(size))
    return Shape(mesh, "box", False, unit)


def book(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a closed book, lying: a rounded back, a hollow fore edge, 2:3 to 4:5 wide, 10-25 % thick."""
    width, thick = longest * rng.uniform(*_BOOK_WIDTH), longest * rng.uniform(*_BOOK_THICKNESS)
    bulge = rng.uniform(*_BOOK_BULGE) * thick
    bend = np.linspace(-1.0, 1.0, 17)
    # Parabolas: the back bulges to -x, the fore edge is hollow by the same.
    back = np.stack([-bulge * (1 - bend**2), -bend * thick / 2], 1)
    front = np.stack([width - bulge * (1 - bend**2) * 0.7, bend * thick / 2], 1)
    mesh, unit = extrusion(name, np.concatenate([back, front]), longest)
    # The outline's plane becomes the xz plane: the book lies on its cover.
    turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)
    return Shape(
        Mesh(name, mesh.vertices @ turn.T, mesh.faces, mesh.normals @ turn.T, mesh.uv), "plain book", False, unit
    )


def prism(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a toy block over a regular polygon of 3-8 sides, flat to tall."""
    corners = int(rng.integers(*_PRISM_SIDES))
    turn = 2 * np.pi * np.arange(corners) / corners
    outline = np.stack([np.cos(turn), np.sin(turn)], 1)
    across, height = (1.0, rng.uniform(*_FLAT_PRISM)) if rng.random() < 0.5 else (rng.uniform(*_TALL_PRISM), 1.0)
    outline *= across * longest / np.ptp(outline, axis=0).max()
    mesh, unit = extrusion(name, outline, height * longest)
    return Shape(mesh, "prism", False, unit)


def cylinder(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a rod, a puck or a candle, edges rounded by 2-10 % of its radius."""
    radius, height = _round_size(rng, longest, _CYLINDER_SIDE)
    edge = rng.uniform(*_CYLINDER_ROUNDING) * min(radius, height / 2)
    profile = rounded([(0, 0), (radius, 0), (radius, height), (0, height)], [edge, edge])
    return _revolved(name, "cylinder", profile)


def can(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a tin: taller than wide, lid and base sunk behind a rim of 1.5-3 mm (double seams are about 3 mm)."""
    height = longest
    radius = height * rng.uniform(*_CAN_RADIUS)
    rim = rng.uniform(*_CAN_RIM)
    depth = rim * rng.uniform(*_CAN_DEPTH)
    inside = radius - rim
    corners = [(0, depth), (inside, depth), (inside, 0), (radius, 0)]
    corners += [(r, height - z) for r, z in reversed(corners)]
    edge = rim * 0.45
    return _revolved(name, "plain can", rounded(corners, [edge] * 6))


def ball(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a sphere."""
    return _revolved(name, "ball", [arc((0.0, 0.0), longest / 2, -np.pi / 2, np.pi / 2)])


def cone(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a blunt cone: its top has 5-60 % of its base's radius."""
    radius, height = _round_size(rng, longest, _CONE_SIDE)
    top = radius * rng.uniform(*_CONE_TOP)
    edge = 0.3 * min(top, height / 2)
    return _revolved(name, "cone", rounded([(0, 0), (radius, 0), (top, height), (0, height)], [edge, edge]))


def ring(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a torus whose tube is 15-40 % of its middle circle's radius."""
    tube = rng.uniform(*_RING_TUBE)
    middle = longest / 2 / (1 + tube)
    # The profile starts at the inner equator, so that the one seam of the texture is inside the hole.
    profile = [arc((middle, 0.0), tube * middle, -np.pi, np.pi)]
    return _revolved(name, "ring", profile, closed=True)


def capsule(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a pill: a cylinder with half spheres for ends, 1.3-3 times as long as wide."""
    radius = longest / rng.uniform(*_CAPSULE_LENGTH) / 2
    straight = longest / 2 - radius
    low = arc((0.0, -straight), radius, -np.pi / 2, 0.0)
    high = arc((0.0, straight), radius, 0.0, np.pi / 2)
    between = rounded([(radius, -straight), (radius, straight)], [])
    return _revolved(name, "capsule", [low, *between, high])


def cup(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a cup without a handle, as a closed solid: walls of 2.5-5 mm (stoneware mugs have 3-5 mm)."""
    height = longest * rng.uniform(*_CUP_HEIGHT)
    top = longest * rng.uniform(*_CUP_RIM) if height == longest else longest / 2
    # Below 6 cm the wall becomes thinner with the cup, so that the floor has room.
    base, wall = top * rng.uniform(*_CUP_BASE), min(rng.uniform(*_CUP_WALL), 0.08 * longest)
    corners = [(0, 0), (base, 0), (top, height), (top - wall, height), (base - wall, wall), (0, wall)]
    heel, lip = rng.uniform(*_CUP_HEEL) * wall, 0.4 * wall
    return _revolved(name, "cup", rounded(corners, [heel + wall, lip, lip, heel]))


def pillow(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a superellipsoid between an egg (power 2) and a bar of soap (power 5)."""
    mesh, unit = superellipsoid(name, _shuffled(rng, longest, _PILLOW_SIDE), rng.uniform(*_PILLOW_POWER))
    return Shape(mesh, "superellipsoid", False, unit)


def pebble(rng: np.random.Generator, longest: float, name: str) -> Shape:
    """Return a stone: a bumpy ellipsoid."""
    mesh, unit = stone(name, _shuffled(rng, longest, _STONE_SIDE), rng.uniform(*_STONE_ROUGHNESS), rng)
    return Shape(mesh, "stone", False, unit)


#: All shapes by category, equally probable.
SHAPES: dict[str, Callable[[np.random.Generator, float, str], Shape]] = {
    "box": box,
    "plain book": book,
    "prism": prism,
    "cylinder": cylinder,
    "plain can": can,
    "ball": ball,
    "cone": cone,
    "ring": ring,
    "capsule": capsule,
    "cup": cup,
    "superellipsoid": pillow,
    "stone": pebble,
}


def _revolved(name: str, category: str, profile: list, closed: bool = False) -> Shape:
    mesh, unit = revolve(name, profile, closed)
    return Shape(mesh, category, True, unit)


def _shuffled(rng: np.random.Generator, longest: float, least: float) -> tuple[float, float, float]:
    """Return three sides in any order, one the longest and the others at least `least` of it."""
    x, y, z = rng.permutation([1.0, *rng.uniform(least, 1.0, 2)]) * longest
    return float(x), float(y), float(z)


def _round_size(rng: np.random.Generator, longest: float, least: float) -> tuple[float, float]:
    """Return radius and height, flat or tall; the shorter of width and height is at least `least` of the longer."""
    ratio = rng.uniform(least, 1.0)
    width, height = (1.0, ratio) if rng.random() < 0.5 else (ratio, 1.0)
    return width * longest / 2, height * longest
