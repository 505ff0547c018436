"""A medium that light crosses: its refractive index and its absorption."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ..model import Model


class Medium(Model):
    """A homogeneous medium.

    `eta` and `sigma_a` are what the RGB variants of the renderer use.
    """

    name: str = Field(description="Name in the catalogue")
    eta: float = Field(ge=1.0, description="Refractive index at the d line, 587.56 nm")
    sigma_a: tuple[Annotated[float, Field(ge=0.0)], ...] = Field(
        default=(0.0, 0.0, 0.0),
        min_length=3,
        max_length=3,
        description="Absorption coefficient for linear Rec.709 red, green, blue [1/m]",
    )


#: Air at 15 degC and 1013 hPa has index 1.00028 (Edlen 1966, doi:10.1088/0026-1394/2/2/002). Indices of solids and
#: liquids in the catalogue are relative to air, so air is 1.
AIR = Medium(name="air", eta=1.0)
