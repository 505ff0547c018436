"""Media in the near infrared: index and absorption at the projector's wavelength."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...procedural.optics.dispersion import index
from ...procedural.optics.medium import Absorber, Medium
from ...procedural.optics.spectra import Sampled, coefficient, from_extinction, mixture
from .._mitsuba import dr, mi
from ..scene.loaded_scene import LoadedScene

#: Absorption beyond the tables of the visible range by spectrum: wavelength [nm] and coefficient [1/m], 4 pi k /
#: wavelength. Water: k of Hale and Querry, Appl. Opt. 12, 555 (1973), table I, doi:10.1364/AO.12.000555. Soda-lime
#: glass: k of Rubin 1985, doi:10.1016/0165-1633(85)90052-8, of which the iron in it makes the most.
_BEYOND = {
    "water": Sampled(
        wavelengths=(725.0, 750.0, 775.0, 800.0, 850.0, 900.0, 950.0),
        values=(1.59, 2.61, 2.40, 1.96, 4.33, 6.79, 38.8),
        source="Hale and Querry 1973, table I",
    ),
    **{
        f"soda-lime, {kind}": from_extinction(k, 1e-8, (780.0, 800.0, 820.0, 850.0, 880.0, 900.0, 950.0, 1000.0), kind)
        for kind, k in {
            "low-iron": (49.16, 55.10, 61.28, 70.99, 78.75, 83.28, 93.76, 102.0),
            "clear": (221.4, 247.7, 275.5, 315.0, 351.0, 372.7, 417.0, 459.1),
            "green": (932.7, 1042.0, 1153.0, 1312.0, 1455.0, 1545.0, 1741.0, 1897.0),
            "bronze": (635.5, 698.8, 759.3, 850.7, 945.9, 1002.0, 1111.0, 1210.0),
            "grey": (588.5, 653.0, 720.8, 816.5, 900.7, 953.1, 1066.0, 1166.0),
        }.items()
    },
}
#: How far dispersion formulas are followed past the end of their range [nm]. They are smooth there: that of glycerol
#: ends at 710 nm, and at 850 nm it is within 1e-4 of one measured up to 1050 nm (Rheims et al. 1997), where the index
#: at its end is 2e-3 too high.
_PAST_END = 250.0


def infrared_index(medium: Medium, nm: float) -> float:
    """Return the index of a medium relative to air, with its formula followed past the end of its range (`_PAST_END`).

    Parameters
    ----------
    medium : Medium
        The medium.
    nm : float
        Wavelength [nm].
    """
    if medium.dispersion is None:
        return medium.eta
    low, high = medium.dispersion.valid
    return float(index(medium.dispersion, float(np.clip(nm, low, high + _PAST_END))))


def infrared_absorption(medium: Medium, nm: float) -> float:
    """Return the absorption coefficient of a medium in the near infrared [1/m].

    Other spectra than those of water and soda-lime glass hold their last value. A medium without spectra keeps the
    smallest of its three channels.
    """
    if not medium.absorbers:
        return float(min(medium.sigma_a))
    return max(sum(_absorption(part, nm) for part in medium.absorbers), 0.0)


def _absorption(part: Absorber, nm: float) -> float:
    """Return what one part of a medium absorbs [1/m]."""
    known = None if part.samples else _BEYOND.get(part.spectrum)
    if known is None or nm <= known.wavelengths[0]:
        return float(mixture((part,), nm))
    return part.amount * float(coefficient(known, nm))


def at_wavelength(loaded: LoadedScene, nm: float) -> LoadedScene:
    """Return a scene whose labels' columns of index and absorption are those at a wavelength [nm]."""
    media = loaded.surfaces.media
    indices = [infrared_index(medium, nm) for medium in media]
    absorption = [infrared_absorption(medium, nm) for medium in media]
    columns = mi.Float(np.array(indices, np.float32)), mi.Float(np.repeat(np.array(absorption, np.float32), 3))
    dr.make_opaque(*columns)
    return replace(loaded, surfaces=replace(loaded.surfaces, eta_d=columns[0], sigma_a_rgb=columns[1]))
