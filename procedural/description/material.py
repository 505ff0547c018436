"""Opaque materials and their textures, as data."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...core.assets import Asset
from ...core.model import Model, Reflectance

#: Most texels along a side of a surface: four maps of them have 28 MB.
MOST_TEXELS = 1024
PositiveFloat = Annotated[float, Field(gt=0.0, le=100.0)]
Texels = Annotated[int, Field(ge=4, le=MOST_TEXELS)]


def _is_none(value: object) -> bool:
    return value is None


class UniformTexture(Model):
    """One colour everywhere."""

    kind: Literal["uniform"] = "uniform"
    colour: Reflectance = Field(description="Linear Rec.709 reflectance")


class ProceduralTexture(Model):
    """A tileable pattern that `materials.textures.bake` makes from these numbers."""

    kind: Literal["wood", "marble", "checker", "stripes", "noise", "tiles", "terrazzo", "fabric"]
    colours: tuple[Reflectance, ...] = Field(min_length=2, max_length=4, description="Linear Rec.709 reflectances")
    seed: int = Field(ge=0, description="Seed of the pattern")
    resolution: int = Field(default=512, ge=16, le=4096, description="Side of the square picture [px]")


#: The patterns that `patterns.bake` makes, and those of them that are laid out for a body's proportions.
SurfacePattern = Literal[
    "planks",
    "staves",
    "solid wood",
    "granite",
    "marble",
    "concrete",
    "terrazzo",
    "tiles",
    "cloth",
    "checked cloth",
    "striped cloth",
    "brushed metal",
    "polished metal",
    "laminate",
    "lacquer",
    "glaze",
    "banded glaze",
    "paper",
    "page edges",
    "foam",
    "fleece",
    "chequer",
    "carton",
    "label",
    "cover",
    "screen",
    "citrus skin",
    "apple skin",
    "banana skin",
    "printed sheet",
    "newspaper",
    "card",
    "marker",
    "marker board",
    "cutting mat",
    "place mat",
    "ribbed rubber",
    "sticker",
    "tape",
    "stain",
]
LAID_OUT = ("carton", "cover", "marker")


class SurfaceTexture(Model):
    """A surface at a scale in metres, with colour, roughness and relief, that `patterns.bake` makes of these numbers.

    Texture coordinates are in metres, and a material repeats it `1 / extent` times per metre.
    """

    kind: Literal["surface"] = "surface"
    pattern: SurfacePattern
    colours: tuple[Reflectance, ...] = Field(min_length=1, max_length=6, description="Linear Rec.709 reflectances")
    seed: int = Field(ge=0, description="Seed of the pattern")
    extent: tuple[PositiveFloat, PositiveFloat] = Field(description="Width and height of what one repeat shows [m]")
    size: tuple[Texels, Texels] = Field(description="Width and height of the picture [px]")
    wear: float = Field(default=0.0, ge=0.0, le=1.0, description="Traces of use: 0 new, 1 worn")
    layout: tuple[Annotated[float, Field(gt=0.0, lt=10.0)], ...] = Field(
        default=(),
        max_length=1,
        exclude_if=lambda layout: not layout,
        description="What a print is laid out for: a carton's depth over its height, a book's spine over its cover, "
        "a marker's cells across",
    )
    relief: bool = Field(default=True, description="Whether roughness and normals differ from place to place, too")

    @model_validator(mode="after")
    def _laid_out(self) -> SurfaceTexture:
        if (self.pattern in LAID_OUT) != bool(self.layout):
            expected = "one number" if self.pattern in LAID_OUT else "none"
            raise ValueError(f"layout: expected {expected} for the pattern {self.pattern}, found {len(self.layout)}")
        return self


class PictureTexture(Model):
    """A picture from a file (sRGB)."""

    kind: Literal["picture"] = "picture"
    asset: Asset
    factor: Reflectance = Field(
        default=(1.0, 1.0, 1.0), exclude_if=lambda factor: factor == (1.0, 1.0, 1.0), description="On the reflectances"
    )


class ChannelMap(Model):
    """One number for each place, from a channel of a picture as it is stored (no sRGB curve), 0 to 1."""

    asset: Asset
    channel: Literal["grey", "red", "green", "blue"] = Field(
        default="grey", description="The channel; grey is the only one, or the first of a picture in colour"
    )
    inverted: bool = Field(default=False, description="Whether the picture holds one minus the number (glossiness)")


class NormalMap(Model):
    """Shading normals in the frame of the texture coordinates: 2 (red, green, blue) - 1 is (along u, along v, out)."""

    asset: Asset
    convention: Literal["opengl", "directx"] = Field(
        default="opengl", description="opengl: green points up in the picture; directx: down"
    )
    strength: float = Field(default=1.0, ge=0.0, le=4.0, description="Factor on the slopes")


class BumpMap(Model):
    """Heights (displacement) that tilt the shading normal; the surface itself stays where it is."""

    asset: Asset
    depth: float = Field(
        ge=0.0, le=1.0, description="Height from black to white, over the side of one repeat of the texture"
    )


class VertexColours(Model):
    """The colours of the mesh's vertices, linear between them."""

    kind: Literal["vertices"] = "vertices"


Texture = Annotated[
    UniformTexture | ProceduralTexture | SurfaceTexture | PictureTexture | VertexColours, Field(discriminator="kind")
]


class Emission(Model):
    """Light that a surface sends out from its front side, the same in all directions."""

    colour: Annotated[UniformTexture | PictureTexture, Field(discriminator="kind")]
    radiance: float = Field(gt=0.0, le=1e6, description="Of the colour 1 [kcd/m^2]")


class NearInfrared(Model):
    """How a surface reflects just beyond the visible range, from its colours (`materials.near_infrared`).

    Some of the absorption of what it looks like is left there: nothing of a dye's, all of carbon black's.
    """

    neutral: float = Field(
        ge=0.0, le=1.0, description="Part of the absorption that is left where the colour is grey or black"
    )
    chromatic: float = Field(ge=0.0, le=1.0, description="Part of it that is left where the colour is saturated")
    bare: float = Field(gt=0.0, le=1.0, description="Reflectance of what is under all colour")
    factor: float = Field(
        default=1.0,
        gt=0.0,
        le=2.0,
        exclude_if=lambda factor: factor == 1.0,
        description="Reflectance over that in the visible range, of metals",
    )


class OpaqueMaterial(Model):
    """An opaque surface: Disney's principled model (Burley 2012) without transmission."""

    name: str = Field(description="Name, such as 'oak' or 'glazed ceramic'")
    base_colour: Texture
    repeats: float = Field(default=1.0, gt=0.0, description="Repeats of the texture per unit of texture coordinate")
    repeats_v: float | None = Field(
        default=None, gt=0.0, exclude_if=lambda v: v is None, description="Repeats along v where they differ"
    )
    roughness: float = Field(
        ge=0.0, le=1.0, description="Principled roughness; GGX alpha is its square. With a map, a factor on it"
    )
    metallic: float = Field(
        default=0.0, ge=0.0, le=1.0, description="0 dielectric, 1 metal. With a map, a factor on it"
    )
    # Left out of files where there is none: descriptions without maps stay what they were.
    roughness_map: ChannelMap | None = Field(default=None, exclude_if=_is_none)
    metallic_map: ChannelMap | None = Field(default=None, exclude_if=_is_none)
    normal_map: NormalMap | None = Field(default=None, exclude_if=_is_none, description="Goes before a bump map")
    bump_map: BumpMap | None = Field(default=None, exclude_if=_is_none)
    emission: Emission | None = Field(default=None, exclude_if=_is_none, description="What shines by itself")
    near_infrared: NearInfrared | None = Field(
        default=None,
        exclude_if=_is_none,
        description="Reflectance in the light of a depth camera; none: the middle of what is usual for its name",
    )

    @property
    def is_mapped(self) -> bool:
        """Whether anything but the colour differs from place to place."""
        relief = isinstance(self.base_colour, SurfaceTexture) and self.base_colour.relief
        return relief or any((self.roughness_map, self.metallic_map, self.normal_map, self.bump_map))
