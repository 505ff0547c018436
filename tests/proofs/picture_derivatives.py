"""Derivatives of what paths bring back: by absorption, light and roughness, against closed forms and differences."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from scipy import stats

from glassware.procedural.optics.medium import Medium
from glassware.render.derivatives.gradients import with_parameters
from glassware.render.derivatives.replay import Slots, empty_tape, replay, slots_of
from glassware.render.pictures.integrator import trace
from glassware.render.pictures.sampler import sobol_sampler
from glassware.render.scene.loaded_scene import LoadedScene

from .bodies import box
from .bundles import bundle
from .check import EPS, FALSE_ALARM, ROUNDINGS, Check, mean_check, worst
from .derivatives import DERIVATIVE_BOUND
from .fresnel import reflectance
from .loading import interface, loaded

_SIGMA, _ETA, _THICK, _ALPHA = (2.0, 20.0, 40.0), 1.5, 0.05, 0.2
_TO_THE_END: dict[str, Any] = {"max_depth": 64, "rr_depth": 64}
#: Paths traced at a time: each writes 3 numbers for every parameter.
_BATCH = 1_000_000


@dataclass(frozen=True, eq=False)
class _Walked:
    """Radiance (n, 3) of paths, and the derivatives (n, 3) by each parameter."""

    radiance: np.ndarray
    by: np.ndarray  #: (slots, n, 3)
    where: Slots


def absorption(paths: int, angles: tuple[float, ...] = (0.0, 40.0)) -> list[Check]:
    """Differentiate the light through and off an absorbing slab in a white furnace by its absorption.

    With a = exp(-sigma d / cos t) for one crossing and R of one face, the slab shows R + (1 - R)^2 a / (1 - R a): all
    orders of reflection (Stokes 1862), light from behind and from before.

    Parameters
    ----------
    paths : int
        Paths at each angle.
    angles : tuple of float
        Angles of incidence [deg].
    """
    ink = Medium(name="ink", eta=_ETA, sigma_a=_SIGMA)
    kernel = loaded(interface(box((0, -1.0, -1.0), (_THICK, 1.0, 1.0)), ink), **_TO_THE_END)
    checks = []
    for angle in np.radians(angles):
        direction = np.array([np.cos(angle), np.sin(angle), 0.0])
        walked = _walked(kernel, -0.05 * direction, direction, paths)
        length = _THICK / np.sqrt(1.0 - (np.sin(angle) / _ETA) ** 2)
        R, a = reflectance(np.array([angle]), _ETA)[0], np.exp(-np.array(_SIGMA) * length)
        law = -length * a * (1.0 - R) ** 2 / (1.0 - R * a) ** 2
        found = walked.by[kernel.surfaces.media.index(ink)]
        # The length is off by two start offsets, and enters twice.
        off = (1.0 + np.array(_SIGMA) * length) * 2.0 * kernel.offset / _THICK + 2 * ROUNDINGS * EPS
        name = f"Derivative of a slab's light by its absorption, {np.degrees(angle):.0f} deg"
        checks += [
            mean_check(f"{name}, {colour}", law[i], found[:, i], off[i], DERIVATIVE_BOUND)
            for i, colour in enumerate(("red", "green", "blue"))
        ]
    return checks


def light(paths: int) -> list[Check]:
    """Differentiate the same light by the strength of the surroundings: radiance is linear in it."""
    ink = Medium(name="ink", eta=_ETA, sigma_a=_SIGMA)
    kernel = loaded(interface(box((0, -1.0, -1.0), (_THICK, 1.0, 1.0)), ink), **_TO_THE_END)
    walked = _walked(kernel, np.array([-0.05, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]), paths)
    R, a = reflectance(np.zeros(1), _ETA)[0], np.exp(-np.array(_SIGMA) * _THICK)
    law = R + (1.0 - R) ** 2 * a / (1.0 - R * a)
    found = walked.by[walked.where.first_light + walked.where.emitters.index("environment")]
    off = np.array(_SIGMA) * 2.0 * kernel.offset + 2 * ROUNDINGS * EPS
    name = "Derivative of a slab's light by its surroundings"
    return [
        mean_check(f"{name}, {colour}", law[i], found[:, i], off[i], DERIVATIVE_BOUND)
        for i, colour in enumerate(("red", "green", "blue"))
    ]


def roughness(paths: int) -> list[Check]:
    """Differentiate a soft light seen through rough glass by the roughness, against central differences.

    The differences take the same sample points on both sides (common random numbers).

    Parameters
    ----------
    paths : int
        Paths of the derivative, and of each side of the difference.
    """
    glass = Medium(name="glass", eta=_ETA)
    slab = interface(box((0, -1.0, -1.0), (_THICK, 1.0, 1.0)), glass, roughness=_ALPHA)
    kernel = loaded(slab, environment=_soft_lights(), **_TO_THE_END)
    origin, direction = np.array([-0.05, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])
    rough = np.array(kernel.surfaces.alpha) > 0.0
    walked = _walked(kernel, origin, direction, paths)
    ours = walked.by[walked.where.media :][: len(walked.where.rough)].sum(0)[:, 0]
    # The difference leaves out (h / alpha)^2 / 6 of a derivative that changes over alpha itself.
    h = 0.1 * _ALPHA
    up, down = (
        _walked(with_parameters(kernel, alpha=np.where(rough, _ALPHA + step, 0.0)), origin, direction, paths).radiance[
            :, 0
        ]
        for step in (h, -h)
    )
    difference = (up - down) / (2.0 * h)
    noise = np.hypot(*(x.std(ddof=1) / np.sqrt(len(x)) for x in (ours, difference)))
    law = difference.mean()
    limit = stats.norm.isf(FALSE_ALARM / 2) * noise / abs(law) + 0.01 / 6.0
    basis = f"noise of {paths} paths on both sides, false alarm {FALSE_ALARM:g}; third order"
    name = "Derivative of a soft light behind rough glass by its roughness"
    return [worst(name, law, ours.mean(), 100.0 * limit, basis, relative=True, bound=DERIVATIVE_BOUND)]


def _soft_lights() -> np.ndarray:
    """Return a panorama with a soft light, 10 degrees wide, at every quarter turn: one lies behind the slab."""
    row, column = np.mgrid[:64, :128]
    elevation, azimuth = np.pi / 2 - np.pi * (row + 0.5) / 64, 2 * np.pi * (column + 0.5) / 128
    away = (np.mod(azimuth + np.pi / 4, np.pi / 2) - np.pi / 4) ** 2 + elevation**2
    return np.repeat((0.2 + np.exp(-away / (2 * 0.17**2)))[..., None], 3, axis=2)


def _walked(kernel: LoadedScene, origin: np.ndarray, direction: np.ndarray, paths: int) -> _Walked:
    """Walk many paths along one ray twice, as the product's derivatives do."""
    where, parts = slots_of(kernel), []
    for first in range(0, paths, _BATCH):
        count = min(_BATCH, paths - first)
        ray = bundle(origin, np.broadcast_to(direction, (count, 3)))
        # Each path is a pixel of its own: its numbers are independent of all others'.
        points = sobol_sampler(mi.UInt32(first) + dr.arange(mi.UInt32, count), dr.zeros(mi.UInt32, count), 1, 1)
        picture = kernel.description.picture
        once = trace(kernel, ray, mi.UnpolarizedSpectrum(1.0), points, picture).radiance
        dr.eval(once)
        # What a score weighs is what differs from a guess; the mean of all others is one.
        guess = mi.Color3f(*(dr.mean(channel) for channel in once))
        into = empty_tape(where, once, dr.repeat(guess, count) if dr.width(guess) == 1 else guess)
        again = replay(kernel, ray, points, picture, into)
        dr.eval(again, into.sums)
        sums = np.array(into.sums, np.float64).reshape(where.count, 3, count).transpose(0, 2, 1)
        parts.append((np.array(once, np.float64).T, sums))
    radiance, by = zip(*parts, strict=True)
    return _Walked(np.concatenate(radiance), np.concatenate(by, axis=1), where)
