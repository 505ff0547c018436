"""Opaque materials and their textures, as data."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...core.assets import Asset
from ...core.model import Model, Reflectance


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


class PictureTexture(Model):
    """A picture from a file (sRGB)."""

    kind: Literal["picture"] = "picture"
    asset: Asset
    factor: Reflectance = Field(
        default=(1.0, 1.0, 1.0), exclude_if=lambda factor: factor == (1.0, 1.0, 1.0), description="On the reflectances"
    )


class VertexColours(Model):
    """The colours of the mesh's vertices, linear between them."""

    kind: Literal["vertices"] = "vertices"


Texture = Annotated[UniformTexture | ProceduralTexture | PictureTexture | VertexColours, Field(discriminator="kind")]


class OpaqueMaterial(Model):
    """An opaque surface: Disney's principled model (Burley 2012) without transmission."""

    name: str = Field(description="Name, such as 'oak' or 'glazed ceramic'")
    base_colour: Texture
    repeats: float = Field(default=1.0, gt=0.0, description="Repeats of the texture per unit of texture coordinate")
    roughness: float = Field(ge=0.0, le=1.0, description="Principled roughness; GGX alpha is its square")
    metallic: float = Field(default=0.0, ge=0.0, le=1.0, description="0 dielectric, 1 metal")
