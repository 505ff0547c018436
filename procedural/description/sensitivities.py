"""The spectral sensitivities of a colour camera's sensor, as data: how much red, green and blue see by wavelength."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from ...core.model import Model

_Curve = tuple[Annotated[float, Field(ge=0.0)], ...]
_Row = tuple[float, float, float]
_Positive = Annotated[float, Field(gt=0.0)]
#: Largest distance of the sum of a row of the colour matrix from 1 [1]: rounding of stored numbers.
_ROUNDING = 1e-9


class Sensitivities(Model):
    """What the filters and the silicon of a sensor make of each wavelength, and how its colours become Rec.709.

    A pixel's raw response of channel c is the integral of L s_c over the wavelength, over that of W s_c: L is the
    spectral radiance that arrives, s_c the curve, and W that of the standard illuminant D65 at the luminance of linear
    Rec.709 (1, 1, 1). So raw responses have the unit of the radiance of pictures, and D65 of luminance 1 has (1, 1, 1).
    """

    name: str = Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$", description="Name of the sensor")
    source: str = Field(default="", description="Where its figures come from")
    wavelengths: tuple[float, ...] = Field(min_length=2, description="Rising [nm]; linear between them, 0 beyond")
    red: _Curve = Field(description="Signal of red for each unit of energy, in any unit that all channels share")
    green: _Curve = Field(description="Of green, in the same unit")
    blue: _Curve = Field(description="Of blue, in the same unit")
    white: tuple[_Positive, _Positive, _Positive] = Field(
        description="Signals of light like D65, over that of green: what the channels saturate by"
    )
    matrix: tuple[_Row, _Row, _Row] = Field(
        description="From raw responses in light like D65 to linear Rec.709; rows sum to 1"
    )

    @model_validator(mode="after")
    def _is_a_sensor(self) -> Sensitivities:
        if np.any(np.diff(self.wavelengths) <= 0.0):
            raise ValueError("wavelengths: expected rising ones, found others")
        for name in ("red", "green", "blue"):
            curve = getattr(self, name)
            if len(curve) != len(self.wavelengths):
                raise ValueError(f"{name}: expected a value for each wavelength, found {len(curve)}")
            if not any(curve):
                raise ValueError(f"{name}: expected some light to be seen, found none")
        if np.abs(np.array(self.matrix).sum(axis=1) - 1.0).max() > _ROUNDING:
            raise ValueError("matrix: expected rows that sum to 1, found others")
        return self

    @property
    def curves(self) -> np.ndarray:
        """The three curves, (n, 3) float64."""
        return np.array([self.red, self.green, self.blue]).T

    def at(self, nm: np.ndarray) -> np.ndarray:
        """Return the curves at wavelengths [nm], (n,) to (n, 3): linear between samples, 0 beyond them."""
        return np.stack([np.interp(nm, self.wavelengths, one, left=0.0, right=0.0) for one in self.curves.T], axis=-1)
