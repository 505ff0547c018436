"""Absorption spectra: sampled curves and sums of bands, and the absorption of a medium made from them."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from ...core.errors import InputError
from ...core.model import Model
from . import absorption_tables as tables
from .dispersion import in_range
from .dyes import DYES, PIGMENTS, Dye
from .medium import Absorber, Medium


class Sampled(Model):
    """A measured absorption spectrum, linear between its samples."""

    wavelengths: tuple[float, ...] = Field(min_length=2, description="Increasing [nm]")
    values: tuple[float, ...] = Field(description="Absorption coefficient [1/m]")
    source: str

    @model_validator(mode="after")
    def _is_a_curve(self) -> Sampled:
        if len(self.values) != len(self.wavelengths) or np.any(np.diff(self.wavelengths) <= 0.0):
            raise ValueError(f"spectrum of {self.source}: expected increasing wavelengths, one value each")
        if min(self.values) < 0.0:
            raise ValueError(f"spectrum of {self.source}: expected no negative absorption, found {min(self.values)}")
        return self

    @property
    def valid(self) -> tuple[float, float]:
        """First and last wavelength [nm]."""
        return self.wavelengths[0], self.wavelengths[-1]


def from_extinction(k: ArrayLike, unit: float, wavelengths: ArrayLike, source: str) -> Sampled:
    """Return ``4 pi k / wavelength`` (Born and Wolf 1999, eq. 14.1(16)) of an extinction coefficient in `unit`.

    Parameters
    ----------
    k : (n,) float
        Imaginary part of the index, in multiples of `unit`.
    unit : float
        Such as 1e-8.
    wavelengths : (n,) float
        In vacuum; the air's index is left out [nm].
    source : str
        Where `k` was published.
    """
    nm = np.asarray(wavelengths, dtype=np.float64)
    values = 4.0 * np.pi * np.asarray(k, dtype=np.float64) * unit / (nm * 1e-9)
    return Sampled(wavelengths=tuple(nm.tolist()), values=tuple(values.tolist()), source=source)


def _even(start: float, step: float, count: int) -> np.ndarray:
    return start + step * np.arange(count)


def _soda_lime(k: tuple[float, ...], kind: str) -> Sampled:
    nm = _even(tables.SODA_LIME_START, tables.SODA_LIME_STEP, len(k))
    return from_extinction(k, 1e-8, nm, f"Rubin 1985, {kind} soda-lime, doi:10.1016/0165-1633(85)90052-8")


def _plastic(k: tuple[float, ...], kind: str) -> Sampled:
    nm = _even(tables.PLASTIC_START, tables.PLASTIC_STEP, len(k))
    return from_extinction(k, 1e-7, nm, f"Zhang et al. 2020, {kind}, doi:10.1364/AO.383831")


def _lead(k: tuple[float, ...], kind: str) -> Sampled:
    return from_extinction(k, 1e-9, tables.LEAD_WAVELENGTHS, f"Schott data sheet {kind}, 2017-01-20")


#: All spectra by name. `Absorber.amount` multiplies them: a fraction of the substance for `Sampled`, a concentration
#: [kg/m^3, that is g/L] for `Dye`.
SPECTRA: dict[str, Sampled | Dye] = {
    "water": Sampled(
        wavelengths=tuple(_even(tables.WATER_START, tables.WATER_STEP, len(tables.WATER)).tolist()),
        values=tables.WATER,
        source="Pope and Fry 1997, table 3, doi:10.1364/AO.36.008710",
    ),
    "soda-lime, low-iron": _soda_lime(tables.SODA_LIME_LOW_IRON, "low-iron"),
    "soda-lime, clear": _soda_lime(tables.SODA_LIME_CLEAR, "clear"),
    "soda-lime, green": _soda_lime(tables.SODA_LIME_GREEN, "green"),
    "soda-lime, bronze": _soda_lime(tables.SODA_LIME_BRONZE, "bronze"),
    "soda-lime, grey": _soda_lime(tables.SODA_LIME_GREY, "grey"),
    "lead glass LLF1": _lead(tables.LEAD_LLF1, "LLF1"),
    "lead glass LF5": _lead(tables.LEAD_LF5, "LF5"),
    "polycarbonate": _plastic(tables.POLYCARBONATE, "polycarbonate"),
    "PET": _plastic(tables.PET, "PET"),
    **DYES,
    **PIGMENTS,
}


def coefficient(spectrum: Sampled | Dye, wavelength_nm: ArrayLike) -> np.ndarray:
    """Return a spectrum's absorption for amount 1 [1/m]; outside its range the nearest valid value."""
    nm = np.clip(np.asarray(wavelength_nm, dtype=np.float64), *spectrum.valid)
    if isinstance(spectrum, Sampled):
        return np.interp(nm, spectrum.wavelengths, spectrum.values)
    return spectrum.strength(nm)


def _spectrum(absorber: Absorber) -> Sampled | Dye:
    if absorber.samples:
        wavelengths, values = zip(*absorber.samples, strict=True)
        return Sampled(wavelengths=wavelengths, values=values, source=absorber.spectrum)
    if absorber.spectrum not in SPECTRA:
        raise InputError("absorber", f"one of {', '.join(SPECTRA)}", absorber.spectrum)
    return SPECTRA[absorber.spectrum]


def mixture(absorbers: tuple[Absorber, ...], wavelength_nm: ArrayLike) -> np.ndarray:
    """Return the summed absorption of some absorbers [1/m]; outside a spectrum's range the nearest valid value."""
    nm = np.asarray(wavelength_nm, dtype=np.float64)
    parts = [a.amount * coefficient(_spectrum(a), nm) for a in absorbers]
    return np.sum(parts, axis=0) if parts else np.zeros(nm.shape)


def absorption(medium: Medium, wavelength_nm: ArrayLike, outside: Literal["refuse", "hold"] = "refuse") -> np.ndarray:
    """Return the absorption coefficient of a medium by wavelength.

    Parameters
    ----------
    medium : Medium
        Its `absorbers` are used, not `sigma_a`.
    wavelength_nm : float or array of any shape
        Wavelength [nm].
    outside : {"refuse", "hold"}
        As in `medium.eta`.

    Returns
    -------
    ndarray, shape of `wavelength_nm`
        [1/m]; 0 for a medium without absorbers.

    Raises
    ------
    InputError
        A wavelength is outside the range of one of the medium's spectra and `outside` is ``"refuse"``.
    """
    nm = np.asarray(wavelength_nm, dtype=np.float64)
    for absorber in medium.absorbers:
        low, high = _spectrum(absorber).valid
        in_range(nm, low, high, f"absorption of {medium.name} ({absorber.spectrum})", outside)
    return mixture(medium.absorbers, nm)
