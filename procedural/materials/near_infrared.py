"""Reflectances in the near infrared, where the projectors and lasers of depth cameras shine (850 and 860 nm).

Colours say nothing about them by themselves: a black T-shirt is white there and a black keyboard black. What a thing is
made of does. Its colours are taken as a layer of colourants that scatters as much there as in the visible range, by
Kubelka and Munk (Z. tech. Physik 12, 593, 1931): the ratio of absorption to scattering of a deep layer of the
reflectance R is

    K/S = (1 - R)^2 / (2 R),    R = 1 + K/S - sqrt((K/S)^2 + 2 K/S)

and ratios of what is mixed add up. The brightest of the three channels tells how much all of them absorb; a part of
that is left in the near infrared, and the bare material absorbs on its own. Which part is left depends on whether the
colour is neutral (black, grey and shades) or saturated: black pigments are others than coloured ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..description.material import NearInfrared, OpaqueMaterial, PictureTexture, UniformTexture, VertexColours
from .draw import METALS
from .surface_maps import mean_metallic

Bounds = tuple[float, float]

#: Index and extinction of metals at 850 nm, linear between the published wavelengths: iron, Johnson and Christy 1974,
#: doi:10.1103/PhysRevB.9.5056 (`METALS` takes it for steel; stainless steel has 2.57 + 4.02i, a seventh brighter:
#: Karlsson and Ribbing 1982, doi:10.1063/1.331503); aluminium, McPeak et al. 2015, doi:10.1021/ph5004237; copper,
#: Johnson and Christy 1972, doi:10.1103/PhysRevB.6.4370; brass of 70 % copper, Querry 1985, CRDC-CR-85034.
METALS_AT_850 = {
    "steel": 2.948 + 3.459j,
    "aluminium": 2.205 + 7.188j,
    "copper": 0.276 + 5.420j,
    "brass": 0.490 + 5.269j,
}
#: Sum of the differences of the channels above which a metal is none of `METALS`, and keeps its brightest channel [1].
_NO_METAL = 0.4


@dataclass(frozen=True)
class Kind:
    """Materials of one kind, with ranges of the fields of `NearInfrared`, from which they are drawn.

    Parameters
    ----------
    neutral, chromatic, bare : (float, float)
        Ranges.
    carbon : float
        Probability that what is grey or black is so by carbon black, whose absorption is all left.
    source : str
        Where the numbers come from.
    """

    neutral: Bounds
    chromatic: Bounds
    bare: Bounds
    carbon: float
    source: str


# "LBA": Levinson, Berdahl and Akbari, "Solar spectral optical properties of pigments, part II", Sol. Energy Mater. Sol.
# Cells 89, 351 (2005), doi:10.1016/j.solmat.2004.11.013: K and S of common pigments, 300 to 2500 nm. Carbon black
# absorbs evenly to beyond 2000 nm; organic red, yellow and blue pigments hardly beyond 750 nm; iron oxides, chromium
# oxide and cobalt compounds less than in the visible range, but still. "Estimate": of this order, not measured here.
_PRINT = Kind(
    (1.0, 1.0),
    (0.0, 0.05),
    (0.80, 0.90),
    1.0,
    "process black is carbon black, and stands for the grey part of colours; organic pigments of cyan, magenta and "
    "yellow let the near infrared through (LBA); paper 0.8 to 0.9 (estimate)",
)
_TEXTILE = Kind(
    (0.0, 0.04),
    (0.0, 0.05),
    (0.65, 0.85),
    0.15,
    "dyes of cotton and polyester end before 800 nm, black ones too; carbon black in a print lowers the near infrared "
    "much (as camouflage cloth is made); how often it is there, and 0.65 to 0.85 of cotton: estimates",
)
_PLASTIC = Kind(
    (0.0, 0.05),
    (0.0, 0.15),
    (0.60, 0.90),
    0.8,
    "black plastic is coloured by carbon black as a rule, which is why sorting plants do not see it (Turner 2018, "
    "Environ. Int. 117, 308); other colourants are organic (LBA); how often, and 0.6 to 0.9 bare: estimates",
)
_PAINT = Kind(
    (0.3, 0.9),
    (0.0, 0.3),
    (0.70, 0.90),
    0.7,
    "tinting blacks are carbon black and iron oxide black, colours organic or of iron and chromium oxides (LBA); how "
    "often, an estimate; bare: titanium dioxide in a binder",
)
_GLAZE = Kind(
    (0.5, 1.0),
    (0.05, 0.4),
    (0.75, 0.90),
    0.0,
    "black spinels of copper, chromium, iron and cobalt absorb on; cobalt blue, chrome green and iron brown less (LBA)",
)
_WOOD = Kind(
    (0.2, 0.4),
    (0.2, 0.4),
    (0.70, 0.85),
    0.0,
    "absorption of lignin and extractives falls steadily from blue to the infrared; a third of that in the red is "
    "left, so that oak has 0.6 and walnut 0.4 (estimate)",
)
_STONE = Kind((0.8, 1.0), (0.7, 1.0), (0.85, 0.95), 0.0, "minerals with iron in them are flat from red to 900 nm")
_CLAY = Kind(
    (0.7, 1.0),
    (0.6, 1.0),
    (0.80, 0.90),
    0.0,
    "hematite, which makes clay red, has a band of its own at 850 to 900 nm (Cornell and Schwertmann, The Iron Oxides)",
)
_FRUIT = Kind(
    (0.0, 0.2),
    (0.0, 0.05),
    (0.55, 0.70),
    0.0,
    "chlorophyll, carotenoids and anthocyanins absorb nothing beyond 750 nm, and water little (Saeys et al. 2008, "
    "Appl. Opt. 47, 908); 0.55 to 0.7 of flesh and peel is an estimate",
)
_DRINK = Kind(
    (0.1, 0.4),
    (0.1, 0.4),
    (0.80, 0.90),
    0.0,
    "fat scatters on, and browned sugar and coffee absorb ever less towards the infrared (estimate)",
)
_RUBBER = Kind((0.3, 0.9), (0.0, 0.2), (0.60, 0.80), 0.95, "carbon black is the filler of black rubber")
_BLACK = Kind((1.0, 1.0), (1.0, 1.0), (0.90, 0.90), 1.0, "carbon absorbs as in the visible range")
_STATED = Kind(
    (1.0, 1.0), (1.0, 1.0), (1.0, 1.0), 1.0, "a reflectance that is given by hand is that of its brightest channel"
)

_WOODS = ("wood", "oak", "walnut", "beech", "pine", "ash", "cherry", "maple", "cedar")
_LAMINATES = tuple(f"{wood} laminate" for wood in _WOODS[1:])
#: By the names of `materials.draw`, of things and their parts, of tables, rooms and turbid drinks.
KINDS: dict[str, Kind] = {
    **dict.fromkeys(
        (
            *("printed paper", "printed card", "printed carton", "printed cloth-bound board", "printed aluminium"),
            *("paper", "lining paper", "paper label", "newspaper", "laminate", *_LAMINATES),
        ),
        _PRINT,
    ),
    **dict.fromkeys(
        ("cloth", "cotton", "linen", "table cloth", "checked cloth", "foam", "scouring fleece", "fabric"), _TEXTILE
    ),
    **dict.fromkeys(
        ("matte plastic", "glossy plastic", "plastic", "PVC", "oilcloth", "epoxy resin", "cutting mat"), _PLASTIC
    ),
    **dict.fromkeys(("painted wood", "lacquer", "room"), _PAINT),
    **dict.fromkeys(
        (
            *("glazed ceramic", "technical ceramic", "tiles", "glazed tiles", "enamelled cast iron"),
            *("white enamel", "brown enamel", "black enamel"),
        ),
        _GLAZE,
    ),
    **dict.fromkeys((*_WOODS, "cork", "straw", "cardboard"), _WOOD),
    **dict.fromkeys(("stone", "granite", "polished stone", "marble", "terrazzo", "concrete"), _STONE),
    "terracotta": _CLAY,
    **dict.fromkeys(("apple skin", "citrus skin", "banana skin"), _FRUIT),
    **dict.fromkeys(("milk", "skimmed milk", "chocolate milk", "espresso", "grapefruit juice"), _DRINK),
    "rubber": _RUBBER,
    **dict.fromkeys(("graphite", "cover glass"), _BLACK),
    "matte": _STATED,
}
#: Of names that say nothing, such as those of files: as paint.
UNKNOWN = _PAINT
#: Words in the names of files, and whose kind they mean; the first one counts.
_WORDS = (
    *(("paper", "paper"), ("book", "paper"), ("cardboard", "cardboard"), ("carton", "printed carton")),
    *(("fabric", "cloth"), ("cloth", "cloth"), ("cotton", "cloth"), ("leather", "cloth"), ("carpet", "cloth")),
    *(("plastic", "plastic"), ("rubber", "rubber"), ("paint", "painted wood"), ("plaster", "painted wood")),
    *((wood, wood) for wood in _WOODS),
    *(("plank", "wood"), ("tile", "tiles"), ("ceramic", "glazed ceramic"), ("porcelain", "glazed ceramic")),
    *(("brick", "terracotta"), ("clay", "terracotta"), ("marble", "marble"), ("granite", "granite")),
    *(("stone", "stone"), ("rock", "stone"), ("concrete", "concrete")),
)


def absorption_over_scattering(reflectance: np.ndarray) -> np.ndarray:
    """Return K/S of deep layers of some reflectances, above 0 and up to 1 [1] (Kubelka and Munk 1931)."""
    return (1.0 - reflectance) ** 2 / (2.0 * reflectance)


def deep_reflectance(ratio: np.ndarray) -> np.ndarray:
    """Return the reflectance of deep layers of some K/S [1] (Kubelka and Munk 1931)."""
    return 1.0 + ratio - np.sqrt(ratio * ratio + 2.0 * ratio)


def infrared_reflectance(colours: np.ndarray, law: NearInfrared) -> np.ndarray:
    """Return reflectances in the near infrared.

    Parameters
    ----------
    colours : (..., 3) float
        Linear Rec.709 reflectances, from 0 to 1.
    law : NearInfrared
        Of the material.

    Returns
    -------
    (...) float64
        From 0 to 1.
    """
    channels = np.clip(np.asarray(colours, np.float64), 1e-4, 1.0)
    brightest, darkest = channels.max(axis=-1), channels.min(axis=-1)
    saturation = 1.0 - darkest / brightest
    left = law.neutral + (law.chromatic - law.neutral) * saturation
    ratio = absorption_over_scattering(np.array(law.bare)) + left * absorption_over_scattering(brightest)
    return np.minimum(law.factor * deep_reflectance(ratio), 1.0)


def kind_of(name: str) -> Kind:
    """Return the kind of an opaque dielectric by its name, or by a word in it; `UNKNOWN` where that says nothing."""
    if name in KINDS:
        return KINDS[name]
    plain = name.lower()
    return next((KINDS[kind] for word, kind in _WORDS if word in plain), UNKNOWN)


def near_infrared(
    material: OpaqueMaterial, rng: np.random.Generator | None = None, carbon: float | None = None
) -> NearInfrared:
    """Return how a material reflects in the near infrared, by its name and whether it is of metal.

    Parameters
    ----------
    material : OpaqueMaterial
        The material; what it states itself counts.
    rng : numpy.random.Generator, optional
        Source of the draw; without it, the middle of each range, and the more probable black.
    carbon : float, optional
        Probability that what is grey or black is so by carbon black, in place of its kind's.
    """
    if material.near_infrared is not None:
        return material.near_infrared
    if mean_metallic(material) >= 0.5:
        return NearInfrared(neutral=1.0, chromatic=1.0, bare=1.0, factor=_metal_factor(material))
    kind = kind_of(material.name)
    black, *places = (0.5,) * 4 if rng is None else rng.random(4).tolist()
    neutral, chromatic, bare = (
        low + at * (high - low)
        for (low, high), at in zip((kind.neutral, kind.chromatic, kind.bare), places, strict=True)
    )
    is_carbon = black < (kind.carbon if carbon is None else carbon)
    return NearInfrared(neutral=1.0 if is_carbon else neutral, chromatic=chromatic, bare=bare)


def normal_reflectance(index: complex) -> float:
    """Return the reflectance of a metal at normal incidence (Born and Wolf 1999, eq. 14.2(14))."""
    return abs((index - 1.0) / (index + 1.0)) ** 2


def _metal_factor(material: OpaqueMaterial) -> float:
    """Return the reflectance of a metal at 850 nm over its brightest channel: of the metal whose colour is nearest."""
    texture = material.base_colour
    if isinstance(texture, PictureTexture | VertexColours):
        return 1.0
    colour = np.array(texture.colour if isinstance(texture, UniformTexture) else texture.colours[0])
    differences = {name: float(np.abs(colour - known).sum()) for name, known in METALS.items()}
    metal = min(differences, key=differences.__getitem__)
    if differences[metal] > _NO_METAL:
        return 1.0
    return normal_reflectance(METALS_AT_850[metal]) / max(METALS[metal])
