"""The capillary meniscus of a liquid in a cylindrical vessel: a solver of the axisymmetric Young-Laplace equation.

With ``lc = sqrt(gamma / (rho g))`` the capillary length, phi the surface's slope angle and z the height above the
level at which the liquid's pressure is the air's (Laplace 1805; de Gennes, Brochard-Wyart and Quere, "Capillarity and
Wetting Phenomena", 2004, sections 1.1 and 2.2)::

    d(phi)/ds + sin(phi) / r = z / lc^2,    dr/ds = cos(phi),    dz/ds = sin(phi).

phi grows from 0 on the axis to its value at the wall, so it serves as the independent variable. It may pass 90 degrees:
under a wall that leans inwards (the shoulder of a bottle) a wetting liquid overhangs, and the radius turns back.

Near the axis the equation is linear. From there on, r and z are smooth functions of t = ln(phi), so polynomials through
Chebyshev points represent them to many digits (Trefethen 2000, "Spectral Methods in MATLAB", chapter 6). Newton's
method solves the discretised boundary value problem; a coarse shooting solution starts it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import root_scalar
from scipy.special import i0e, i1e

from ...core.errors import InputError

#: Standard gravity [m/s^2], CGPM 1901.
GRAVITY = 9.80665
#: Slope [rad] up to which the linear equation is used. Its relative error is of the order of the slope squared, 1e-8.
LINEAR_SLOPE = 1e-4
#: Steepest slope at the wall [rad]. Just below half a turn, where the surface would run into itself on the way back.
MOST_SLOPE = np.radians(175.0)
#: Chebyshev intervals between the linear part and the wall. Measured against adaptive integration to 1e-10, the height
#: of the contact line differs by at most 1e-10 of itself for slopes up to 126 degrees. Beyond, narrow tubes are worse:
#: at 150 and 172 degrees 1e-9 and 3e-8 in a tube of 0.3 capillary lengths, 6e-8 and 1e-5 in one of 0.05.
INTERVALS = 48
#: Relative Newton step after which the solution is final. Newton's steps square their relative size, so what is left is
#: rounding. From the coarse solution two or three steps reach it; the limit only ends a loop that would never end.
NEWTON_TOLERANCE, NEWTON_LIMIT = 1e-9, 12
#: Error of ln(start) at which coarse shooting stops [1]: 1 % of the start, well inside Newton's reach.
SHOOTING_TOLERANCE = 1e-2


@dataclass(frozen=True, eq=False)
class Meniscus:
    """The surface of a liquid at rest in an axisymmetric vessel.

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
    """Solve the meniscus of a liquid in an axisymmetric vessel.

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
        Points of the profile, at least 8; they are denser near the wall.

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
    nodes = _collocated(radius, climb)
    start = float(nodes[0, 0])
    flat = max(samples // 4, 2)
    r = np.linspace(0.0, start, flat, endpoint=False)
    inner = np.stack([r, _linear_height(r, start, LINEAR_SLOPE)], axis=1)
    # Slopes by the cube: z decays exponentially away from the wall, so most of the surface is nearly flat.
    slopes = LINEAR_SLOPE + (climb - LINEAR_SLOPE) * np.linspace(0.0, 1.0, samples - flat) ** 3
    places = 2.0 * np.log(slopes / LINEAR_SLOPE) / np.log(climb / LINEAR_SLOPE) - 1.0
    rows = np.concatenate([inner, _interpolated(nodes, np.clip(places, -1.0, 1.0))])
    return rows, np.concatenate([_linear_slope(r, start, LINEAR_SLOPE), slopes])


def _linear_height(r: np.ndarray, edge: float, slope: float) -> np.ndarray:
    """Return ``slope I0(r) / I1(edge)``, the surface of small slopes; scaled, so that it cannot overflow."""
    return slope * i0e(r) * np.exp(r - edge) / i1e(edge)


def _linear_slope(r: np.ndarray, edge: float, slope: float) -> np.ndarray:
    """Return the derivative of `_linear_height`, ``slope I1(r) / I1(edge)``."""
    return slope * i1e(r) * np.exp(r - edge) / i1e(edge)


def _chebyshev(intervals: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points in [-1, 1], barycentric weights, and the differentiation matrix (Trefethen 2000, eq. 6.3-6.5)."""
    count = np.arange(intervals + 1)
    points = -np.cos(np.pi * count / intervals)
    weights = (-1.0) ** count
    weights[[0, -1]] *= 0.5
    matrix = (weights / weights[:, None]) / (points[:, None] - points + np.eye(intervals + 1))
    return points, weights, matrix - np.diag(matrix.sum(1))


_POINTS, _WEIGHTS, _DERIVATIVE = _chebyshev(INTERVALS)


def _collocated(radius: float, climb: float) -> np.ndarray:
    """Return rows (r, z) at the Chebyshev points of t, from the end of the linear part to the wall, by Newton steps.

    With q = phi / (z - sin(phi) / r) the equations are dr/dt = q cos(phi) and dz/dt = q sin(phi). At the first point
    z = phi I0(r) / I1(r), at the last r = radius.
    """
    half = 0.5 * math.log(climb / LINEAR_SLOPE)  # from an interval of length 2 to that of t
    slopes = LINEAR_SLOPE * np.exp(half * (_POINTS + 1.0))
    sine, cosine = half * slopes * np.sin(slopes), half * slopes * np.cos(slopes)
    state = _shot(radius, slopes, half)
    for _ in range(NEWTON_LIMIT):
        r, z = state
        turn = np.sin(slopes) / r
        q = 1.0 / (z - turn)
        residual = np.stack([_DERIVATIVE @ r - cosine * q, _DERIVATIVE @ z - sine * q])
        by_z, by_r = q**2, q**2 * turn / r  # derivatives of -q
        jacobian = np.zeros((2, len(r), 2, len(r)))
        jacobian[0, :, 0] = _DERIVATIVE + np.diag(cosine * by_r)
        jacobian[0, :, 1] = np.diag(cosine * by_z)
        jacobian[1, :, 0] = np.diag(sine * by_r)
        jacobian[1, :, 1] = _DERIVATIVE + np.diag(sine * by_z)
        ratio = float(i0e(r[0]) / i1e(r[0]))
        residual[1, 0], residual[0, -1] = z[0] - LINEAR_SLOPE * ratio, r[-1] - radius
        jacobian[1, 0], jacobian[0, -1] = 0.0, 0.0
        jacobian[0, -1, 0, -1] = jacobian[1, 0, 1, 0] = 1.0
        jacobian[1, 0, 0, 0] = -LINEAR_SLOPE * (1.0 - ratio**2 + ratio / r[0])
        step = np.linalg.solve(jacobian.reshape(2 * len(r), -1), residual.ravel()).reshape(2, -1)
        state = state - step
        if (np.abs(step).max(1) <= NEWTON_TOLERANCE * state[:, -1]).all():
            return state.T
    raise RuntimeError(f"the meniscus of radius {radius} and slope {climb} did not converge")


def _shot(radius: float, slopes: np.ndarray, half: float) -> np.ndarray:
    """Return (2, n) r and z at slopes, roughly: by shooting for the radius where the linear part ends."""
    angles, steps = slopes.tolist(), (half * np.diff(_POINTS)).tolist()
    # The surface is linear up to some start < radius. A start much nearer to the axis bends too early.
    bracket = (math.log(radius * LINEAR_SLOPE * 1e-2), math.log(radius))
    found = root_scalar(
        lambda log_start: math.log(_shooting_path(math.exp(log_start), angles, steps)[-1][0] / radius),
        bracket=bracket,
        method="brentq",
        xtol=SHOOTING_TOLERANCE,
    )
    return np.array(_shooting_path(math.exp(found.root), angles, steps)).T


def _shooting_path(start: float, slopes: list[float], steps: list[float]) -> list[tuple[float, float]]:
    """Integrate (r, z) over t by one Runge-Kutta step of fourth order from each slope to the next.

    In floats of Python: for so few numbers that is faster than arrays.
    """

    def change(phi: float, r: float, z: float) -> tuple[float, float]:
        sine = math.sin(phi)
        q = phi / (z - sine / r)
        return q * math.cos(phi), q * sine

    r, z = start, float(_linear_height(np.array(start), start, LINEAR_SLOPE))
    path = [(r, z)]
    for phi, h in zip(slopes, steps, strict=False):  # no step leaves from the last slope
        middle, after = phi * math.exp(0.5 * h), phi * math.exp(h)
        r1, z1 = change(phi, r, z)
        r2, z2 = change(middle, r + 0.5 * h * r1, z + 0.5 * h * z1)
        r3, z3 = change(middle, r + 0.5 * h * r2, z + 0.5 * h * z2)
        r4, z4 = change(after, r + h * r3, z + h * z3)
        r += h / 6.0 * (r1 + 2.0 * r2 + 2.0 * r3 + r4)
        z += h / 6.0 * (z1 + 2.0 * z2 + 2.0 * z3 + z4)
        path.append((r, z))
    return path


def _interpolated(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the polynomial through ``values`` (n, k) at the Chebyshev points, at places (m,) in [-1, 1]: (m, k).

    The barycentric formula (Berrut and Trefethen 2004, "Barycentric Lagrange Interpolation", eq. 4.2).
    """
    distance = places[:, None] - _POINTS
    on_point = distance == 0.0
    weights = _WEIGHTS / np.where(on_point, 1.0, distance)
    weights = np.where(on_point.any(1, keepdims=True), on_point, weights)
    return weights @ values / weights.sum(1, keepdims=True)
