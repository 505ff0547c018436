"""A medium that light crosses: its refractive index and its absorption."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from ...core.errors import InputError
from ...core.model import Model
from .dispersion import D_LINE, Dispersion, in_range, index

#: `Medium.eta` is stored rounded to this many digits, so it may differ from its formula by half of the last one.
ETA_DIGITS = 6


class Absorber(Model):
    """One part of a medium's absorption: a spectrum of `spectra.SPECTRA`, or one of its own, times a factor."""

    spectrum: str = Field(description="Name of the spectrum in `spectra.SPECTRA`; a label where it has samples")
    amount: float = Field(ge=0.0, description="Fraction of a substance [1], or concentration of a dye [kg/m^3]")
    #: Left out of files where there are none, as those of earlier versions do.
    samples: tuple[tuple[float, Annotated[float, Field(ge=0.0)]], ...] = Field(
        default=(),
        exclude_if=lambda samples: not samples,
        description="A spectrum of its own: rising wavelength [nm] and absorption coefficient [1/m]",
    )


class Medium(Model):
    """A homogeneous medium.

    The RGB variants of the renderer use the fields `eta` and `sigma_a`; the functions `eta` and `spectra.absorption`
    are their spectral counterparts. Numbers that are not known are None.
    """

    name: str = Field(description="Name in the catalogue")
    eta: float = Field(ge=1.0, description="Refractive index at the d line, 587.56 nm")
    sigma_a: tuple[Annotated[float, Field(ge=0.0)], ...] = Field(
        default=(0.0, 0.0, 0.0),
        min_length=3,
        max_length=3,
        description="Absorption coefficient for linear Rec.709 red, green, blue [1/m]",
    )
    dispersion: Dispersion | None = Field(default=None, description="Index by wavelength; None is constant")
    absorbers: tuple[Absorber, ...] = Field(default=(), description="What `sigma_a` was computed from")
    abbe: float | None = Field(default=None, gt=0.0, description="Abbe number V_d [1]")
    density: float | None = Field(default=None, gt=0.0, description="Density at 20 degC [kg/m^3]")
    surface_tension: float | None = Field(default=None, gt=0.0, description="Liquids: against air, 20 degC [N/m]")
    contact_angle: float | None = Field(default=None, ge=0.0, le=3.1416, description="Liquids: on glass [rad]")
    source: str = Field(default="", description="Where the constants come from")

    @model_validator(mode="before")
    @classmethod
    def _name_the_medium_in_errors(cls, data: Any) -> Any:
        # pydantic's own message has the field but not the medium; a scene holds many media.
        if isinstance(data, dict):
            name = f"medium {data.get('name', '?')}"
            eta, sigma_a = data.get("eta"), data.get("sigma_a", ())
            if isinstance(eta, int | float) and not 1.0 <= eta < float("inf"):
                raise InputError(name, "a refractive index of at least 1", eta)
            for value in sigma_a if isinstance(sigma_a, list | tuple) else ():
                if isinstance(value, int | float) and not 0.0 <= value < float("inf"):
                    raise InputError(name, "an absorption of at least 0 per metre", value)
        return data

    @model_validator(mode="after")
    def _index_fits_formula(self) -> Medium:
        if self.dispersion is not None:
            n_d = float(index(self.dispersion, D_LINE))
            if abs(n_d - self.eta) > 0.6 * 10.0**-ETA_DIGITS:
                raise InputError(f"medium {self.name}", f"the index of its formula at the d line, {n_d:.6f}", self.eta)
        return self


#: Air at 15 degC and 1013 hPa has index 1.00028 (Edlen 1966, doi:10.1088/0026-1394/2/2/002). Indices of solids and
#: liquids in the catalogue are relative to air, so air is 1.
AIR = Medium(name="air", eta=1.0)


def eta(medium: Medium, wavelength_nm: ArrayLike, outside: Literal["refuse", "hold"] = "refuse") -> np.ndarray:
    """Return the refractive index of a medium at some wavelengths.

    A medium without a dispersion formula has the same index at all wavelengths.

    Parameters
    ----------
    medium : Medium
        The medium.
    wavelength_nm : float or array of any shape
        Wavelength in air [nm].
    outside : {"refuse", "hold"}
        What to do outside the formula's valid range: raise, or use the nearest valid wavelength. A spectral renderer
        samples down to 360 nm and up to 830 nm, where some formulas end and the eye sees next to nothing, so it holds.

    Raises
    ------
    InputError
        A wavelength is outside the valid range and `outside` is ``"refuse"``.
    """
    wavelength = np.asarray(wavelength_nm, dtype=np.float64)
    if medium.dispersion is None:
        return np.full(wavelength.shape, medium.eta)
    low, high = medium.dispersion.valid
    return index(medium.dispersion, in_range(wavelength, low, high, f"index of {medium.name}", outside))
