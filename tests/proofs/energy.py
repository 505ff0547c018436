"""Energy: absorption, white furnaces, and radiance in a denser medium."""

from __future__ import annotations

from typing import Any

import numpy as np

from glassware.procedural.optics.medium import AIR, Medium
from glassware.render.scene.loaded_scene import LoadedScene

from .bodies import ball, both, box, shell
from .bundles import refracted_rays, rows, traced
from .check import EPS, ROUNDINGS, Check, mean_check, worst
from .fresnel import reflectance
from .loading import interface, loaded

#: What the project promises [%].
ABSORPTION_BOUND, FURNACE_BOUND = 0.2, 0.2
_GLASS, _WATER = Medium(name="glass", eta=1.52), Medium(name="water", eta=1.333)
#: Settings of a picture whose paths end only where light does.
_TO_THE_END: dict[str, Any] = {"max_depth": 1024, "rr_depth": 1024}
#: Absorption of the slab, in three colours [1/m]: 5 cm let 90, 37 and 13 % pass.
_SIGMA = (2.0, 20.0, 40.0)


def beer_lambert(paths: int, lengths: tuple[float, ...] = (0.01, 0.02, 0.05)) -> list[Check]:
    """Send light through slabs of an absorbing medium.

    The refracted trace has Fresnel's losses at both faces; the path tracer in a white furnace sees what a slab lets
    through and mirrors, all orders of reflection inside added up.

    Parameters
    ----------
    paths : int
        Paths of each slab.
    lengths : tuple of float
        Thicknesses [m].
    """
    return [check for length in lengths for check in _dimmed_by(length, paths)]


def _dimmed_by(length: float, paths: int) -> list[Check]:
    ink = Medium(name="ink", eta=_WATER.eta, sigma_a=_SIGMA)
    kernel = loaded(interface(box((0, -0.2, -0.2), (length, 0.2, 0.2)), ink))
    dimmed = np.exp(-np.array(_SIGMA) * length)
    R = reflectance(np.zeros(1), ink.eta)[0]
    direct = rows(refracted_rays(kernel, np.array([-0.1, 0.01, 0.02]), np.array([[1.0, 0.0, 0.0]])).transmittance)[0]
    # The length is off by two start offsets and rounding.
    off = np.array(_SIGMA) * 2.0 * kernel.offset + 2 * ROUNDINGS * EPS
    name = f"Beer-Lambert: {length * 100:g} cm"
    law = (1.0 - R) ** 2 * dimmed
    straight = worst(name, law, direct, 100.0 * off, "float32, start offset", relative=True, bound=ABSORPTION_BOUND)
    # Stokes 1862, "On the intensity of the light reflected from or transmitted through a pile of plates".
    through = (1.0 - R) ** 2 * dimmed / (1.0 - (R * dimmed) ** 2)
    mirrored = R * (1.0 + dimmed * through)
    origins = np.broadcast_to([-0.1, 0.01, 0.02], (paths, 3))
    radiance = traced(kernel, origins, np.broadcast_to([1.0, 0.0, 0.0], (paths, 3))).radiance
    return [straight] + [
        mean_check(f"{name}, path tracer, {colour}", (through + mirrored)[i], radiance[:, i], off[i], ABSORPTION_BOUND)
        for i, colour in enumerate(("red", "green", "blue"))
    ]


def furnace(paths: int, alphas: tuple[float, ...] = (0.0, 0.05, 0.2, 0.5)) -> list[Check]:
    """Look at a hollow ball of clear glass, empty and full of water, in a white furnace: it must be invisible.

    Paths are followed to their end, without roulette: what is lost, the interfaces lose.
    `vessels.default_furnace` has roulette and the longest path of a picture.

    Parameters
    ----------
    paths : int
        Paths at each ball.
    alphas : tuple of float
        GGX roughness of the glass, inside and outside.
    """
    outer, inner = shell(0.05, 0.046)
    checks = []
    for alpha in alphas:
        empty = [interface(both(outer, inner), _GLASS, roughness=alpha)]
        filled = [
            interface(outer, _GLASS, roughness=alpha),
            interface(inner, _GLASS, _WATER, roughness=alpha, part="wet_wall"),
        ]
        what = f"rough {alpha:g}" if alpha > 0.0 else "smooth"
        for state, surfaces in (("empty", empty), ("filled", filled)):
            # Loaded for the call alone: kernels are compiled anew where another scene is in memory.
            checks.append(_white(f"White furnace: {what} glass, {state}", loaded(*surfaces, **_TO_THE_END), paths))
    return checks


def _white(name: str, kernel: LoadedScene, paths: int) -> Check:
    """Look at a ball of 5 cm about the origin from many places at once: paths over its whole disc."""
    spin, share = _golden(paths)
    y, z = 0.0499 * np.sqrt(share) * np.cos(spin), 0.0499 * np.sqrt(share) * np.sin(spin)
    origins = np.stack([np.full(paths, -0.2), y, z], 1)
    found = traced(kernel, origins, np.broadcast_to([1.0, 0.0, 0.0], (paths, 3)))
    # Each event rounds the weight of a path a few times; long paths are few.
    rounding = ROUNDINGS * EPS * found.segments.mean()
    return mean_check(name, 1.0, found.radiance[:, 0], rounding, FURNACE_BOUND)


def _golden(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Angles [rad] and shares of a spiral that covers a disc evenly (Vogel 1979)."""
    index = np.arange(count)
    return index * np.pi * (3.0 - np.sqrt(5.0)), (index + 0.5) / count


def radiance_inside(paths: int, alpha: float = 0.0) -> list[Check]:
    """Look from inside a ball of glass into a white furnace: radiance there is n^2 (Nicodemus 1963).

    Parameters
    ----------
    paths : int
        Number of directions.
    alpha : float
        GGX roughness of the ball.
    """
    kernel = loaded(interface(ball(0.05, 5), _GLASS, AIR, roughness=alpha))
    spin, share = _golden(paths)
    z = 1.0 - 2.0 * share
    directions = np.stack([np.sqrt(1 - z**2) * np.cos(spin), np.sqrt(1 - z**2) * np.sin(spin), z], 1)
    # Half-way out no smooth ray is caught for ever: it meets the surface below the critical angle of 41 degrees.
    found = traced(kernel, np.array([0.025, 0.0, 0.0]), directions)
    rounding = ROUNDINGS * EPS * found.segments.mean()
    name = f"Radiance inside {'rough ' + format(alpha, 'g') if alpha else 'smooth'} glass: n^2"
    return [mean_check(name, _GLASS.eta**2, found.radiance[:, 0], rounding, FURNACE_BOUND)]
