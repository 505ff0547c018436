"""Stokes vectors as arrays: degrees and angles of polarisation.

s1 > 0 is light that oscillates along the rows of the picture, s2 > 0 along the diagonal from lower left to upper right.
"""

from __future__ import annotations

import numpy as np


def degree_of_linear_polarisation(stokes: np.ndarray) -> np.ndarray:
    """Return the degree of linear polarisation, sqrt(s1^2 + s2^2) / s0; 0 where s0 is 0.

    Parameters
    ----------
    stokes : (..., 4, channels)
        Stokes vectors; the last component is not read, and may be left out. Noise of s1 and s2 makes the degree too
        high on average: render with many samples.

    Returns
    -------
    (..., channels)
        From 0 to 1 for light of one wavelength and for the luminance of a vector. Red, green and blue of spectral
        variants are differences of wavelengths: in saturated or noisy colours their degree may lie above 1.
    """
    return _ratio(np.hypot(stokes[..., 1, :], stokes[..., 2, :]), stokes[..., 0, :])


def degree_of_polarisation(stokes: np.ndarray) -> np.ndarray:
    """Return the degree of polarisation, sqrt(s1^2 + s2^2 + s3^2) / s0; otherwise as the linear degree."""
    return _ratio(np.sqrt((stokes[..., 1:, :] ** 2).sum(-2)), stokes[..., 0, :])


def angle_of_linear_polarisation(stokes: np.ndarray) -> np.ndarray:
    """Return the angle of linear polarisation, atan2(s2, s1) / 2.

    Parameters
    ----------
    stokes : (..., 4, channels)
        Stokes vectors; the last component is not read, and may be left out.

    Returns
    -------
    (..., channels)
        Angle from the picture's x axis, counter-clockwise as seen in the picture, in (-pi/2, pi/2] [rad].
    """
    return 0.5 * np.arctan2(stokes[..., 2, :], stokes[..., 1, :])


def behind_filter(stokes: np.ndarray, angle: float | np.ndarray, extinction_ratio: float = np.inf) -> np.ndarray:
    """Return the light behind a linear filter.

    Its axis passes all light that oscillates along it, and the rest over the extinction ratio: with q = (r - 1) / (r +
    1) that is (1 + 1 / r) / 2 (s0 + q (s1 cos 2a + s2 sin 2a)) (Goldstein, Polarized Light, 2011, chapter 5).

    Parameters
    ----------
    stokes : (..., 4, channels)
        Stokes vectors; the last component is not read, and may be left out.
    angle : float or (...) float
        Of the axis, from the picture's x axis, counter-clockwise as seen in the picture [rad].
    extinction_ratio : float
        Light that passes along the axis over light that passes across it, r above 1.

    Returns
    -------
    (..., channels)
    """
    across, twice = 1.0 / extinction_ratio, 2.0 * np.asarray(angle)[..., None]
    wave = np.cos(twice) * stokes[..., 1, :] + np.sin(twice) * stokes[..., 2, :]
    return 0.5 * ((1.0 + across) * stokes[..., 0, :] + (1.0 - across) * wave)


def _ratio(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    return np.divide(part, whole, out=np.zeros_like(part), where=whole > 0.0)
