"""What the walls of each family of vessels are made of, and how often."""

from __future__ import annotations

import numpy as np

from ..optics.draw import draw_glass
from ..optics.medium import Medium
from .settings import Category

#: Share of each material in a family [1]. Which materials a family has follows from products and standards (reasons
#: beside the rows); the shares are estimates. What is not in a row is never drawn. A freeform vessel is no product: it
#: has every material, so that the whole range of indices (1.46-1.58) and tints is seen.
WALL_MATERIALS: dict[Category, dict[str, float]] = {
    # Drinking glasses: soda-lime; cut crystal (24 and 30 % PbO, Directive 69/493/EEC); borosilicate for hot drinks;
    # reusable cups of polycarbonate and acrylic, single-use cups of PET.
    "tumbler": {
        "soda-lime glass": 0.66,
        "lead crystal": 0.08,
        "heavy lead crystal": 0.04,
        "borosilicate glass 3.3": 0.06,
        "green soda-lime glass": 0.02,
        "bronze soda-lime glass": 0.02,
        "grey soda-lime glass": 0.02,
        "acrylic": 0.04,
        "polycarbonate": 0.04,
        "PET": 0.02,
    },
    # ISO 3819: beakers of borosilicate 3.3 (ISO 3585); cheap ones of soda-lime, those for high temperatures of silica.
    "beaker": {"borosilicate glass 3.3": 0.84, "soda-lime glass": 0.08, "fused silica": 0.08},
    # Table bowls as tumblers; borosilicate is ovenware. Thermoformed PET has other shapes, with thin walls and ribs.
    "bowl": {
        "soda-lime glass": 0.66,
        "borosilicate glass 3.3": 0.12,
        "lead crystal": 0.08,
        "heavy lead crystal": 0.02,
        "green soda-lime glass": 0.02,
        "bronze soda-lime glass": 0.02,
        "grey soda-lime glass": 0.02,
        "acrylic": 0.04,
        "polycarbonate": 0.02,
    },
    # Container glass is soda-lime: clear, green, brown (bronze is the nearest here). Drinks come in PET as well;
    # reusable bottles are of borosilicate (laboratory bottles, ISO 4796) or polycarbonate.
    "bottle": {
        "soda-lime glass": 0.62,
        "green soda-lime glass": 0.16,
        "bronze soda-lime glass": 0.06,
        "PET": 0.12,
        "borosilicate glass 3.3": 0.02,
        "polycarbonate": 0.02,
    },
    # Wine glasses: soda-lime or crystal; green ones (roemers); unbreakable ones of acrylic and polycarbonate.
    "stem glass": {
        "soda-lime glass": 0.62,
        "lead crystal": 0.22,
        "heavy lead crystal": 0.08,
        "green soda-lime glass": 0.02,
        "acrylic": 0.03,
        "polycarbonate": 0.03,
    },
    # Boiling and conical flasks (ISO 1773) are of borosilicate 3.3, some of soda-lime or silica; shake flasks also of
    # polycarbonate.
    "flask": {
        "borosilicate glass 3.3": 0.80,
        "soda-lime glass": 0.06,
        "fused silica": 0.06,
        "polycarbonate": 0.08,
    },
    # Pressed and blown vases, cut crystal ones, tinted ones, lamp-blown ones of borosilicate, and acrylic.
    "vase": {
        "soda-lime glass": 0.60,
        "lead crystal": 0.14,
        "heavy lead crystal": 0.06,
        "green soda-lime glass": 0.05,
        "bronze soda-lime glass": 0.03,
        "grey soda-lime glass": 0.04,
        "acrylic": 0.04,
        "borosilicate glass 3.3": 0.04,
    },
    # Pressed and mould-blown tumblers: soda-lime, tinted ones more often than plain tumblers; cut crystal has flutes.
    "faceted glass": {
        "soda-lime glass": 0.74,
        "lead crystal": 0.08,
        "heavy lead crystal": 0.04,
        "green soda-lime glass": 0.04,
        "bronze soda-lime glass": 0.03,
        "grey soda-lime glass": 0.03,
        "polycarbonate": 0.04,
    },
    "fluted glass": {
        "soda-lime glass": 0.60,
        "lead crystal": 0.18,
        "heavy lead crystal": 0.10,
        "green soda-lime glass": 0.04,
        "bronze soda-lime glass": 0.02,
        "grey soda-lime glass": 0.02,
        "acrylic": 0.04,
    },
    "ribbed glass": {
        "soda-lime glass": 0.74,
        "borosilicate glass 3.3": 0.08,
        "green soda-lime glass": 0.06,
        "bronze soda-lime glass": 0.06,
        "grey soda-lime glass": 0.06,
    },
    "square glass": {
        "soda-lime glass": 0.72,
        "lead crystal": 0.12,
        "heavy lead crystal": 0.06,
        "grey soda-lime glass": 0.04,
        "acrylic": 0.06,
    },
    # Mugs and jugs: pressed soda-lime; cups for hot drinks also of borosilicate; reusable ones of polycarbonate.
    "mug": {
        "soda-lime glass": 0.80,
        "borosilicate glass 3.3": 0.12,
        "green soda-lime glass": 0.03,
        "bronze soda-lime glass": 0.02,
        "polycarbonate": 0.03,
    },
    "cup": {
        "soda-lime glass": 0.56,
        "borosilicate glass 3.3": 0.34,
        "bronze soda-lime glass": 0.06,
        "green soda-lime glass": 0.04,
    },
    "jug": {
        "soda-lime glass": 0.70,
        "borosilicate glass 3.3": 0.18,
        "green soda-lime glass": 0.04,
        "acrylic": 0.04,
        "polycarbonate": 0.04,
    },
    # Teapots and double-walled glasses are blown of borosilicate 3.3.
    "teapot": {"borosilicate glass 3.3": 1.0},
    "double-walled glass": {"borosilicate glass 3.3": 1.0},
    "cocktail glass": {
        "soda-lime glass": 0.68,
        "lead crystal": 0.18,
        "heavy lead crystal": 0.06,
        "acrylic": 0.04,
        "polycarbonate": 0.04,
    },
    # As beakers and flasks (ISO 3819, ISO 1773, ISO 1042: borosilicate 3.3 or soda-lime); test tubes (ISO 4142) also of
    # soda-lime, single-use ones; vials of tubing (ISO 8362-1: type I glass, also brown; bronze is the nearest here).
    "spouted beaker": {"borosilicate glass 3.3": 0.90, "soda-lime glass": 0.06, "fused silica": 0.04},
    "test tube": {"borosilicate glass 3.3": 0.70, "soda-lime glass": 0.24, "polycarbonate": 0.06},
    "vial": {"borosilicate glass 3.3": 0.78, "soda-lime glass": 0.08, "bronze soda-lime glass": 0.14},
    "volumetric flask": {"borosilicate glass 3.3": 0.94, "soda-lime glass": 0.06},
    "round flask": {"borosilicate glass 3.3": 0.94, "fused silica": 0.06},
    # Container glass; plastic bottles and cups of PET, reusable ones of polycarbonate.
    "square bottle": {"soda-lime glass": 0.70, "green soda-lime glass": 0.22, "bronze soda-lime glass": 0.08},
    "oval bottle": {"soda-lime glass": 0.80, "green soda-lime glass": 0.10, "bronze soda-lime glass": 0.10},
    "jar": {"soda-lime glass": 0.92, "green soda-lime glass": 0.04, "bronze soda-lime glass": 0.04},
    "plastic bottle": {"PET": 1.0},
    "plastic cup": {"PET": 0.80, "polycarbonate": 0.12, "acrylic": 0.08},
    "freeform": {
        "soda-lime glass": 0.45,
        "borosilicate glass 3.3": 0.20,
        "lead crystal": 0.10,
        "heavy lead crystal": 0.04,
        "fused silica": 0.03,
        "acrylic": 0.04,
        "polycarbonate": 0.03,
        "PET": 0.03,
        "green soda-lime glass": 0.04,
        "bronze soda-lime glass": 0.02,
        "grey soda-lime glass": 0.02,
    },
}


def draw_wall_material(rng: np.random.Generator, category: Category) -> Medium:
    """Return the medium of a vessel's wall, by its family's row of `WALL_MATERIALS`.

    It takes as many random numbers for every family, so that those that follow are the same for all.
    """
    return draw_glass(rng, WALL_MATERIALS[category])
