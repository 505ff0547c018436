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


Texture = Annotated[UniformTexture | ProceduralTexture | PictureTexture, Field(discriminator="kind")]


class OpaqueMaterial(Model):
    """An opaque surface: Disney's principled model (Burley 2012) without transmission."""

    name: str = Field(description="Name, such as 'oak' or 'glazed ceramic'")
    base_colour: Texture
    repeats: float = Field(default=1.0, gt=0.0, description="Repeats of the texture per unit of texture coordinate")
    repeats_v: float | None = Field(
        default=None, gt=0.0, exclude_if=lambda v: v is None, description="Repeats along v where they differ"
    )
    roughness: float = Field(ge=0.0, le=1.0, description="Principled roughness; GGX alpha is its square")
    metallic: float = Field(default=0.0, ge=0.0, le=1.0, description="0 dielectric, 1 metal")
