"""The kinds of tables, and the surfaces of their tops."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, get_args

import numpy as np

from ...core.model import Reflectance
from ..description.material import OpaqueMaterial
from ..materials.draw import METALS, dielectric, paint_colour, specimen
from ..patterns.draw import WOODS, surface

TableKind = Literal["wood", "stone", "tiles", "laminate", "chequer", "cloth", "bench", "shelf", "steel", "plain"]
TABLE_KINDS: tuple[TableKind, ...] = get_args(TableKind)
#: How often each kind is drawn by default: half of the tables are of wood or have a cloth.
DEFAULT_TABLES = (
    "wood=5",
    "stone=2",
    "tiles",
    "laminate=2",
    "chequer=0.4",
    "cloth=2.5",
    "bench",
    "shelf=1.5",
    "steel",
    "plain=1.5",
)
#: Longest side of what a picture of wood or marble shows [m]; a longer table repeats it.
MOST_SHOWN = 2.4
#: Texels along and across the grain of a board [px]: rings are across it.
WOOD_TEXELS, SQUARE_TEXELS, CLOTH_TEXELS = (384, 1024), (640, 640), (768, 768)
#: Stones of worktops, linear Rec.709, matched by eye to polished samples; the last colour is mica or the vein.
_GRANITES: tuple[tuple[Reflectance, ...], ...] = (
    ((0.42, 0.40, 0.38), (0.24, 0.23, 0.22), (0.55, 0.52, 0.49), (0.03, 0.03, 0.033)),
    ((0.06, 0.06, 0.063), (0.11, 0.11, 0.115), (0.03, 0.03, 0.032), (0.30, 0.30, 0.31)),
    ((0.42, 0.27, 0.21), (0.30, 0.20, 0.17), (0.52, 0.46, 0.42), (0.04, 0.04, 0.042)),
)
_MARBLES: tuple[tuple[Reflectance, ...], ...] = (
    ((0.78, 0.77, 0.75), (0.62, 0.62, 0.61), (0.17, 0.17, 0.19)),
    ((0.045, 0.045, 0.048), (0.085, 0.083, 0.08), (0.60, 0.57, 0.52)),
    ((0.62, 0.53, 0.41), (0.50, 0.42, 0.32), (0.27, 0.17, 0.10)),
)
_CONCRETES: tuple[tuple[Reflectance, ...], ...] = (
    ((0.22, 0.21, 0.20), (0.42, 0.40, 0.37)),
    ((0.10, 0.10, 0.1), (0.2, 0.2, 0.2)),
)
_TERRAZZO: tuple[Reflectance, ...] = ((0.62, 0.60, 0.56), (0.28, 0.14, 0.10), (0.10, 0.11, 0.11), (0.50, 0.44, 0.30))
_TILES: tuple[tuple[Reflectance, ...], ...] = (
    ((0.66, 0.62, 0.53), (0.60, 0.55, 0.47), (0.30, 0.29, 0.27)),
    ((0.72, 0.71, 0.69), (0.72, 0.71, 0.69), (0.42, 0.41, 0.40)),
    ((0.05, 0.12, 0.16), (0.07, 0.16, 0.20), (0.45, 0.44, 0.42)),
    ((0.36, 0.16, 0.085), (0.44, 0.20, 0.11), (0.33, 0.30, 0.27)),
)
_LAMINATES: tuple[tuple[Reflectance, ...], ...] = (
    ((0.62, 0.61, 0.59), (0.74, 0.73, 0.71)),
    ((0.30, 0.30, 0.30), (0.42, 0.42, 0.42)),
    ((0.05, 0.05, 0.053), (0.10, 0.10, 0.105)),
    ((0.50, 0.45, 0.36), (0.62, 0.57, 0.48)),
)
#: Black epoxy resin, grey and white ceramic of laboratory benches.
_BENCHES: tuple[Reflectance, ...] = ((0.018, 0.018, 0.02), (0.21, 0.22, 0.22), (0.58, 0.59, 0.58))
_LINENS: tuple[Reflectance, ...] = (
    (0.72, 0.70, 0.66),
    (0.62, 0.57, 0.47),
    (0.30, 0.06, 0.05),
    (0.07, 0.11, 0.20),
    (0.28, 0.31, 0.26),
)


def draw_top(rng: np.random.Generator, kind: TableKind, size: tuple[float, float], wear: float) -> OpaqueMaterial:
    """Draw the material of a top.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws.
    kind : str
        One of `TABLE_KINDS` but plain.
    size : (float, float)
        Length and width of the table [m].
    wear : float
        0 new, 1 worn.

    Returns
    -------
    OpaqueMaterial
        Repeats are per metre.
    """
    return _TOPS[kind](rng, (min(size[0] + 0.1, MOST_SHOWN), min(size[1] + 0.1, MOST_SHOWN)), wear)


def _wood(rng: np.random.Generator, shown: tuple[float, float], wear: float) -> OpaqueMaterial:
    kind = tuple(WOODS)[rng.integers(len(WOODS))]
    pattern = ("planks", "planks", "staves", "solid wood")[rng.integers(4)]
    colours = specimen(rng, WOODS[kind])
    return surface(rng, kind, pattern, colours, shown, (0.3, 0.6), size=WOOD_TEXELS, wear=wear)


def _stone(rng: np.random.Generator, shown: tuple[float, float], wear: float) -> OpaqueMaterial:
    kind = ("granite", "granite", "marble", "marble", "concrete", "terrazzo")[rng.integers(6)]
    sets = {"granite": _GRANITES, "marble": _MARBLES, "concrete": _CONCRETES, "terrazzo": (_TERRAZZO,)}[kind]
    colours = specimen(rng, sets[rng.integers(len(sets))])
    extent = shown if kind == "marble" else (0.5, 0.5) if kind in ("granite", "terrazzo") else (1.0, 1.0)
    roughness = (0.35, 0.7) if kind == "concrete" else (0.08, 0.25)
    return surface(rng, kind, kind, colours, extent, roughness, size=SQUARE_TEXELS, wear=0.6 * wear)


def _tiles(rng: np.random.Generator, shown: tuple[float, float], wear: float) -> OpaqueMaterial:
    del shown
    colours = specimen(rng, _TILES[rng.integers(len(_TILES))])
    return surface(rng, "glazed tiles", "tiles", colours, (0.6, 0.6), (0.08, 0.3), size=SQUARE_TEXELS, wear=wear)


def _laminate(rng: np.random.Generator, shown: tuple[float, float], wear: float) -> OpaqueMaterial:
    kind = rng.random()
    if kind < 0.35:  # printed with wood
        wood = tuple(WOODS)[rng.integers(len(WOODS))]
        colours = specimen(rng, WOODS[wood])
        return surface(rng, f"{wood} laminate", "solid wood", colours, shown, (0.3, 0.5), size=WOOD_TEXELS, wear=wear)
    if kind < 0.7:
        colours = specimen(rng, _LAMINATES[rng.integers(len(_LAMINATES))])
        return surface(rng, "laminate", "laminate", colours, (0.4, 0.4), (0.25, 0.5), size=(512, 512), wear=wear)
    colours = [paint_colour(rng)]
    return surface(rng, "lacquer", "lacquer", colours, (0.6, 0.6), (0.2, 0.5), size=(512, 512), wear=wear)


def _chequer(rng: np.random.Generator, shown: tuple[float, float], wear: float) -> OpaqueMaterial:
    del shown
    colours = [paint_colour(rng), paint_colour(rng)]
    return surface(rng, "oilcloth", "chequer", colours, (0.4, 0.4), (0.25, 0.5), size=(512, 512), wear=wear)


def _cloth(rng: np.random.Generator, shown: tuple[float, float], wear: float) -> OpaqueMaterial:
    del shown
    pattern = ("cloth", "checked cloth", "striped cloth")[rng.choice(3, p=(0.5, 0.3, 0.2))]
    ground = dielectric(
        np.array(_LINENS[rng.choice(len(_LINENS), p=(0.4, 0.25, 0.1, 0.15, 0.1))]) * rng.uniform(0.85, 1.1)
    )
    other = ground if pattern == "cloth" else paint_colour(rng)
    name = "linen" if rng.random() < 0.5 else "cotton"
    return surface(rng, name, pattern, [ground, other], (0.48, 0.48), (0.85, 1.0), size=CLOTH_TEXELS, wear=wear)


def _bench(rng: np.random.Generator, shown: tuple[float, float], wear: float) -> OpaqueMaterial:
    del shown
    kind = int(rng.integers(len(_BENCHES)))
    name = "epoxy resin" if kind == 0 else "technical ceramic"
    colours = specimen(rng, [_BENCHES[kind]])
    return surface(rng, name, "lacquer", colours, (0.6, 0.6), (0.2, 0.45), size=(512, 512), wear=wear)


def _steel(rng: np.random.Generator, shown: tuple[float, float], wear: float) -> OpaqueMaterial:
    del shown
    size = (512, 640)
    return surface(
        rng,
        "brushed steel",
        "brushed metal",
        [METALS["steel"]],
        (0.5, 0.4),
        (0.28, 0.42),
        metallic=1.0,
        size=size,
        wear=wear,
    )


_TOPS: dict[str, Callable[[np.random.Generator, tuple[float, float], float], OpaqueMaterial]] = {
    "wood": _wood,
    "stone": _stone,
    "tiles": _tiles,
    "laminate": _laminate,
    "chequer": _chequer,
    "cloth": _cloth,
    "bench": _bench,
    "shelf": _wood,
    "steel": _steel,
}
