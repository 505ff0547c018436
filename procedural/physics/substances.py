"""Densities and coefficients of friction of what scenes are made of, by the names of materials.

Friction is dry and static, on the hard surfaces that tables and props have. Tables of friction differ by a factor of
two for the same pair; the middle of the quoted range is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..description.material import OpaqueMaterial, UniformTexture
from ..materials.draw import METALS
from ..optics.medium import Medium

#: Densities of a glass and a liquid that state none [kg/m^3]: soda-lime (EN 572-1) and water.
GLASS_DENSITY, LIQUID_DENSITY = 2500.0, 998.0
#: Densities of the metals of `materials.draw.METALS` [kg/m^3]: CRC Handbook of Chemistry and Physics; steel carbon
#: steel, brass 70 % copper.
METAL_DENSITIES = {"steel": 7850.0, "aluminium": 2700.0, "copper": 8960.0, "brass": 8530.0}


@dataclass(frozen=True)
class Substance:
    """What a material is to mechanics.

    Parameters
    ----------
    density : float
        [kg/m^3].
    friction : float
        Coefficient of static friction [1].
    wall : float or None
        Wall of closed shapes of it, which are hollow [m]; None where they are solid.
    source : str
        Where the numbers come from.
    """

    density: float
    friction: float
    wall: float | None
    source: str


# "ET": Engineering ToolBox, "Friction Coefficients" (2004), clean and dry unless said otherwise. Walls: injection
# moulding has 1.5-4 mm (Rosato, "Injection Molding Handbook", 3rd edition, 2000), slip-cast ware 3-6 mm.
_WOOD = "density of oak, walnut and beech at 12 % moisture, 620 to 760 (USDA Wood Handbook 2010, table 5-3a)"
_WOOD_FRICTION = "wood on wood 0.25 to 0.5 (ET)"
_CERAMIC = Substance(2300.0, 0.4, 5e-3, "stoneware 2200 to 2400 kg/m^3; friction of glass, as its glaze is one")
_PLASTIC = Substance(1050.0, 0.33, 2.5e-3, "polystyrene and ABS, 1040 to 1060 kg/m^3; on steel 0.3 to 0.35 (ET)")
_STONE = Substance(2650.0, 0.4, None, "granite 2600 to 2700 kg/m^3; wood on stone 0.2 to 0.4 (ET)")
#: Metals of drawn things, whose meshes are their walls; friction as that of brushed metal.
_STEEL = Substance(7850.0, 0.4, None, "carbon steel (CRC Handbook); metal on wood 0.2 to 0.6 (ET)")
_ALUMINIUM = Substance(2700.0, 0.4, None, "aluminium (CRC Handbook); metal on wood 0.2 to 0.6 (ET)")
_IRON = Substance(7200.0, 0.4, None, "grey cast iron 7050 to 7300 kg/m^3; metal on wood 0.2 to 0.6 (ET)")
_MARBLE = Substance(2700.0, 0.4, None, "marble 2600 to 2800 kg/m^3; wood on stone 0.2 to 0.4 (ET)")
_PAPER = Substance(800.0, 0.4, None, "book paper 700 to 900 kg/m^3; friction an estimate, as cardboard")
_CARTON = Substance(700.0, 0.4, 5e-4, "folding carton 600 to 800 kg/m^3, 0.3 to 0.6 mm; friction as cardboard")
_CLOTH = Substance(300.0, 0.5, None, "estimate: stuffed cotton, which drapes over what it lies on")
_LAMINATE = Substance(1400.0, 0.33, None, "high-pressure laminate, at least 1350 kg/m^3 (EN 438-4); as plastic")
_ENAMEL = Substance(2500.0, 0.4, None, "glass frit 2400 to 2600 kg/m^3; friction of glass")
_CITRUS = Substance(950.0, 0.5, None, "estimate: oranges and lemons just float; friction an estimate")
#: Densities of woods at 12 % moisture [kg/m^3]: 1.12 times the specific gravity of USDA Wood Handbook 2010, table
#: 5-3a (white oak 0.68, black walnut 0.55, American beech 0.64, ponderosa pine 0.40, white ash 0.60, black cherry 0.50,
#: sugar maple 0.63, incense cedar 0.37).
WOOD_DENSITIES = {
    "oak": 760.0,
    "walnut": 620.0,
    "beech": 720.0,
    "pine": 450.0,
    "ash": 670.0,
    "cherry": 560.0,
    "maple": 705.0,
    "cedar": 415.0,
}
#: By the names of `materials.draw`, of things and their parts, and of what tables are made of.
SUBSTANCES: dict[str, Substance] = {
    "wood": Substance(700.0, 0.4, None, f"{_WOOD}; {_WOOD_FRICTION}"),
    "painted wood": Substance(700.0, 0.4, None, f"{_WOOD}; {_WOOD_FRICTION}"),
    **{
        name: Substance(density, 0.4, None, f"{name} at 12 % moisture (USDA Wood Handbook 2010); {_WOOD_FRICTION}")
        for name, density in WOOD_DENSITIES.items()
    },
    **{f"{name} laminate": _LAMINATE for name in WOOD_DENSITIES},
    "glazed ceramic": _CERAMIC,
    "matte plastic": _PLASTIC,
    "glossy plastic": _PLASTIC,
    "plastic": _PLASTIC,
    "lacquer": _PLASTIC,
    "PVC": Substance(1400.0, 0.4, None, "PVC 1300 to 1450 kg/m^3, around copper; on steel 0.4 to 0.5 (ET)"),
    "oilcloth": Substance(1300.0, 0.4, None, "soft PVC 1200 to 1400 kg/m^3 on cotton; friction as PVC"),
    "foam": Substance(30.0, 0.6, None, "polyurethane foam of sponges 20 to 40 kg/m^3; friction an estimate"),
    "scouring fleece": Substance(100.0, 0.6, None, "estimate: polyester fleece with grit; friction as foam"),
    "rubber": Substance(1150.0, 0.75, None, "natural rubber with filler, 1100 to 1200 kg/m^3; on steel 0.64-0.86 (ET)"),
    "brushed metal": Substance(7850.0, 0.4, 2e-3, "CRC Handbook; metal on wood 0.2 to 0.6 (ET)"),
    "metal": Substance(7850.0, 0.4, 2e-4, "tinplate of closures 0.15 to 0.25 mm (EN 10202); as brushed metal"),
    **dict.fromkeys(("brushed steel", "polished steel", "burnished steel", "tinplate"), _STEEL),
    **dict.fromkeys(
        ("aluminium", "brushed aluminium", "polished aluminium", "printed aluminium", "cast aluminium"), _ALUMINIUM
    ),
    "enamelled cast iron": _IRON,
    "stone": _STONE,
    "granite": _STONE,
    "polished stone": _MARBLE,
    "marble": _MARBLE,
    "terracotta": Substance(1900.0, 0.6, 6e-3, "common brick 1600 to 2000 kg/m^3; brick on wood 0.6 (ET)"),
    "cloth": _CLOTH,
    "cotton": _CLOTH,
    "linen": _CLOTH,
    "cardboard": Substance(690.0, 0.4, 4e-3, "cardboard 689 kg/m^3; friction an estimate between wood and cloth"),
    "printed carton": _CARTON,
    "printed card": _PAPER,
    "printed cloth-bound board": _PAPER,
    "printed paper": _PAPER,
    "paper": _PAPER,
    "lining paper": _PAPER,
    "paper label": _PAPER,
    "cork": Substance(200.0, 0.5, None, "cork 120 to 240 kg/m^3; friction an estimate between wood and rubber"),
    "graphite": Substance(1800.0, 0.2, None, "pencil leads of graphite and clay, estimate; on steel 0.1 to 0.2 (ET)"),
    "cover glass": Substance(2450.0, 0.4, None, "aluminosilicate cover glass 2400 to 2480 kg/m^3; friction of glass"),
    **dict.fromkeys(("white enamel", "brown enamel", "black enamel"), _ENAMEL),
    "apple skin": Substance(
        840.0, 0.4, None, "apples are a fifth air, 790 to 900 kg/m^3; friction an estimate, as wood"
    ),
    "citrus skin": _CITRUS,
    "banana skin": Substance(950.0, 0.5, None, "estimate: bananas just float; friction as citrus fruit"),
    "laminate": _LAMINATE,
    "terrazzo": _STONE,
    "tiles": Substance(2300.0, 0.4, None, _CERAMIC.source),
    "glazed tiles": Substance(2300.0, 0.4, None, _CERAMIC.source),
    "concrete": Substance(2300.0, 0.6, None, "concrete 2300 kg/m^3; on wood 0.62 (ET)"),
    "epoxy resin": Substance(
        1900.0, 0.4, None, "filled epoxy of laboratory tops 1800 to 2000 kg/m^3; as plastic on wood"
    ),
    "technical ceramic": Substance(2400.0, 0.4, None, "stoneware of laboratory tops 2300 to 2500 kg/m^3; as its glaze"),
    "table cloth": Substance(300.0, 0.5, None, "estimate, as cloth"),
    "checked cloth": Substance(300.0, 0.5, None, "estimate, as cloth"),
}
#: Of materials of files, whose names say nothing: most things of that size are of plastic.
UNKNOWN = Substance(1050.0, 0.4, 2.5e-3, "not known: as plastic, friction as wood")
#: Density of the whole thing by category, whatever its surface is of [kg/m^3]: tins are sold full and hold about a
#: kilogram a litre; books are paper throughout.
WHOLE_DENSITIES = {
    "plain can": (1000.0, "a full tin, about 1 kg a litre"),
    "can": (1000.0, "a full tin, about 1 kg a litre"),
    "plain book": (800.0, "paper, 700 to 900 kg/m^3"),
    "book": (800.0, "paper, 700 to 900 kg/m^3"),
    "carton": (350.0, "estimate: a full carton of tea or pasta"),
    "phone": (2000.0, "phones of 171 g in 147.6 x 71.6 x 7.8 mm, and the like"),
}
#: Glass on glass is 0.9-1.0 where it is clean and 0.1-0.6 where it is greasy (ET); hands make it greasy.
GLASS_FRICTION = 0.4
#: Lever arm of rolling friction [m]: wood on steel 1.2 mm, plastic on steel 2 mm, hard wood on hard wood 0.5 mm, steel
#: on steel 0.05-0.5 mm in tables of mechanical engineering.
ROLLING_ARM = 5e-4
#: Lever arm of friction against turning on the spot [m]: two thirds of a contact's radius; contacts of things on a
#: table are some millimetres wide.
TURNING_ARM = 2e-3


def substance_of(material: OpaqueMaterial) -> Substance:
    """Return what an opaque material is to mechanics; of an unknown name `UNKNOWN`."""
    known = SUBSTANCES.get(material.name, UNKNOWN)
    if material.name != "brushed metal" or not isinstance(material.base_colour, UniformTexture):
        return known
    colour = np.array(material.base_colour.colour)
    metal = min(METALS, key=lambda name: float(np.abs(colour - METALS[name]).sum()))
    return Substance(METAL_DENSITIES[metal], known.friction, known.wall, f"{metal}: {known.source}")


def glass_substance(glass: Medium) -> Substance:
    """Return what the glass or plastic of a transparent body is to mechanics."""
    stated = f"{glass.name}: density {'of its catalogue' if glass.density else 'not known, as soda-lime'}"
    return Substance(glass.density or GLASS_DENSITY, GLASS_FRICTION, None, f"{stated}; greasy glass 0.1 to 0.6 (ET)")
