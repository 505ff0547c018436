"""Fresnel's equations: how much light an interface mirrors and lets through."""

from __future__ import annotations

import numpy as np

from glassware.procedural.optics.medium import Medium

from .bodies import box
from .bundles import refracted_rays, rows, scattered
from .check import EPS, ROUNDINGS, Check, worst
from .loading import interface, loaded

#: What the project promises of reflectance and transmittance [%].
FRESNEL_BOUND = 0.1
_N = 1.52


def reflectance(theta: np.ndarray, eta: float) -> np.ndarray:
    """Return the reflectance of an interface for unpolarised light (Born and Wolf, sec. 1.5.2, eq. 21a).

    Parameters
    ----------
    theta : (n,) float
        Angles of incidence [rad].
    eta : float
        Index behind the interface over index before it.
    """
    cos_i, sin_t = np.cos(theta), np.sin(theta) / eta
    cos_t = np.sqrt(np.maximum(1.0 - sin_t**2, 0.0))
    s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    p = (cos_t - eta * cos_i) / (cos_t + eta * cos_i)
    return np.where(sin_t >= 1.0, 1.0, 0.5 * (s**2 + p**2))


def reflected_fractions(count: int) -> list[Check]:
    """Measure reflectance and transmittance at 0 to 89 degrees from both sides.

    The random number that selects the lobe takes `count` evenly spread values; the fraction of them that is reflected
    is the reflectance.

    Parameters
    ----------
    count : int
        Numbers for each angle.
    """
    degrees = np.arange(90.0)
    checks = []
    for side, eta in (("air to glass", _N), ("glass to air", 1.0 / _N)):
        # Where reflection begins to be total its slope is infinite and the closed form itself says nothing within a
        # rounding; whole degrees stay away from that angle.
        theta = np.radians(degrees)
        expected = reflectance(theta, eta)
        measured = np.array([_reflected(angle, eta, count) for angle in theta])
        step, slack = 0.5 / count, _by_rounding(theta, eta)
        basis = f"{count} numbers, float32"
        below = expected < 1.0
        for what, law, found in (
            ("reflectance", expected, measured),
            ("transmittance", 1.0 - expected[below], 1.0 - measured[below]),
        ):
            slack_here = slack if what == "reflectance" else slack[below]
            limit = 100.0 * (step + slack_here) / law
            name = f"Fresnel: {what}, {side}, 0-89 deg"
            checks.append(worst(name, law, found, limit, basis, relative=True, bound=FRESNEL_BOUND))
    return checks


def refracted_share() -> list[Check]:
    """Measure what the refracted trace says of light through both faces of a slab at 0 to 89 degrees."""
    theta = np.radians(np.arange(90.0))
    kernel = loaded(interface(box((0, -0.2, -0.2), (0.02, 0.2, 0.2)), Medium(name="glass", eta=_N)))
    directions = np.stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)], 1)
    found = rows(refracted_rays(kernel, -0.05 * directions, directions).transmittance)[:, 0]
    through = 1.0 - reflectance(theta, _N)
    limit = 100.0 * (2.0 * _by_rounding(theta, _N) / through + ROUNDINGS * EPS)
    name = "Fresnel: transmittance of a slab, refracted ray, 0-89 deg"
    return [worst(name, through**2, found, limit, "float32", relative=True, bound=FRESNEL_BOUND)]


def critical_angle() -> list[Check]:
    """Find the angle at which reflection from inside the glass becomes total."""
    expected, spread, count = np.arcsin(1.0 / _N), 1e-4, 1 << 16
    theta = expected + np.linspace(-spread, spread, count)
    # The largest number below 1 is reflected only where nothing is let through, to within its distance from 1.
    passed = scattered(_incoming(theta), 1.0 / _N, 0.0, np.full(count, 1.0 - EPS)).transmitted
    found = theta[np.flatnonzero(passed)[-1]] if passed.any() else theta[0]
    # Let through is 4 k cos_t / (...), about 4 n cos_t near the angle and below EPS only within a hair of it; the
    # squared sine rounds by EPS a step and changes by sin(2 theta) a radian.
    limit = ROUNDINGS * EPS / np.sin(2.0 * expected) + 2.0 * spread / count
    return [_degrees("Critical angle, glass to air", expected, found, limit)]


def brewster_angle() -> list[Check]:
    """Measure at Brewster's angle that the mirrored and the refracted ray are perpendicular, and the reflectance."""
    theta, count = np.arctan(_N), 1 << 20
    wi = np.repeat(_incoming(np.array([theta])), 2, 0)
    pair = scattered(wi, _N, 0.0, np.array([0.0, 1.0 - EPS])).direction
    between = np.arccos(pair[0] @ pair[1])
    expected = 0.5 * ((_N**2 - 1.0) / (_N**2 + 1.0)) ** 2  # what is left is perpendicular to the plane alone
    limit = 100.0 * (0.5 / count + _by_rounding(np.array([theta]), _N)[0]) / expected
    return [
        _degrees(
            "Brewster's angle: between mirrored and refracted ray", np.pi / 2, between, ROUNDINGS * EPS / np.cos(theta)
        ),
        worst(
            "Brewster's angle: reflectance",
            expected,
            _reflected(theta, _N, count),
            limit,
            f"{count} numbers, float32",
            relative=True,
            bound=FRESNEL_BOUND,
        ),
    ]


def _incoming(theta: np.ndarray) -> np.ndarray:
    return np.stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)], 1)


def _reflected(theta: float, eta: float, count: int) -> float:
    u_lobe = (np.arange(count) + 0.5) / count
    wi = np.broadcast_to(_incoming(np.array([theta])), (count, 3))
    return float((~scattered(wi, eta, 0.0, u_lobe).transmitted).mean())


def _by_rounding(theta: np.ndarray, eta: float) -> np.ndarray:
    """How far the reflectance moves when cosine and index round, each time the same way."""
    slack = ROUNDINGS * EPS
    cos = np.cos(theta)
    near = [reflectance(np.arccos(np.clip(cos + sign * slack, 0.0, 1.0)), eta) for sign in (-1.0, 1.0)]
    near += [reflectance(theta, eta * (1.0 + sign * slack)) for sign in (-1.0, 1.0)]
    return np.abs(np.array(near) - reflectance(theta, eta)).sum(0) + slack


def _degrees(name: str, expected: float, measured: float, limit: float) -> Check:
    basis = f"{ROUNDINGS} float32 roundings"
    return worst(name, np.degrees(expected), np.degrees(measured), np.degrees(limit), basis, unit="deg", bound=0.01)
