"""Dispersion formulas: refractive index against wavelength, with their sources and valid ranges."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from ...core.errors import InputError
from ...core.model import Model

#: Fraunhofer lines: helium d, hydrogen F and C, sodium D (mean of the doublet) [nm]. ISO 7944:1998, table 1 for d, F
#: and C; the sodium doublet is at 588.995 and 589.592 nm.
D_LINE, F_LINE, C_LINE, SODIUM_LINE = 587.5618, 486.1327, 656.2725, 589.29

#: Refractive index of air relative to vacuum, 20 degC and 1013 hPa, d line (Ciddor 1996, doi:10.1364/AO.35.001566). It
#: changes by 6e-6 over the visible, which is below the uncertainty of every formula here.
AIR_TO_VACUUM = 1.000272

Range = tuple[float, float]


class Sellmeier(Model):
    """``n^2 = 1 + sum_i B_i x^2 / (x^2 - C_i)`` with x the wavelength in micrometres (Sellmeier 1871)."""

    kind: Literal["sellmeier"] = "sellmeier"
    B: tuple[float, ...] = Field(description="Strengths [1]")
    C: tuple[float, ...] = Field(description="Squared resonance wavelengths [um^2]")
    absolute: bool = Field(default=False, description="Whether the formula is relative to vacuum instead of air")
    valid: Range = Field(description="Valid wavelengths [nm]")
    source: str


class Cauchy(Model):
    """``n = A + B / x^2 + C / x^4 + D x^2`` with x the wavelength in micrometres (Cauchy 1836, one infrared term)."""

    kind: Literal["cauchy"] = "cauchy"
    A: float
    B: float = Field(description="[um^2]")
    C: float = Field(default=0.0, description="[um^4]")
    D: float = Field(default=0.0, description="[um^-2]")
    valid: Range = Field(description="Valid wavelengths [nm]")
    source: str


class Power(Model):
    """``n^2 = sum_i a_i x^(e_i)`` with x the wavelength in micrometres (Schott 1966: e = 0, 2, -2, -4 ...)."""

    kind: Literal["power"] = "power"
    coefficients: tuple[float, ...] = Field(description="a_i [um^-e_i]")
    exponents: tuple[int, ...] = Field(description="e_i [1]")
    valid: Range = Field(description="Valid wavelengths [nm]")
    source: str


class Scaled(Model):
    """``n = 1 + factor (n_base - 1)``: a solution with the relative dispersion of its solvent (Gladstone and Dale)."""

    kind: Literal["scaled"] = "scaled"
    base: Sellmeier
    factor: float = Field(gt=0.0, description="Ratio of n - 1 of solution and solvent [1]")
    source: str

    @property
    def valid(self) -> Range:
        """Valid wavelengths of the solvent's formula [nm]."""
        return self.base.valid


Dispersion = Annotated[Sellmeier | Cauchy | Power | Scaled, Field(discriminator="kind")]


def index(formula: Dispersion, wavelength_nm: ArrayLike) -> np.ndarray:
    """Return the refractive index of a formula, without a look at its valid range.

    Parameters
    ----------
    formula : Sellmeier, Cauchy, Power or Scaled
        The formula.
    wavelength_nm : float or array of any shape
        Wavelength in air [nm].

    Returns
    -------
    ndarray, shape of `wavelength_nm`
        Index relative to air.
    """
    if isinstance(formula, Scaled):
        return 1.0 + formula.factor * (index(formula.base, wavelength_nm) - 1.0)
    x2 = (np.asarray(wavelength_nm, dtype=np.float64) * 1e-3) ** 2
    if isinstance(formula, Cauchy):
        return formula.A + formula.B / x2 + formula.C / x2**2 + formula.D * x2
    if isinstance(formula, Power):
        powers = [a * x2 ** (e / 2.0) for a, e in zip(formula.coefficients, formula.exponents, strict=True)]
        return np.sqrt(np.sum(powers, axis=0))
    terms = [b * x2 / (x2 - c) for b, c in zip(formula.B, formula.C, strict=True)]
    return np.sqrt(1.0 + np.sum(terms, axis=0)) / (AIR_TO_VACUUM if formula.absolute else 1.0)


def abbe_number(formula: Dispersion) -> float:
    """Return ``V_d = (n_d - 1) / (n_F - n_C)`` (ISO 7944:1998)."""
    n_d, n_f, n_c = index(formula, [D_LINE, F_LINE, C_LINE])
    return float((n_d - 1.0) / (n_f - n_c))


def in_range(wavelength: np.ndarray, low: float, high: float, where: str, outside: str) -> np.ndarray:
    """Return the wavelengths, held to ``[low, high]`` [nm] or refused with `where` in the message."""
    if outside == "hold":
        return np.clip(wavelength, low, high)
    wrong = ~((wavelength >= low) & (wavelength <= high))  # written so that NaN is wrong too
    if wrong.any():
        raise InputError(where, f"a wavelength in {low:g}-{high:g} nm", f"{wavelength[wrong].flat[0]:g} nm")
    return wavelength
