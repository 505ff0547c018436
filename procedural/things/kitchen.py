"""Cutlery, plates, bowls, trays, mugs, napkins and sponges."""

from __future__ import annotations

import numpy as np

from ...core.mesh import Mesh
from ..description.material import OpaqueMaterial, SurfaceTexture
from ..materials.draw import paint_colour
from ..patterns.draw import ceramic, metal, plastic, surface, wooden
from ..props.blocks import rounded_box
from ..props.revolution import Piece, rounded
from .parts import Part, Thing, some
from .solids import faces_of_pieces, loft, moved, projected, rounded_rectangle, tube, turned

#: Lengths of table forks, knives and spoons, and of tea spoons [m]: EN ISO 8442 leaves them free; sets have these.
FORK, KNIFE, SPOON, TEA_SPOON = (0.185, 0.210), (0.215, 0.240), (0.190, 0.215), (0.130, 0.150)
#: Diameters of plates from saucers to dinner plates, and their height over it [m], [1].
PLATE, PLATE_HEIGHT = (0.14, 0.27), (0.07, 0.11)
#: Diameters of bowls [m], and their height over it.
BOWL, BOWL_HEIGHT = (0.11, 0.18), (0.36, 0.52)
#: Diameter, height and wall of mugs of 250 to 400 ml [m].
MUG, MUG_HEIGHT, MUG_WALL = (0.074, 0.094), (0.080, 0.110), (0.0035, 0.005)
#: Sides of trays [m] (small serving trays; cafeteria trays of 325 x 265 mm are GN 1/2), height of their rim [m].
TRAY_LONG, TRAY_SHORT, TRAY_RIM = (0.24, 0.36), (0.62, 0.8), (0.012, 0.03)
#: Side of a napkin that is folded once or twice more [m]: 40 to 50 cm open, a quarter of that here.
NAPKIN = (0.16, 0.22)
#: Sponge with scouring fleece: 110 x 70 x 30 mm in the trade, 20 % more or less.
SPONGE = (0.110, 0.070, 0.022)


def plate(rng: np.random.Generator, wear: float) -> Thing:
    """Return a plate on a foot ring, with a rim."""
    radius = rng.uniform(*PLATE) / 2
    height, wall = 2 * radius * rng.uniform(*PLATE_HEIGHT), 0.0042
    well = radius * rng.uniform(0.58, 0.68)
    foot = well * 0.9
    corners = [(0.0, 0.0025), (foot - 0.006, 0.0025), (foot - 0.004, 0.0), (foot, 0.0), (well + 0.004, 0.0035)]
    corners += [(radius - 0.002, height - wall), (radius, height - 0.001), (radius - 0.0015, height)]
    corners += [(well + 0.006, height * 0.45 + wall * 0.6), (well - 0.012, 0.0025 + wall), (0.0, 0.0025 + wall)]
    radii = [0.0015, 0.0012, 0.0012, 0.012, 0.001, 0.0008, 0.0008, 0.006, 0.012]
    return _thrown(rng, wear, rounded(corners, radii), radius, bands=int(rng.integers(0, 3)))


def bowl(rng: np.random.Generator, wear: float) -> Thing:
    """Return a bowl with a foot ring and a round inside."""
    radius = rng.uniform(*BOWL) / 2
    height, wall, foot = 2 * radius * rng.uniform(*BOWL_HEIGHT), rng.uniform(0.0032, 0.005), radius * 0.48
    belly = rng.uniform(0.5, 0.9)
    corners = [(0.0, 0.003), (foot - 0.006, 0.003), (foot - 0.004, 0.0), (foot, 0.0), (foot + 0.001, 0.005)]
    corners += [(radius - belly * 0.25 * radius * 0.4, height * 0.36), (radius, height)]
    corners += [
        (radius - wall, height),
        (radius - wall - belly * 0.1 * radius, height * 0.40),
        (foot * 0.8, 0.003 + wall),
    ]
    corners += [(0.0, 0.003 + wall)]
    curve = 0.30 * radius
    radii = [0.001, 0.001, 0.001, 0.002, curve, 0.45 * wall, 0.45 * wall, curve, 0.25 * radius]
    return _thrown(rng, wear, rounded(corners, radii), radius, bands=int(rng.integers(0, 3)))


def mug(rng: np.random.Generator, wear: float) -> Thing:
    """Return a ceramic mug with a handle, standing."""
    radius, height, wall = rng.uniform(*MUG) / 2, rng.uniform(*MUG_HEIGHT), rng.uniform(*MUG_WALL)
    base = radius * rng.uniform(0.78, 1.0)
    corners = [(0.0, 0.002), (base - 0.008, 0.002), (base - 0.006, 0.0), (base - 0.002, 0.0), (base, 0.006)]
    corners += [(radius, height), (radius - wall, height), (base - wall, 0.012), (0.0, 0.002 + wall)]
    radii = [0.001, 0.0008, 0.0015, 0.004, 0.45 * wall, 0.45 * wall, 0.006]
    body = turned(rounded(corners, radii))
    glazed = ceramic(rng, wear, (float(2 * np.pi * radius), float(height)), bands=int(rng.integers(0, 4)))
    side = (base + radius) / 2 - 0.4 * wall
    reach, tall = rng.uniform(0.026, 0.036), height * rng.uniform(0.5, 0.66)
    turn = np.linspace(-np.pi / 2, np.pi / 2, 25)
    path = np.stack([side + reach * np.cos(turn) ** 0.8, 0 * turn, height * 0.52 + tall / 2 * np.sin(turn)], 1)
    # Thicker at the ends, where it is joined to the wall.
    swell = 1.0 + 0.35 * np.abs(turn / (np.pi / 2)) ** 6
    oval = rounded_rectangle(0.013, 0.0075, 0.0036, 4)
    handle = tube(path, swell[:, None, None] * oval, up=(0.0, 0.0, 1.0))
    # Bands are painted on the wheel, so the handle has none.
    texture = glazed.base_colour
    assert isinstance(texture, SurfaceTexture)
    alike = texture.model_copy(update={"pattern": "glaze", "colours": texture.colours[:1]})
    bare = glazed.model_copy(update={"base_colour": alike})
    return Thing((Part("body", body, glazed), Part("handle", handle, bare)))


def _thrown(rng: np.random.Generator, wear: float, profile: list[Piece], radius: float, bands: int) -> Thing:
    """Return a thrown dish; its flat middle has a texture of its own, since around the axis it would be a star."""
    mesh = turned(profile)
    assert mesh.uv is not None
    # From the middle of the underside to that of the inside: bands lie on the inside of the rim.
    around, along = float(2 * np.pi * radius), float(mesh.uv[:, 1].max())
    rim = float(mesh.uv[np.argmax(mesh.vertices[:, 2]), 1])
    shift = 0.78 * along - rim - rng.uniform(0.004, 0.012)
    mesh = Mesh("part", mesh.vertices, mesh.faces, mesh.normals, mesh.uv + np.array([0.0, shift], np.float32))
    glazed = ceramic(rng, wear, (around, along), bands)
    reach = np.array([piece.points[:, 0].max() for piece in profile])
    middle = reach[faces_of_pieces(mesh, profile)] < 0.75 * radius
    texture = glazed.base_colour
    assert isinstance(texture, SurfaceTexture)
    plain_ = surface(
        rng,
        glazed.name,
        "glaze",
        texture.colours[:1],
        (0.1, 0.1),
        (glazed.roughness, glazed.roughness),
        wear=texture.wear,
    )
    parts = Part("rim", some(mesh, ~middle), glazed), Part("middle", some(mesh, middle, planar=True), plain_)
    return Thing(parts, symmetric=bands == 0)


def tray(rng: np.random.Generator, wear: float) -> Thing:
    """Return a tray with a slanted rim and round corners, of wood, plastic or steel."""
    long_side = rng.uniform(*TRAY_LONG)
    short_side, rim, wall = long_side * rng.uniform(*TRAY_SHORT), rng.uniform(*TRAY_RIM), rng.uniform(0.002, 0.004)
    corner, slant = rng.uniform(0.02, 0.05), rng.uniform(0.15, 0.6) * rim
    profile = [(slant, 0.0), (slant - 0.001, 0.0004), (0.0, rim - wall / 2), (-0.004, rim - 0.001), (-0.004, rim)]
    profile += [
        (wall * 0.4, rim),
        (wall * 1.2, rim - 0.001),
        (slant + wall, wall + 0.001),
        (slant + wall + 0.003, wall),
    ]
    rings = []
    for inset, z in profile:
        outline = rounded_rectangle(long_side - 2 * inset, short_side - 2 * inset, max(0.004, corner - inset))
        rings.append(np.column_stack([outline, np.full(len(outline), z)]))
    mesh = projected(loft(np.array(rings)))
    return Thing((Part("tray", mesh, _tray_material(rng, wear, (long_side, short_side))),))


def _tray_material(rng: np.random.Generator, wear: float, extent: tuple[float, float]) -> OpaqueMaterial:
    kind = rng.random()
    if kind < 0.45:
        return wooden(rng, (float(extent[0]), float(extent[1])), wear)
    if kind < 0.8:
        return plastic(rng, wear)
    return metal(rng, wear, "steel", 0.8)


def napkin(rng: np.random.Generator, wear: float) -> Thing:
    """Return a folded cloth napkin: its layers sag a little, and the fold is thicker than the edges."""
    from .solids import sheet

    long_side = rng.uniform(*NAPKIN)
    short_side = long_side * (1.0 if rng.random() < 0.5 else 0.5)
    thick = rng.uniform(0.0025, 0.004) * (1.0 if short_side == long_side else 1.7)
    steps = 49
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, steps), np.linspace(-0.5, 0.5, steps), indexing="ij")
    skew = rng.normal(0.0, 0.012, 4)
    x = long_side * (u + skew[0] * v + skew[1] * u * v)
    y = short_side * (v + skew[2] * u + skew[3] * u * v)
    wave = rng.normal(size=(3, 4)) * [6.0, 6.0, 3.0, 0.35]
    lift = sum(np.cos(a * u + b * v + c) * d for a, b, c, d in wave)
    edge = np.minimum(np.minimum(u + 0.5, 0.5 - u) * long_side, np.minimum(v + 0.5, 0.5 - v) * short_side)
    # The folds on two sides bulge; the open edges are as thin as their layers pressed together.
    fold = np.exp(-(((u + 0.5) * long_side / 0.006) ** 2)) + np.exp(-(((v + 0.5) * short_side / 0.006) ** 2))
    top = thick * (0.75 + 0.35 * np.clip(lift, -1, 1)) * (0.55 + 0.45 * np.clip(edge / 0.012, 0, 1)) + 0.0008 * fold
    crease_ = 0.0005 * np.exp(-((u * long_side / 0.0025) ** 2)) if rng.random() < 0.5 else 0.0
    mesh = sheet(np.stack([x, y, top + crease_], 2), np.stack([x, y, np.zeros_like(x)], 2), crease=np.radians(60.0))
    pattern = ("cloth", "striped cloth", "checked cloth")[rng.integers(3)]
    colours = [(0.66, 0.62, 0.54) if rng.random() < 0.5 else paint_colour(rng), paint_colour(rng)]
    colours = [colours[0], colours[0]] if pattern == "cloth" else colours
    cloth = surface(rng, "cotton", pattern, colours, (0.12, 0.12), (0.85, 1.0), size=(256, 256), wear=wear)
    return Thing((Part("napkin", mesh, cloth),))


def sponge(rng: np.random.Generator, wear: float) -> Thing:
    """Return a kitchen sponge with a layer of scouring fleece on top."""
    wide, deep, high = np.array(SPONGE) * rng.uniform(0.8, 1.2, 3)
    fleece_high = rng.uniform(0.006, 0.009)
    foam, _ = rounded_box("part", (wide, deep, high), 0.003)
    fleece, _ = rounded_box("part", (wide - 0.0004, deep - 0.0004, fleece_high), 0.0015)
    foams = ((0.74, 0.55, 0.10), (0.72, 0.40, 0.40), (0.16, 0.36, 0.62), (0.70, 0.62, 0.30))
    fleeces = ((0.035, 0.16, 0.06), (0.02, 0.09, 0.06), (0.05, 0.07, 0.20))
    soft = surface(rng, "foam", "foam", [foams[rng.integers(4)]], (0.08, 0.08), (0.85, 1.0), size=(192, 192), wear=wear)
    rough = surface(
        rng,
        "scouring fleece",
        "fleece",
        [fleeces[rng.integers(3)]],
        (0.05, 0.05),
        (0.8, 1.0),
        size=(128, 128),
        wear=wear,
    )
    return Thing(
        (
            Part("sponge", moved(projected(foam), (0.0, 0.0, high / 2)), soft),
            Part("fleece", moved(projected(fleece), (0.0, 0.0, high + fleece_high / 2 + 0.0001)), rough),
        )
    )
