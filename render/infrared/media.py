"""Media in the near infrared: index and absorption at the projector's wavelength."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...procedural.optics.medium import Medium, eta
from ...procedural.optics.spectra import mixture
from .._mitsuba import dr, mi
from ..scene.loaded_scene import LoadedScene

#: Pure water beyond the table of the visible range: wavelength [nm] and absorption [1/m], 4 pi k / wavelength by the k
#: of Hale and Querry, Appl. Opt. 12, 555 (1973), table I, doi:10.1364/AO.12.000555.
_WATER = ((725.0, 1.59), (750.0, 2.61), (775.0, 2.40), (800.0, 1.96), (850.0, 4.33), (900.0, 6.79), (950.0, 38.8))
#: Name of its spectrum.
_WATER_SPECTRUM = "water"


def infrared_absorption(medium: Medium, nm: float) -> float:
    """Return the absorption coefficient of a medium in the near infrared [1/m].

    Spectra that end before hold their last value. A medium without spectra keeps the smallest of its three channels.
    """
    if not medium.absorbers:
        return float(min(medium.sigma_a))
    water = [a for a in medium.absorbers if a.spectrum == _WATER_SPECTRUM and not a.samples and nm > _WATER[0][0]]
    others = tuple(a for a in medium.absorbers if a not in water)
    wavelengths, values = zip(*_WATER, strict=True)
    of_water = sum(a.amount for a in water) * float(np.interp(nm, wavelengths, values))
    return max(of_water + float(mixture(others, nm)), 0.0)


def at_wavelength(loaded: LoadedScene, nm: float) -> LoadedScene:
    """Return a scene whose labels' columns of index and absorption are those at a wavelength [nm]."""
    media = loaded.surfaces.media
    index = [float(eta(medium, nm, outside="hold")) for medium in media]
    absorption = [infrared_absorption(medium, nm) for medium in media]
    columns = mi.Float(np.array(index, np.float32)), mi.Float(np.repeat(np.array(absorption, np.float32), 3))
    dr.make_opaque(*columns)
    return replace(loaded, surfaces=replace(loaded.surfaces, eta_d=columns[0], sigma_a_rgb=columns[1]))
