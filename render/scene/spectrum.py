"""Colour representation of the active variant: RGB, one grey channel, or four wavelengths a path."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.errors import InputError
from ...procedural.optics.medium import Medium, eta
from ...procedural.optics.spectra import absorption
from ...procedural.surroundings.colour import luminance
from .._mitsuba import dr, mi, require_variant

#: Grid of the media's spectra [nm, nm, 1]: Mitsuba samples wavelengths from 360 to 830 nm. At 5 nm, linear
#: interpolation of the narrowest dye band (a Gaussian of 40 nm full width) is within 0.6 % of its peak.
FIRST_NM, STEP_NM, GRID = 360.0, 5.0, 95


def check_variant(dispersion: bool) -> None:
    """Raise InputError where no variant is active, or it cannot render dispersion although the picture requires it."""
    require_variant()
    if dispersion and not mi.is_spectral:
        raise InputError("picture.dispersion", "a spectral variant, such as llvm_ad_spectral", mi.variant())


def in_channel(colours: np.ndarray, channel: int | None) -> np.ndarray:
    """Return linear Rec.709 colours (..., 3) with one of their channels in all three; unchanged where it is None.

    Variants of one channel take the luminance of colours, and the luminance of a product (of light and reflectance) is
    not the product of luminances. Three pictures of one channel each are the picture in colours.
    """
    return colours if channel is None else np.repeat(colours[..., channel : channel + 1], 3, axis=-1)


def media_columns(
    media: Sequence[Medium], dispersion: bool, channel: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return index (media, samples) and absorption (media, samples) [1/m], sampled for the active variant."""
    if mi.is_spectral:
        nm = FIRST_NM + STEP_NM * np.arange(GRID)
        # The ends of the visible range lie outside the validity of some dispersion formulas, where the sensitivity of
        # the eye is almost zero: the value at the end of the validity is held.
        index = [eta(m, nm, outside="hold") if dispersion else np.full(GRID, m.eta) for m in media]
        return np.array(index), np.array([absorption(m, nm, outside="hold") for m in media])
    sigma_a = in_channel(np.array([m.sigma_a for m in media]), channel)
    return np.array([[m.eta] for m in media]), sigma_a if mi.is_rgb else luminance(sigma_a)[:, None]


def index_at(column: mi.Float, medium: mi.UInt32, wavelengths: Any, active: mi.Bool) -> mi.Float:
    """Return the index of a medium: at the path's hero (first) wavelength in spectral variants, else the only one."""
    if not mi.is_spectral:
        return dr.gather(mi.Float, column, medium, active)
    cell, t = _cell(wavelengths[0])
    row = medium * GRID + cell
    return dr.lerp(dr.gather(mi.Float, column, row, active), dr.gather(mi.Float, column, row + 1, active), t)


def absorption_at(column: mi.Float, medium: mi.UInt32, wavelengths: Any, active: mi.Bool) -> mi.Spectrum:
    """Return the absorption of a medium for every channel of the path [1/m]."""
    if not mi.is_spectral:
        return dr.gather(mi.UnpolarizedSpectrum, column, medium, active)
    value = mi.UnpolarizedSpectrum(0.0)
    for channel in range(len(wavelengths)):
        cell, t = _cell(wavelengths[channel])
        row = medium * GRID + cell
        low, high = dr.gather(mi.Float, column, row, active), dr.gather(mi.Float, column, row + 1, active)
        value[channel] = dr.lerp(low, high, t)
    return value


def _cell(nm: mi.Float) -> tuple[mi.UInt32, mi.Float]:
    """Return the grid cell of a wavelength and the position in it, from 0 to 1."""
    place = dr.clip((nm - FIRST_NM) / STEP_NM, 0.0, GRID - 1.001)
    cell = mi.UInt32(place)
    return cell, place - mi.Float(cell)


def draw_wavelengths(sample: mi.Float) -> tuple[Any, mi.Spectrum]:
    """Sample the wavelengths of paths [nm] and their weight; empty and 1 in variants without wavelengths."""
    if mi.is_spectral:
        return mi.sample_rgb_spectrum(mi.sample_shifted(sample))
    return dr.zeros(mi.Ray3f).wavelengths, mi.UnpolarizedSpectrum(1.0)


def hero_wavelength(throughput: mi.Spectrum) -> mi.Spectrum:
    """Return the throughput with all weight on the hero (first) wavelength, which dispersion separates from the others.

    Hero wavelength spectral sampling (Wilkie et al. 2014, CGF 33(4)) with the secondary wavelengths terminated.
    """
    alone = mi.UnpolarizedSpectrum(0.0)
    if mi.is_polarized:
        alone[0] = len(alone)
        return throughput * mi.Spectrum(alone)
    alone[0] = throughput[0] * len(throughput)
    return alone


def to_rgb(value: mi.Spectrum, wavelengths: Any) -> mi.Color3f:
    """Return radiance as linear Rec.709."""
    if mi.is_spectral:
        return mi.spectrum_to_srgb(value, wavelengths)
    return mi.Color3f(value) if mi.is_rgb else mi.Color3f(value[0])


def unpolarised(value: mi.Spectrum) -> mi.UnpolarizedSpectrum:
    """Return the factor on unpolarised radiance: the first element of a Mueller matrix, else the spectrum itself."""
    return value[0, 0] if mi.is_polarized else value


def to_output(radiance: mi.Spectrum, weight: mi.UnpolarizedSpectrum, wavelengths: Any) -> list[mi.Color3f]:
    """Return radiance as linear Rec.709; in polarised variants a Stokes vector, the first column of `radiance`."""
    if not mi.is_polarized:
        return [to_rgb(radiance * weight, wavelengths)]
    return [to_rgb(radiance[row, 0] * weight, wavelengths) for row in range(4)]


def to_guide(value: mi.Spectrum) -> mi.Color3f:
    """Return a reflectance as the denoiser's albedo: its colour in RGB variants, its mean over the channels else."""
    return mi.Color3f(value) if mi.is_rgb else mi.Color3f(dr.mean(unpolarised(value)))
