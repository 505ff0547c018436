"""Colour of light: black bodies, the CIE 1931 observer and linear Rec.709."""

from __future__ import annotations

import numpy as np

#: Second radiation constant h c / k [nm K] (CODATA 2018).
SECOND_RADIATION = 1.438776877e7
#: XYZ (D65 white at Y = 1) to linear Rec.709, ITU-R BT.709 primaries (IEC 61966-2-1).
RGB_FROM_XYZ = np.array(
    [
        [3.2406, -1.5372, -0.4986],
        [-0.9689, 1.8758, 0.0415],
        [0.0557, -0.2040, 1.0570],
    ]
)
#: Relative luminance of linear Rec.709 (ITU-R BT.709-6).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

# Lobes of the fits to x, y, z: height, centre [nm], inverse widths below and above the centre [1/nm] (Wyman et al.).
_LOBES = (
    ((1.056, 599.8, 37.9, 31.0), (0.362, 442.0, 16.0, 26.7), (-0.065, 501.1, 20.4, 26.2)),
    ((0.821, 568.8, 46.9, 40.5), (0.286, 530.9, 16.3, 31.1)),
    ((1.217, 437.0, 11.8, 36.0), (0.681, 459.0, 26.0, 13.8)),
)


def observer(wavelength: np.ndarray) -> np.ndarray:
    """Return the CIE 1931 2-degree colour matching functions.

    Parameters
    ----------
    wavelength : (n,) float
        Vacuum wavelength [nm].

    Returns
    -------
    (n, 3) float64
        x, y, z: the multi-lobe fit, equation 4 of Wyman, Sloan, Shirley, "Simple Analytic Approximations to the CIE
        XYZ Color Matching Functions", JCGT 2(2), 2013.
    """
    columns = [sum(_lobe(wavelength, *lobe) for lobe in lobes) for lobes in _LOBES]
    return np.stack(columns, axis=-1)


def black_body(temperature: float) -> np.ndarray:
    """Return the colour of a black body (Planck's law) at luminance 1.

    Parameters
    ----------
    temperature : float
        Temperature [K], 2000 to 20000 (colder ones leave the gamut of Rec.709).

    Returns
    -------
    (3,) float64
        Linear Rec.709.
    """
    if not 2000.0 <= temperature <= 20000.0:
        raise ValueError(f"temperature: expected 2000 to 20000 K, got {temperature}")
    x, y = black_body_chromaticity(temperature)
    return rgb_of_xyy(np.array([x, y, 1.0]))


def black_body_chromaticity(temperature: float) -> np.ndarray:
    """Return the CIE 1931 (x, y) of a black body of this temperature [K], (2,) float64."""
    wavelength = np.arange(360.0, 831.0, 1.0)
    radiance = wavelength**-5.0 / np.expm1(SECOND_RADIATION / (wavelength * temperature))
    xyz = radiance @ observer(wavelength)
    return xyz[:2] / xyz.sum()


def rgb_of_xyy(xyy: np.ndarray) -> np.ndarray:
    """Return linear Rec.709, (..., 3) float64, of CIE (x, y, Y), (..., 3); colours outside the gamut go below 0."""
    x, y, luminance = np.moveaxis(np.asarray(xyy, dtype=np.float64), -1, 0)
    xyz = np.stack([x * luminance / y, luminance, (1.0 - x - y) * luminance / y], axis=-1)
    return xyz @ RGB_FROM_XYZ.T


def luminance(rgb: np.ndarray) -> np.ndarray:
    """Return the relative luminance of linear Rec.709, (..., 3) -> (...)."""
    return np.asarray(rgb) @ LUMINANCE


def _lobe(wavelength: np.ndarray, height: float, centre: float, below: float, above: float) -> np.ndarray:
    width = np.where(wavelength < centre, below, above)
    return height * np.exp(-0.5 * ((wavelength - centre) / width) ** 2)
