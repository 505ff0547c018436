"""Settings of the vessels: sizes, walls, filling, roughness, fineness of the meshes."""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import Field

from ...core.model import Model, Ordered
from ...core.units import LENGTH, Length

Category = Literal["tumbler", "beaker", "bowl", "bottle", "stem glass", "flask", "vase", "freeform"]
CATEGORIES: tuple[Category, ...] = get_args(Category)


_Height = Annotated[float, Field(ge=0.04, le=0.30), LENGTH]
_Radius = Annotated[float, Field(ge=0.015, le=0.08), LENGTH]
_Wall = Annotated[float, Field(ge=0.001, le=0.004), LENGTH]
_Base = Annotated[float, Field(ge=0.002, le=0.010), LENGTH]
_Fill = Annotated[float, Field(gt=0.0, le=1.0)]
_Alpha = Annotated[float, Field(ge=0.001, le=1.0)]


class VesselSettings(Model):
    """Vessels to draw. Ranges are (smallest, largest), both included."""

    categories: tuple[Category, ...] = Field(
        default=CATEGORIES,
        min_length=1,
        description="Families to draw from, equally likely; those that cannot have the given sizes are skipped",
    )
    height: Annotated[tuple[_Height, _Height], Ordered] = Field(
        default=(0.04, 0.30), description="Height of the vessel, within 0.04 and 0.30 [m]"
    )
    radius: Annotated[tuple[_Radius, _Radius], Ordered] = Field(
        default=(0.015, 0.08),
        description="Largest outer radius, within 0.015 and 0.08 [m]; rounding may take up to 5 % from it",
    )
    wall: Annotated[tuple[_Wall, _Wall], Ordered] = Field(
        default=(0.001, 0.004), description="Smallest thickness across the wall, within 0.001 and 0.004 [m]"
    )
    base: Annotated[tuple[_Base, _Base], Ordered] = Field(
        default=(0.002, 0.010), description="Thickness of the base, within 0.002 and 0.010; never below the wall's [m]"
    )
    fill_probability: float = Field(default=0.6, ge=0.0, le=1.0, description="Probability that a vessel holds a liquid")
    fill: Annotated[tuple[_Fill, _Fill], Ordered] = Field(
        default=(0.1, 0.9),
        description="Fraction of the brimful volume that is filled, within 0 and 1; the level stays below the rim",
    )
    rough_probability: float = Field(default=0.1, ge=0.0, le=1.0, description="Probability that the glass is rough")
    roughness: Annotated[tuple[_Alpha, _Alpha], Ordered] = Field(
        default=(0.02, 0.2), description="GGX alpha of rough glass, within 0.001 and 1"
    )
    chord_error: Length = Field(
        default=15e-6,
        ge=2e-6,
        le=200e-6,
        description="Largest distance of the mesh from the true surface, along rings and along the profile [m]; "
        "it sets the number of segments",
    )
