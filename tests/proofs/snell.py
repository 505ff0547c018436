"""Snell's law: slabs, prisms, and water seen from above."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import mitsuba as mi
import numpy as np

from glassware.procedural.optics.catalogue import catalogue
from glassware.procedural.optics.dispersion import C_LINE, D_LINE, F_LINE
from glassware.procedural.optics.medium import Medium, eta
from glassware.render.backend.variant import activate
from glassware.render.scene.loaded_scene import LoadedScene

from .bodies import box, prism
from .bundles import refracted_rays, rows, traced
from .check import EPS, ROUNDINGS, Check, worst
from .loading import interface, loaded, screen

#: What the project promises of directions [deg], for one index and along the spectrum.
ANGLE_BOUND, DISPERSION_BOUND = 0.01, 0.02
_GLASS = Medium(name="glass", eta=1.52)
#: Half the length of the screen behind the slab [m]: what meets it at 86 degrees is 0.5 m aside.
_REACH = 0.5
_APEX = np.radians(60.0)
#: Columns of the map that tells directions by their radiance: 1 in the first, 2 in the last.
_COLUMNS = 64
_DEG = 180.0 / np.pi


def slab(angles_deg: np.ndarray) -> list[Check]:
    """Send rays through a slab of 20 mm: the direction behind it, inside it, and the shift on a screen.

    Parameters
    ----------
    angles_deg : (n,) float
        Angles of incidence [deg], below 89.
    """
    thick, theta = 0.02, np.radians(angles_deg)
    body = interface(box((0, -0.2, -0.2), (thick, 0.2, 0.2)), _GLASS)
    origins, directions = _towards(np.zeros(3), theta)
    behind = loaded(body, props=[screen((0.05, -_REACH, -0.2), (0.06, _REACH, 0.2))])
    through = refracted_rays(behind, origins, directions)
    inside = loaded(body, props=[screen((0.01, -0.1, -0.1), (0.015, 0.1, 0.1))])
    within = refracted_rays(inside, origins, directions)

    theta_t = np.arcsin(np.sin(theta) / _GLASS.eta)
    shift = thick * np.tan(theta_t) + 0.03 * np.tan(theta)
    rounding = ROUNDINGS * EPS / np.cos(theta) * _DEG
    # Rays start off both faces by the offset, along the normal; points round by the scene's size, and what they are off
    # across the ray, or turned, is longer on the screen by 1/cos each.
    start = behind.offset * (np.tan(theta) + np.tan(theta_t)) + ROUNDINGS * EPS * _REACH / np.cos(theta)
    start += 2 * ROUNDINGS * EPS / np.cos(theta) * 0.05 / np.cos(theta) ** 2
    basis = f"{ROUNDINGS} float32 roundings an interface, magnified by 1/cos"
    return [
        worst(
            "Snell: direction inside a slab",
            theta_t * _DEG,
            _azimuth(within.direction),
            rounding,
            basis,
            unit="deg",
            bound=ANGLE_BOUND,
        ),
        worst(
            "Snell: direction behind a slab",
            angles_deg,
            _azimuth(through.direction),
            2 * rounding,
            basis,
            unit="deg",
            bound=ANGLE_BOUND,
        ),
        worst(
            "Snell: landing point behind a slab",
            shift * 1e3,
            rows(through.point)[:, 1] * 1e3,
            start * 1e3,
            "start offset 2^-20 of the scene, float32",
            unit="mm",
        ),
    ]


def prism_angles(angles_deg: np.ndarray) -> list[Check]:
    """Send rays through a prism of 60 degrees: by the refracted trace, and by the path tracer.

    Parameters
    ----------
    angles_deg : (n,) float
        Angles of incidence on the first face [deg].
    """
    theta = np.radians(angles_deg)
    body = interface(prism(_APEX, 0.05, 0.1), _GLASS)
    origins, directions = _at_prism(theta)
    kernel = loaded(body, environment=_ramp())
    exits = _azimuth(refracted_rays(kernel, origins, directions).direction)
    expected, limit = _behind_prism(theta, np.asarray(_GLASS.eta))
    basis = f"{ROUNDINGS} float32 roundings an interface, magnified by 1/cos"
    path_limit = limit + _RAMP_LIMIT
    return [
        worst("Snell: direction behind a prism", expected, exits, limit, basis, unit="deg", bound=ANGLE_BOUND),
        worst(
            "Snell: the same, by the path tracer",
            expected,
            _by_radiance(kernel, origins, directions, expected, None),
            path_limit,
            basis + ", and of the radiance that tells it",
            unit="deg",
            bound=ANGLE_BOUND,
        ),
    ]


def dispersed_prism(lines_nm: tuple[float, ...] = (C_LINE, D_LINE, F_LINE)) -> list[Check]:
    """Send paths of single wavelengths through a prism of lead crystal in the spectral variant.

    Parameters
    ----------
    lines_nm : tuple of float
        The wavelengths [nm].
    """
    crystal = catalogue()["lead crystal"].model_copy(update={"sigma_a": (0.0, 0.0, 0.0), "absorbers": ()})
    theta = np.radians([45.0, 50.0, 55.0])
    checks = []
    with variant("llvm_ad_spectral" if mi.variant().startswith("llvm") else "cuda_ad_spectral"):
        kernel = loaded(
            interface(prism(_APEX, 0.05, 0.1), crystal), environment=_ramp(), spectral=True, dispersion=True
        )
        for nm in lines_nm:
            origins, directions = _at_prism(theta)
            expected, limit = _behind_prism(theta, eta(crystal, nm))
            found = _by_radiance(kernel, origins, directions, expected, nm)
            limit = limit + _RAMP_LIMIT + _table_limit(crystal, nm)
            basis = "float32, and linear interpolation of the index on a grid of 5 nm"
            name = f"Dispersion: direction behind a prism at {nm:.1f} nm"
            checks.append(worst(name, expected, found, limit, basis, unit="deg", bound=DISPERSION_BOUND))
    return checks


def apparent_depth(angles_deg: np.ndarray) -> list[Check]:
    """Look at a plane 50 mm under water from above: how deep it seems, straight down and at an angle.

    Parameters
    ----------
    angles_deg : (n,) float
        Angles between the line of sight and the vertical [deg], not 0.
    """
    water, depth = catalogue()["water"], 0.05
    basin = interface(box((-0.2, -0.2, -0.1), (0.2, 0.2, 0.0)), water)
    kernel = loaded(basin, props=[screen((-0.19, -0.19, -0.09), (0.19, 0.19, -depth))])
    theta = np.radians(angles_deg)
    directions = np.stack([np.sin(theta), np.zeros_like(theta), -np.cos(theta)], 1)
    end = refracted_rays(kernel, -0.1 * directions, directions)
    seen = rows(end.point)[:, 0] / np.tan(theta)
    theta_t = np.arcsin(np.sin(theta) / water.eta)
    expected = depth * np.tan(theta_t) / np.tan(theta)
    # The same roundings of direction, over the tangent that the depth is divided by.
    limit = (kernel.offset * np.tan(theta_t) + depth * 2 * ROUNDINGS * EPS / np.cos(theta) ** 2) / np.tan(theta)
    limit = 100.0 * limit / expected
    return [
        worst(
            f"Apparent depth under water at {angle:g} deg",
            expected[i] * 1e3,
            seen[i] * 1e3,
            limit[i],
            "float32, start offset",
            unit="mm",
            relative=True,
        )
        for i, angle in enumerate(angles_deg)
    ]


@contextmanager
def variant(name: str) -> Iterator[None]:
    """Use another variant of the renderer for a while."""
    before = mi.variant()
    activate(name)
    try:
        yield
    finally:
        activate(before)


def _towards(point: np.ndarray, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rays in the x-y plane through a point, rising by theta from +x."""
    directions = np.stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)], 1)
    return point - 0.05 * directions, directions


def _at_prism(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    # The left face looks along pi - apex / 2; rays come from below its normal, so that they bend towards the base.
    return _towards(np.array([-0.5 * 0.05 * np.sin(_APEX / 2), 0.0, 0.0]), theta - _APEX / 2)


def _behind_prism(theta: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Azimuth behind the prism, and how far rounding may move it [deg] (Born and Wolf, sec. 4.7.2)."""
    inner = _APEX - np.arcsin(np.sin(theta) / n)
    out = np.arcsin(n * np.sin(inner))
    rounding = ROUNDINGS * EPS * (1.0 / np.cos(theta) + n * np.cos(inner) / np.cos(out) + 1.0 / np.cos(out))
    return (_APEX / 2 - out) * _DEG, rounding * _DEG


def _azimuth(directions: mi.Vector3f) -> np.ndarray:
    x, y, _ = rows(directions).T
    return np.arctan2(y, x) * _DEG


def _ramp() -> np.ndarray:
    """Return a map whose radiance grows evenly from column to column."""
    columns = np.roll(np.linspace(1.0, 2.0, _COLUMNS), _COLUMNS // 2)  # the jump back from 2 to 1 lies at -x
    return np.broadcast_to(columns[None, :, None], (_COLUMNS // 2, _COLUMNS, 3))


#: Radiance between 1 and 2 tells 360 degrees. Map, interpolation weights and weight of the path round it.
_RAMP_LIMIT = 2.0 * ROUNDINGS * EPS * 360.0


def _by_radiance(
    kernel: LoadedScene, origins: np.ndarray, directions: np.ndarray, expected: np.ndarray, nm: float | None
) -> np.ndarray:
    """Return the azimuths [deg] in which paths leave a body: what they bring back says from where.

    Two straight rays beside the body say which radiance belongs to which azimuth. Paths that a coin mirrored have
    another number of segments and are left out.
    """
    tries = 64  # the chance that one is mirrored at either face is below 1/2
    step = 5.0
    marks = np.radians([expected.min() - step, expected.max() + step])
    aside = np.stack([np.cos(marks), np.sin(marks), np.zeros(2)], 1)
    o = np.concatenate([np.repeat(origins, tries, 0), np.full((2, 3), 0.2)])
    d = np.concatenate([np.repeat(directions, tries, 0), aside])
    paths = traced(kernel, o, d, nm=None if nm is None else np.full(len(d), nm))
    channel = np.abs(paths.radiance[-1]).argmax()
    low, high = paths.radiance[-2:, channel]
    values = paths.radiance[:-2, channel].reshape(len(origins), tries)
    straight = (paths.segments[:-2] == 3).reshape(len(origins), tries)
    first = np.take_along_axis(values, straight.argmax(1)[:, None], 1)[:, 0]
    if not straight.any(1).all():
        raise ValueError("expected a path straight through at every angle, found an angle without one")
    share = (first - low) / (high - low)
    return (marks[0] + share * (marks[1] - marks[0])) * _DEG


def _table_limit(medium: Medium, nm: float) -> float:
    """How far interpolating the index on a grid of 5 nm may turn the ray behind the prism [deg].

    The error of linear interpolation is at most h^2 / 8 of the second derivative; a change of index turns the ray by
    at most three times as much near the angles used (sin of the apex over both cosines).
    """
    step = 5.0
    curvature = abs(np.diff(eta(medium, nm + step * np.array([-1.0, 0.0, 1.0])), 2)[0])
    return 3.0 * 1.1 * curvature / 8.0 * _DEG
