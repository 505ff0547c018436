"""Materials of props and tables, drawn at random.

Reflectances of dielectrics stay between sRGB 30 and 240, and metals have measured colours at normal incidence, as
W. McDermott, "The PBR Guide" (Adobe, 2018) and Lagarde & de Rousiers, "Moving Frostbite to PBR" (SIGGRAPH 2014
course notes) advise from measurements. Roughness is Burley's perceptual one ("Physically-based shading at Disney",
SIGGRAPH 2012): about 0.05-0.2 for glaze and polish, 0.3-0.6 for lacquer, plastic and brushed metal, 0.7-1 for raw
stone, paper and cloth.
"""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...core.assets import asset
from ...core.model import Reflectance
from ..description.material import (
    BumpMap,
    ChannelMap,
    NormalMap,
    OpaqueMaterial,
    PictureTexture,
    ProceduralTexture,
    Texture,
    UniformTexture,
)
from .picture_files import read_picture, srgb_to_linear
from .surface_files import MapFile, SurfaceFiles

#: Darkest and brightest reflectance of a dielectric, linear: sRGB 30 and 240 (McDermott 2018).
DIELECTRIC_RANGE = (0.013, 0.871)
#: Reflectance of metals at normal incidence, linear Rec.709 (Akenine-Moeller et al., "Real-Time Rendering", 4th
#: edition, 2018, table 9.2). Steel takes iron's.
METALS: dict[str, Reflectance] = {
    "steel": (0.562, 0.565, 0.578),
    "aluminium": (0.913, 0.922, 0.924),
    "copper": (0.955, 0.638, 0.538),
    "brass": (0.910, 0.778, 0.423),
}
#: Probability that a prop has a picture from the user's folder [1]: pictures are common, most props stay procedural.
PICTURE_PROBABILITY = 0.25
#: Range of the roughness of a picture's material [1], lacquered to raw; pictures do not state it.
PICTURE_ROUGHNESS = (0.3, 0.7)
#: Height from black to white in a displacement map [m]; files do not state it. Relief of wood, brick and plaster is
#: some millimetres.
BUMP_DEPTH = 0.005
#: Standard deviation of a specimen's reflectance, relative: of all channels together, and of each channel beside that.
#: Two batches of the same wood or stone differ by about this much (judged by eye).
BATCH_SPREAD, CHANNEL_SPREAD = 0.15, 0.04
#: Range of the reflectance of one coat of paint where it is brightest over where it is darkest [1]: just visible.
UNEVEN_COAT = (1.08, 1.25)
#: Paint colours, HSV of sRGB [1]. The most saturated pigments reach 0.85; the exponent puts half of the draws below a
#: saturation of 0.3, because most household paints and plastics are muted; black and white paint are 0.25 and 0.95.
MAX_SATURATION, SATURATION_EXPONENT, PAINT_VALUE = 0.85, 1.5, (0.25, 0.95)
#: Families of one colour, for meshes with texture charts that no pattern fits.
PLAIN_FAMILIES = ("painted wood", "matte plastic", "glazed ceramic")
#: Seeds of procedural textures are below this: they fit a signed 32-bit integer.
SEED_END = 2**31


Kind = Literal["uniform", "wood", "marble", "checker", "stripes", "noise", "tiles", "terrazzo", "fabric"]


@dataclass(frozen=True)
class Family:
    """Materials of one kind.

    Parameters
    ----------
    name : str
        The imitated material.
    textures : tuple of str
        Kinds of texture, equally probable; "uniform" is one colour.
    palettes : tuple
        Sets of colours, equally probable, linear Rec.709; if empty, paint colours are drawn.
    roughness : (float, float)
        Range of the principled roughness.
    tile : (float, float)
        Range of the side of one texture tile [m].
    metallic : float
        0 dielectric, 1 metal.
    """

    name: str
    textures: tuple[Kind, ...]
    palettes: tuple[tuple[Reflectance, ...], ...]
    roughness: tuple[float, float]
    tile: tuple[float, float] = (0.2, 0.4)
    metallic: float = 0.0


# Palettes: tones of common specimens, matched by eye and inside DIELECTRIC_RANGE; woods run from light to dark.
_OAK = ((0.45, 0.29, 0.15), (0.17, 0.085, 0.036))
_WALNUT = ((0.17, 0.088, 0.045), (0.045, 0.022, 0.013))
_BEECH = ((0.60, 0.40, 0.24), (0.33, 0.19, 0.10))
_WHITE_MARBLE = ((0.80, 0.79, 0.77), (0.58, 0.58, 0.57), (0.14, 0.14, 0.16))
_GREEN_MARBLE = ((0.035, 0.075, 0.055), (0.07, 0.13, 0.10), (0.45, 0.50, 0.44))
_GRANITE = ((0.05, 0.05, 0.055), (0.22, 0.21, 0.20), (0.42, 0.40, 0.38))
_CONCRETE = ((0.22, 0.21, 0.20), (0.42, 0.40, 0.37))
_SANDSTONE = ((0.30, 0.21, 0.13), (0.52, 0.41, 0.28))
_TERRAZZO = ((0.68, 0.66, 0.62), (0.28, 0.14, 0.10), (0.10, 0.11, 0.11), (0.50, 0.44, 0.30))
_CARDBOARD = ((0.32, 0.20, 0.11), (0.40, 0.27, 0.16))
_TERRACOTTA = ((0.40, 0.15, 0.075), (0.52, 0.23, 0.13))
_LINEN = ((0.62, 0.58, 0.49), (0.74, 0.71, 0.64))
_DENIM = ((0.045, 0.075, 0.16), (0.45, 0.47, 0.50))
_CREAM_TILES = ((0.66, 0.62, 0.53), (0.60, 0.55, 0.47), (0.28, 0.27, 0.25))
_SLATE_TILES = ((0.075, 0.08, 0.085), (0.12, 0.12, 0.125), (0.26, 0.25, 0.24))
_WOODS, _STONES = (_OAK, _WALNUT, _BEECH), (_GRANITE, _SANDSTONE, _CONCRETE)

PROP_FAMILIES = (
    Family("painted wood", ("uniform", "noise"), (), (0.3, 0.6)),
    Family("wood", ("wood",), _WOODS, (0.3, 0.65), (0.15, 0.3)),
    Family("glazed ceramic", ("uniform", "noise", "stripes"), (), (0.05, 0.2), (0.1, 0.25)),
    Family("matte plastic", ("uniform",), (), (0.4, 0.7)),
    Family("glossy plastic", ("uniform", "stripes", "checker"), (), (0.12, 0.35), (0.1, 0.3)),
    Family("rubber", ("uniform",), (((0.02, 0.02, 0.02), (0.06, 0.06, 0.06)),), (0.7, 0.95)),
    Family(
        "brushed metal", ("uniform",), tuple((colour, colour) for colour in METALS.values()), (0.25, 0.5), metallic=1.0
    ),
    Family("stone", ("noise", "terrazzo"), _STONES, (0.6, 0.95), (0.15, 0.4)),
    Family("polished stone", ("marble",), (_WHITE_MARBLE, _GREEN_MARBLE), (0.08, 0.3), (0.15, 0.35)),
    Family("terracotta", ("noise",), (_TERRACOTTA,), (0.75, 0.95)),
    Family("cloth", ("fabric",), (), (0.85, 1.0), (0.06, 0.12)),
    Family("cardboard", ("noise",), (_CARDBOARD,), (0.75, 0.95)),
    Family("printed paper", ("checker", "stripes"), (), (0.45, 0.8), (0.1, 0.3)),
)
TABLE_FAMILIES = (
    Family("wood", ("wood",), _WOODS, (0.25, 0.6), (0.6, 1.1)),
    Family("painted wood", ("noise",), (), (0.3, 0.6), (0.5, 1.0)),
    Family("laminate", ("noise",), (_WHITE_MARBLE[:2], _CONCRETE), (0.2, 0.45), (0.4, 0.8)),
    Family("polished stone", ("marble",), (_WHITE_MARBLE, _GREEN_MARBLE), (0.08, 0.3), (0.7, 1.2)),
    Family("terrazzo", ("terrazzo",), (_TERRAZZO,), (0.15, 0.4), (0.4, 0.8)),
    Family("tiles", ("tiles",), (_CREAM_TILES, _SLATE_TILES), (0.1, 0.4), (0.5, 0.9)),
    Family("concrete", ("noise",), (_CONCRETE,), (0.6, 0.9), (0.6, 1.2)),
    Family("table cloth", ("fabric",), (_LINEN, _DENIM), (0.85, 1.0), (0.10, 0.18)),
    Family("checked cloth", ("checker",), (), (0.8, 1.0), (0.2, 0.5)),
)


def draw_material(rng: np.random.Generator, texture_files: Sequence[SurfaceFiles] = ()) -> OpaqueMaterial:
    """Draw the material of a prop.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws.
    texture_files : sequence of SurfaceFiles
        Pictures with their maps, used with `PICTURE_PROBABILITY`; may be empty.

    Returns
    -------
    OpaqueMaterial
        Its `repeats` are per metre; they have to be scaled for texture coordinates in another unit.
    """
    picture = rng.random() < PICTURE_PROBABILITY
    if texture_files and picture:
        return _picture_material(rng, texture_files)
    return _family_material(rng, PROP_FAMILIES[rng.integers(len(PROP_FAMILIES))])


def draw_table_material(
    rng: np.random.Generator, texture_files: Sequence[SurfaceFiles] = (), side: float | None = None
) -> OpaqueMaterial:
    """Draw the material of a table, with a picture if there are any; `repeats` are per metre.

    Where the width of one repeat of the picture is given [m], its height has the picture's shape, and no other draw
    changes.
    """
    if texture_files:
        drawn = _picture_material(rng, texture_files, side)
        return drawn if side is None else _of_width(drawn, side)
    return _family_material(rng, TABLE_FAMILIES[rng.integers(len(TABLE_FAMILIES))])


def draw_plain_material(rng: np.random.Generator) -> OpaqueMaterial:
    """Draw a material of one colour: painted, plastic or glazed."""
    plain = [item for item in PROP_FAMILIES if item.name in PLAIN_FAMILIES]
    family = plain[int(rng.integers(len(plain)))]
    colour = UniformTexture(colour=paint_colour(rng))
    return OpaqueMaterial(name=family.name, base_colour=colour, roughness=rng.uniform(*family.roughness))


def whole_repeats(material: OpaqueMaterial, unit: float) -> OpaqueMaterial:
    """Return a material with its repeats per metre rounded to a whole number per texture unit of `unit` metres."""
    return material.model_copy(update={"repeats": float(max(1, round(material.repeats * unit)))})


def _picture_material(
    rng: np.random.Generator, files: Sequence[SurfaceFiles], side: float | None = None
) -> OpaqueMaterial:
    item = files[int(rng.integers(len(files)))]
    drawn, roughness = rng.uniform(*item.drawn_side), rng.uniform(*PICTURE_ROUGHNESS)
    width = side or item.side or drawn
    material = OpaqueMaterial(
        name=f"material {item.base}" if item.maps else f"picture {item.colour.stem}",
        base_colour=PictureTexture(asset=asset(item.colour)),
        repeats=1.0 / width,
        roughness=roughness,
    )
    return material.model_copy(update=_maps(item, width)) if item.maps else material


def _maps(item: SurfaceFiles, side: float) -> dict[str, object]:
    """Return the fields of a material that has maps; those that files have are not drawn."""
    fields: dict[str, object] = {}
    if item.roughness is not None:
        fields |= {"roughness": 1.0, "roughness_map": _channel(item.roughness)}
    if item.metalness is not None:
        fields |= {"metallic": 1.0, "metallic_map": _channel(item.metalness)}
    if item.normal is not None:
        fields["normal_map"] = NormalMap(asset=asset(item.normal.path), convention=item.normal.convention)
    if item.height is not None:
        fields["bump_map"] = BumpMap(asset=asset(item.height.path), depth=min(1.0, BUMP_DEPTH / side))
    return fields


def _channel(file: MapFile) -> ChannelMap:
    return ChannelMap(asset=asset(file.path), channel=file.channel, inverted=file.inverted)


def _of_width(material: OpaqueMaterial, width: float) -> OpaqueMaterial:
    """Return a picture's material whose repeats are that wide [m] and have the picture's shape."""
    assert isinstance(material.base_colour, PictureTexture)
    rows, columns = read_picture(material.base_colour.asset.path).shape[:2]
    other = None if rows == columns else columns / (rows * width)
    return material.model_copy(update={"repeats": 1.0 / width, "repeats_v": other})


def _family_material(rng: np.random.Generator, family: Family) -> OpaqueMaterial:
    kind = family.textures[rng.integers(len(family.textures))]
    return OpaqueMaterial(
        name=family.name,
        base_colour=_texture(rng, family, kind),
        repeats=1.0 / rng.uniform(*family.tile),
        roughness=rng.uniform(*family.roughness),
        metallic=family.metallic,
    )


def _texture(rng: np.random.Generator, family: Family, kind: Kind) -> Texture:
    if family.palettes:
        palette = family.palettes[rng.integers(len(family.palettes))]
        colours = palette if family.metallic else specimen(rng, palette)
    else:
        colours = _paints(rng, kind)
    if kind == "uniform":
        return UniformTexture(colour=colours[0])
    return ProceduralTexture(kind=kind, colours=colours, seed=int(rng.integers(SEED_END)))


def specimen(rng: np.random.Generator, palette: Sequence[Reflectance]) -> tuple[Reflectance, ...]:
    """Return a palette with the variation between specimens: all its colours are scaled by the same factors."""
    factor = np.exp(rng.normal(0.0, BATCH_SPREAD) + rng.normal(0.0, CHANNEL_SPREAD, 3))
    return tuple(dielectric(np.array(colour) * factor) for colour in palette)


def _paints(rng: np.random.Generator, kind: Kind) -> tuple[Reflectance, ...]:
    """Return the colours of a painted, dyed or printed surface."""
    first = paint_colour(rng)
    if kind == "noise":
        return first, dielectric(np.array(first) * rng.uniform(*UNEVEN_COAT))
    return first, paint_colour(rng), *((paint_colour(rng),) if kind == "fabric" else ())


def paint_colour(rng: np.random.Generator) -> Reflectance:
    """Return the colour of a pigment: any hue, more often muted than saturated, from dark to light."""
    saturation, value = MAX_SATURATION * rng.random() ** SATURATION_EXPONENT, rng.uniform(*PAINT_VALUE)
    return dielectric(srgb_to_linear(np.array(colorsys.hsv_to_rgb(rng.random(), saturation, value))))


def dielectric(colour: np.ndarray) -> Reflectance:
    """Return a colour within what dielectrics reflect, `DIELECTRIC_RANGE`."""
    red, green, blue = np.clip(colour, *DIELECTRIC_RANGE)
    return float(red), float(green), float(blue)
