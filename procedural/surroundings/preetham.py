"""The daylight sky of Preetham, Shirley, Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999."""

from __future__ import annotations

import math

import numpy as np

# Appendix A.2: distribution coefficients A to E are linear in the turbidity, rows (slope, constant).
_LUMINANCE = np.array([[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]])
_CHROMA_X = np.array([[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]])
_CHROMA_Y = np.array([[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]])
# Appendix A.2: zenith chromaticity, rows by powers 2, 1, 0 of turbidity, columns by powers 3 to 0 of the sun's angle.
_ZENITH_X = np.array(
    [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]]
)
_ZENITH_Y = np.array(
    [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]]
)


def sky_xyy(directions: np.ndarray, sun: np.ndarray, turbidity: float) -> np.ndarray:
    """Return chromaticity and luminance of the clear sky (equations 3 and 4).

    Parameters
    ----------
    directions : (..., 3) float
        Unit vectors; those below the horizon have the value at the horizon.
    sun : (3,) float
        Unit vector to the sun, above the horizon.
    turbidity : float
        Haze, 1.7 to 10.

    Returns
    -------
    (..., 3) float64
        CIE x, y and luminance Y [kcd/m^2].
    """
    cosine = np.maximum(np.asarray(directions, np.float64)[..., 2], 0.0)
    toward = np.clip(np.asarray(directions, np.float64) @ sun, -1.0, 1.0)
    columns = [
        zenith * _perez(table, turbidity, cosine, toward) / _perez(table, turbidity, np.ones(()), np.asarray(sun[2]))
        for zenith, table in zip(zenith_xyy(sun[2], turbidity), (_CHROMA_X, _CHROMA_Y, _LUMINANCE), strict=True)
    ]
    return np.stack(columns, axis=-1)


def zenith_xyy(sun_height: float, turbidity: float) -> np.ndarray:
    """Return x, y and Y [kcd/m^2] at the zenith, (3,) float64; `sun_height` is the sine of the sun's elevation."""
    angle = math.acos(min(max(sun_height, -1.0), 1.0))
    chi = (4.0 / 9.0 - turbidity / 120.0) * (math.pi - 2.0 * angle)
    level = (4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192
    haze = np.array([turbidity**2, turbidity, 1.0])
    powers = np.array([angle**3, angle**2, angle, 1.0])
    return np.array([haze @ _ZENITH_X @ powers, haze @ _ZENITH_Y @ powers, level])


def _perez(table: np.ndarray, turbidity: float, cosine: np.ndarray, toward: np.ndarray) -> np.ndarray:
    """Return Perez's distribution (equation 3) for the cosines of the zenith angle and of the angle to the sun."""
    a, b, c, d, e = table @ np.array([turbidity, 1.0])
    # B is negative for every turbidity allowed: at the horizon the exponential is 0. The floor avoids 1 / 0.
    gradation = 1.0 + a * np.exp(b / np.maximum(cosine, 1e-3))
    return gradation * (1.0 + c * np.exp(d * np.arccos(toward)) + e * toward**2)
