"""The capillary meniscus of a liquid in a round vessel: the axisymmetric Young-Laplace equation.

With ``lc = sqrt(gamma / (rho g))`` the capillary length, phi the surface's slope angle and z the height above the
level at which the liquid's pressure is the air's (Laplace 1805; de Gennes, Brochard-Wyart and Quere, "Capillarity and
Wetting Phenomena", 2004, sections 1.1 and 2.2)::

    d(phi)/ds + sin(phi) / r = z / lc^2,    dr/ds = cos(phi),    dz/ds = sin(phi).

phi grows from 0 on the axis to its value at the wall, so it serves as the independent variable. It may pass 90 degrees:
under a wall that leans inwards (the shoulder of a bottle) a wetting liquid overhangs, and the radius turns back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import OptimizeResult, root_scalar
from scipy.special import i0e, i1e

from ...core.errors import InputError

#: Standard gravity [m/s^2], CGPM 1901.
GRAVITY = 9.80665
#: Slope [rad] up to which the linear equation is used. Its relative error is of the order of the slope squared, 1e-8.
LINEAR_SLOPE = 1e-4
#: Steepest slope at the wall [rad]. Just below half a turn, where the surface would run into itself on the way back.
MOST_SLOPE = np.radians(175.0)
#: Relative tolerance of the integration, below the error of the linear part.
RTOL = 1e-10


@dataclass(frozen=True, eq=False)
class Meniscus:
    """The surface of a liquid at rest in a round vessel.

    Parameters
    ----------
    profile : (n, 2) float64
        Rows (r, z) [m] from the axis to the wall, z above the level of zero capillary pressure. In a vessel much wider
        than the capillary length that is the flat level in the middle.
    angles : (n,) float64
        Slope angle of the surface at each of them [rad].
    slope : float
        Slope angle of the surface at the wall [rad]; positive climbs, beyond pi / 2 overhangs.
    volume : float
        Liquid above z = 0 inside the contact line's radius (negative: missing below) [m^3], exact by the balance of
        vertical forces. Where the surface overhangs, the air under it outside that radius counts as missing liquid.
    """

    profile: np.ndarray
    angles: np.ndarray
    slope: float
    volume: float

    @property
    def wall_height(self) -> float:
        """Height of the contact line above z = 0 [m]."""
        return float(self.profile[-1, 1])

    @property
    def mean_height(self) -> float:
        """Mean height over the cross-section: how high the same liquid would stand, were it flat [m]."""
        return self.volume / (np.pi * float(self.profile[-1, 0]) ** 2)


def capillary_length(density: float, surface_tension: float) -> float:
    """Return ``sqrt(gamma / (rho g))`` [m] (de Gennes et al. 2004, eq. 2.1)."""
    return float(np.sqrt(surface_tension / (density * GRAVITY)))


def meniscus(
    radius: float,
    density: float,
    surface_tension: float,
    contact_angle: float,
    wall_tilt: float = 0.0,
    samples: int = 64,
) -> Meniscus:
    """Solve the meniscus of a liquid in a round vessel.

    Parameters
    ----------
    radius : float
        Radius of the contact line [m].
    density : float
        Density of the liquid [kg/m^3].
    surface_tension : float
        Against air [N/m].
    contact_angle : float
        Angle between wall and surface, inside the liquid [rad].
    wall_tilt : float
        Angle of the wall from the vertical at the contact line [rad]; positive where the vessel widens upwards.
    samples : int
        Points of the profile, at least 8; they crowd at the wall.

    Raises
    ------
    InputError
        A size that is not positive, or a surface that would close above itself (its slope at the wall beyond
        `MOST_SLOPE`).
    """
    for name, value in (("radius", radius), ("density", density), ("surface tension", surface_tension)):
        if not (value > 0.0 and np.isfinite(value)):
            raise InputError(f"meniscus, {name}", "a positive number", value)
    if samples < 8:
        raise InputError("meniscus, samples", "at least 8", samples)
    # Seen from the contact line, the surface runs inwards at pi + phi and the wall down at 3 pi / 2 - tilt.
    slope = np.pi / 2.0 - contact_angle - wall_tilt
    if not abs(slope) <= MOST_SLOPE:
        limit = f"a slope at the wall of at most {np.degrees(MOST_SLOPE):g} degrees"
        raise InputError("meniscus", limit, f"{np.degrees(slope):g} degrees")
    length = capillary_length(density, surface_tension)
    profile, angles = _unit_profile(radius / length, abs(slope), samples)
    profile *= length
    profile[-1, 0] = radius
    if slope < 0.0:
        profile[:, 1] *= -1.0
        angles = -angles
    profile.setflags(write=False)
    angles.setflags(write=False)
    # rho g V = 2 pi R gamma sin(slope): the wall's pull carries the liquid above z = 0 (de Gennes et al. 2004, 2.4).
    volume = 2.0 * np.pi * radius * length**2 * np.sin(slope)
    return Meniscus(profile, angles, float(slope), float(volume))


def _unit_profile(radius: float, climb: float, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Return rows (r, z) in units of the capillary length, and the slope angles, for a climbing surface."""
    if climb <= LINEAR_SLOPE:
        r = np.linspace(0.0, radius, samples)
        return np.stack([r, _linear_height(r, radius, climb)], axis=1), _linear_slope(r, radius, climb)

    def miss(log_start: float) -> float:
        return float(_integrated(np.exp(log_start), climb).y[0, -1]) - radius

    # The surface is linear up to some start < radius. A start much nearer to the axis bends too early.
    bracket = (np.log(radius * LINEAR_SLOPE * 1e-2), np.log(radius))
    start = float(np.exp(root_scalar(miss, bracket=bracket, method="brentq", xtol=1e-13).root))
    flat = max(samples // 4, 2)
    r = np.linspace(0.0, start, flat, endpoint=False)
    inner = np.stack([r, _linear_height(r, start, LINEAR_SLOPE)], axis=1)
    # Slopes by the cube: z decays exponentially away from the wall, so most of the surface is nearly flat.
    slopes = LINEAR_SLOPE + (climb - LINEAR_SLOPE) * np.linspace(0.0, 1.0, samples - flat) ** 3
    rows = np.concatenate([inner, _integrated(start, climb, slopes).y.T])
    return rows, np.concatenate([_linear_slope(r, start, LINEAR_SLOPE), slopes])


def _linear_height(r: np.ndarray, edge: float, slope: float) -> np.ndarray:
    """Return ``slope I0(r) / I1(edge)``, the surface of small slopes; scaled, so that it cannot overflow."""
    return slope * i0e(r) * np.exp(r - edge) / i1e(edge)


def _linear_slope(r: np.ndarray, edge: float, slope: float) -> np.ndarray:
    """Return the derivative of `_linear_height`, ``slope I1(r) / I1(edge)``."""
    return slope * i1e(r) * np.exp(r - edge) / i1e(edge)


def _integrated(start: float, climb: float, slopes: np.ndarray | None = None) -> OptimizeResult:
    """Integrate (r, z) over the slope from where the linear part ends."""

    def right_side(phi: float, state: np.ndarray) -> tuple[float, float]:
        curvature = state[1] - np.sin(phi) / state[0]
        return np.cos(phi) / curvature, np.sin(phi) / curvature

    height = float(_linear_height(np.array(start), start, LINEAR_SLOPE))
    return solve_ivp(
        right_side, (LINEAR_SLOPE, climb), (start, height), "DOP853", t_eval=slopes, rtol=RTOL, atol=RTOL * start
    )
