"""A user's own media, from a YAML file: index by wavelength, absorption or a colour at a depth, capillary constants.

::

    elderflower syrup:
      index: 1.43
      colour: {rgb: [0.92, 0.86, 0.55], depth: 5cm}
      density: 1210
      surface_tension: 0.07
      contact_angle: 25deg

What is given becomes a `Medium` of the catalogue's form, which a stored scene holds whole.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationError, model_validator

from ...core.errors import InputError
from ...core.model import Model, Rgb
from ...core.setting_errors import setting_error, shortened
from ...core.units import ANGLE, Length
from ...core.user_text import usable_text
from ...core.yaml_file import yaml_settings
from .catalogue import catalogue
from .colour import LIQUID_LENGTH, WAVELENGTHS, rgb_absorption, transmitted_rgb
from .dispersion import D_LINE, Cauchy, Dispersion, Sellmeier, abbe_number, index
from .draw import LIQUID_WEIGHTS
from .medium import ETA_DIGITS, Absorber, Medium

#: Refractive indices that transparent media have in visible light [1]: perfluorinated liquids have 1.24 and diamond
#: 2.42; aerogels and rutile lie at the ends.
LEAST_INDEX, MOST_INDEX = 1.0, 3.0
#: Largest absorption that is taken [1/m]: a hundredth of a millimetre of it lets 37 % through; more is a metal or ink.
MOST_ABSORPTION = 1e5
#: Visible wavelengths [nm], over which a formula without a range of its own counts as valid.
VISIBLE = (380.0, 780.0)
#: Fraunhofer lines between which an index must be one of `LEAST_INDEX` to `MOST_INDEX` [nm].
_TESTED = (400.0, 480.0, 550.0, 620.0, 700.0)
#: Largest distance of a table of indices from the smooth curve through it [1]: PET's fit, the worst here, has 9.4e-4.
MOST_RESIDUAL = 2e-3
#: Wavelengths between whose absorptions the spectrum of a colour is linear [nm]: near the peaks of the weights of
#: Rec.709 blue, green and red (`rgb_weights.RGB_WEIGHTS`).
_COLOUR_NODES = (450.0, 540.0, 610.0)

_Index = Annotated[float, Field(ge=LEAST_INDEX, le=MOST_INDEX)]
_Absorption = Annotated[float, Field(ge=0.0, le=MOST_ABSORPTION)]
_Wavelength = Annotated[float, Field(ge=200.0, le=2500.0)]
_ContactAngle = Annotated[float, Field(ge=0.0, le=math.pi), ANGLE]
_Channel = Annotated[float, Field(gt=0.0, le=1.0)]


def _form_of(value: object) -> str:
    """Return the form in which a figure is given; error lines name it behind its field."""
    return "table" if isinstance(value, dict) else "channels" if isinstance(value, list | tuple) else "number"


_IndexForm = Annotated[
    Annotated[_Index, Tag("number")] | Annotated[dict[_Wavelength, _Index], Tag("table")], Discriminator(_form_of)
]
_AbsorptionForm = Annotated[
    Annotated[_Absorption, Tag("number")]
    | Annotated[tuple[_Absorption, _Absorption, _Absorption], Tag("channels")]
    | Annotated[dict[_Wavelength, _Absorption], Tag("table")],
    Discriminator(_form_of),
]


class SellmeierTerms(Model):
    """Terms of Sellmeier's formula, with the wavelength in micrometres."""

    B: tuple[float, ...] = Field(min_length=1, description="Strengths [1]")
    C: tuple[float, ...] = Field(min_length=1, description="Squared resonance wavelengths [um^2]")

    @model_validator(mode="after")
    def _pairs(self) -> SellmeierTerms:
        if len(self.B) != len(self.C):
            raise ValueError(f"expected as many C as B ({len(self.B)}), found {len(self.C)}")
        return self


class CauchyTerms(Model):
    """Terms of Cauchy's formula, with the wavelength in micrometres."""

    A: float
    B: float = Field(default=0.0, description="[um^2]")
    C: float = Field(default=0.0, description="[um^4]")


class ColourAtDepth(Model):
    """White light after a stretch of the medium."""

    rgb: tuple[_Channel, _Channel, _Channel] = Field(description="Linear Rec.709, relative to the light [1]")
    depth: Length = Field(gt=0.0, le=10.0, description="Length of the stretch [m]")


class OwnMedium(Model):
    """One medium of a file of own media: an index in one form, and absorption in at most one."""

    index: _IndexForm | None = Field(
        default=None, description="One number, or a table: wavelength in air [nm] to index"
    )
    sellmeier: SellmeierTerms | None = None
    cauchy: CauchyTerms | None = None
    absorption: _AbsorptionForm | None = Field(
        default=None, description="One number, red green blue, or a table by wavelength [nm] [1/m]"
    )
    colour: ColourAtDepth | None = None
    density: float | None = Field(default=None, gt=0.0, le=25_000.0, description="[kg/m^3]")
    surface_tension: float | None = Field(default=None, gt=0.0, le=1.0, description="Liquids: against air [N/m]")
    contact_angle: _ContactAngle | None = Field(default=None, description="Liquids: on glass [rad]")
    source: str = Field(default="a file of own media", description="Where the constants come from")

    @model_validator(mode="after")
    def _one_of_each(self) -> OwnMedium:
        forms = [name for name in ("index", "sellmeier", "cauchy") if getattr(self, name) is not None]
        if len(forms) != 1:
            raise ValueError(f"expected one of index, sellmeier, cauchy, found {' and '.join(forms) or 'none'}")
        if self.absorption is not None and self.colour is not None:
            raise ValueError("expected absorption or colour, found both")
        for name in ("index", "absorption"):
            table = getattr(self, name)
            if isinstance(table, dict) and len(table) < 2:
                raise ValueError(f"{name}: expected a table of at least 2 wavelengths, found {len(table)}")
        return self


def read_media(path: Path) -> tuple[Medium, ...]:
    """Return the media of a YAML file, in its order.

    Raises
    ------
    InputError
        Naming the file, the medium and the field: no YAML, a field that is unknown or impossible, an index outside
        1 to 3 at some visible wavelength, absorption below 0, a name that the catalogue has.
    """
    entries = yaml_settings(path, "vessels.media")
    if not entries:
        raise InputError(path, "own media by name", "none")
    known = {*catalogue(), *LIQUID_WEIGHTS}
    clashes = [repr(name) for name in entries if name in known]
    if clashes:
        raise InputError(path, "names that the catalogue does not have", ", ".join(clashes))
    return tuple(_read(path, name, entry) for name, entry in entries.items())


def _read(path: Path, name: object, entry: object) -> Medium:
    where = f"{path}: {shortened(name).strip(chr(39))}"
    if not isinstance(name, str) or "=" in name or name == "none" or name != name.strip():
        raise InputError(path, "texts without = as names of media", shortened(name))
    try:
        usable_text(name)
        return own_medium(name, OwnMedium.model_validate(entry), where)
    except ValidationError as error:
        raise setting_error(where, error, OwnMedium, noun="fields of a medium") from error
    except InputError:
        raise
    except ValueError as error:
        raise InputError(where, *str(error).removeprefix("expected ").split(", found ", 1)) from error


def own_medium(name: str, given: OwnMedium, where: object) -> Medium:
    """Return a medium from its entry; InputError at `where` for an index or absorption that no medium has."""
    formula = _formula(given, where)
    eta = given.index if isinstance(given.index, float) else float(index(formula, D_LINE)) if formula else 1.0
    absorbers, sigma_a = _absorption(given)
    return Medium(
        name=name,
        eta=round(eta, ETA_DIGITS) if formula else eta,
        sigma_a=sigma_a,
        dispersion=formula,
        absorbers=absorbers,
        abbe=_abbe(formula),
        density=given.density,
        surface_tension=given.surface_tension,
        contact_angle=given.contact_angle,
        source=given.source,
    )


def _formula(given: OwnMedium, where: object) -> Dispersion | None:
    """Return the dispersion of an entry; None for one number."""
    if given.sellmeier is not None:
        terms = given.sellmeier
        formula = Sellmeier(B=terms.B, C=terms.C, valid=VISIBLE, source=given.source)
    elif given.cauchy is not None:
        terms = given.cauchy
        formula = Cauchy(A=terms.A, B=terms.B, C=terms.C, valid=VISIBLE, source=given.source)
    elif isinstance(given.index, dict):
        return _fitted(given.index, given.source, where)
    else:
        return None
    with np.errstate(invalid="ignore", divide="ignore"):
        found = index(formula, np.array(_TESTED))
    wrong = ~((found >= LEAST_INDEX) & (found <= MOST_INDEX))  # written so that NaN is wrong too
    if wrong.any():
        place = f"{where}: {'sellmeier' if given.sellmeier else 'cauchy'}"
        expected = f"an index of {LEAST_INDEX:g} to {MOST_INDEX:g} in visible light (wavelengths in micrometres)"
        raise InputError(place, expected, f"{found[wrong][0]:.4g} at {np.array(_TESTED)[wrong][0]:g} nm")
    return formula


def _fitted(table: dict[float, float], source: str, where: object) -> Cauchy:
    """Return Cauchy's formula through a table of indices, by least squares: two terms, from four points on three."""
    nm, values = np.array(sorted(table.items())).T
    powers = np.stack([(nm * 1e-3) ** -(2 * k) for k in range(3 if len(nm) > 3 else 2)], axis=1)
    terms = np.linalg.lstsq(powers, values, rcond=None)[0]
    residual = np.abs(powers @ terms - values)
    if residual.max() > MOST_RESIDUAL:
        at = float(nm[residual.argmax()])
        expected = f"indices within {MOST_RESIDUAL:g} of a smooth curve through them"
        raise InputError(f"{where}: index", expected, f"{table[at]:g} at {at:g} nm, {residual.max():.2g} from it")
    a, b, c = (*terms.tolist(), 0.0)[:3]
    return Cauchy(A=a, B=b, C=c, valid=(float(nm[0]), float(nm[-1])), source=f"{source}; fit to a table")


def _abbe(formula: Dispersion | None) -> float | None:
    """Return the Abbe number; None where the index is constant or rises with the wavelength."""
    if formula is None:
        return None
    with np.errstate(divide="ignore"):
        number = abbe_number(formula)
    return number if 0.0 < number < np.inf else None


def _absorption(given: OwnMedium) -> tuple[tuple[Absorber, ...], Rgb]:
    """Return the spectrum of an entry, and its three coefficients [1/m]."""
    absorption = given.absorption
    if isinstance(absorption, dict):
        absorbers = (_own_spectrum(sorted(absorption.items())),)
        return absorbers, rgb_absorption(absorbers, LIQUID_LENGTH)
    if given.colour is not None:
        red, green, blue = (-np.log(given.colour.rgb) / given.colour.depth).tolist()
        return _spectrum_of((red, green, blue), given.colour.depth), (red, green, blue)
    if isinstance(absorption, tuple):
        return _spectrum_of(absorption, LIQUID_LENGTH), absorption
    if absorption:
        return (_own_spectrum([(nm, absorption) for nm in VISIBLE]),), (absorption, absorption, absorption)
    return (), (0.0, 0.0, 0.0)


def _own_spectrum(samples: list[tuple[float, float]]) -> Absorber:
    return Absorber(spectrum="own", amount=1.0, samples=tuple(samples))


def _spectrum_of(sigma_a: Rgb, depth: float) -> tuple[Absorber, ...]:
    """Return a smooth spectrum, linear between three wavelengths, whose colour at a depth is nearest to coefficients.

    Spectral pictures use it. Colours that no such spectrum has come out as the nearest.
    """
    if not any(sigma_a):
        return ()
    wanted = np.exp(-np.array(sigma_a) * depth)

    def absorbers(values: np.ndarray) -> tuple[Absorber, ...]:
        at = np.interp(WAVELENGTHS[[0, -1]], _COLOUR_NODES, values)
        nodes = [VISIBLE[0], *_COLOUR_NODES, VISIBLE[1]]
        return (_own_spectrum(list(zip(nodes, [at[0], *values.tolist(), at[1]], strict=True))),)

    start = np.maximum(np.array(sigma_a[::-1]), 1e-3 / depth)
    scale = start.max()
    from scipy.optimize import least_squares  # here, as it takes a third of a second to load

    found = least_squares(
        lambda x: transmitted_rgb(absorbers(x * scale), depth) - wanted, start / scale, bounds=(0.0, np.inf)
    )
    return absorbers(found.x * scale)
