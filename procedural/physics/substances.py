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
#: By the names of `materials.draw`, and of what tables are made of.
SUBSTANCES: dict[str, Substance] = {
    "wood": Substance(700.0, 0.4, None, f"{_WOOD}; {_WOOD_FRICTION}"),
    "painted wood": Substance(700.0, 0.4, None, f"{_WOOD}; {_WOOD_FRICTION}"),
    "glazed ceramic": _CERAMIC,
    "matte plastic": _PLASTIC,
    "glossy plastic": _PLASTIC,
    "rubber": Substance(1150.0, 0.75, None, "natural rubber with filler, 1100 to 1200 kg/m^3; on steel 0.64-0.86 (ET)"),
    "brushed metal": Substance(7850.0, 0.4, 2e-3, "CRC Handbook; metal on wood 0.2 to 0.6 (ET)"),
    "stone": _STONE,
    "polished stone": Substance(2700.0, 0.4, None, "marble 2600 to 2800 kg/m^3; wood on stone 0.2 to 0.4 (ET)"),
    "terracotta": Substance(1900.0, 0.6, 6e-3, "common brick 1600 to 2000 kg/m^3; brick on wood 0.6 (ET)"),
    "cloth": Substance(300.0, 0.5, None, "estimate: stuffed cotton, which drapes over what it lies on"),
    "cardboard": Substance(690.0, 0.4, 4e-3, "cardboard 689 kg/m^3; friction an estimate between wood and cloth"),
    "printed paper": Substance(800.0, 0.4, None, "book paper 700 to 900 kg/m^3; friction an estimate, as cardboard"),
    "laminate": Substance(1400.0, 0.33, None, "high-pressure laminate, at least 1350 kg/m^3 (EN 438-4); as plastic"),
    "terrazzo": _STONE,
    "tiles": Substance(2300.0, 0.4, None, _CERAMIC.source),
    "concrete": Substance(2300.0, 0.6, None, "concrete 2300 kg/m^3; on wood 0.62 (ET)"),
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
