"""Derivatives of the refracted ray against closed forms and central differences."""

from __future__ import annotations

from collections.abc import Callable

import drjit as dr
import mitsuba as mi
import numpy as np

from glassware.procedural.optics.medium import Medium
from glassware.render.labels.refraction import refract
from glassware.render.scene.loaded_scene import LoadedScene

from .bodies import ball, box
from .bundles import bundle
from .check import EPS, ROUNDINGS, Check, worst
from .loading import interface, loaded, screen

#: What the project promises [%].
DERIVATIVE_BOUND = 1.0
_GLASS = Medium(name="glass", eta=1.52, sigma_a=(2.0, 20.0, 40.0))
_THICK, _GAP = 0.02, 0.03
_ANGLES = np.radians([5.0, 15.0, 30.0, 45.0, 60.0, 70.0])


def slab() -> list[Check]:
    """Differentiate where rays land behind a slab by index and eye, and their dimming by absorption."""
    kernel = loaded(
        interface(box((0, -0.2, -0.2), (_THICK, 0.2, 0.2)), _GLASS),
        props=[screen((_THICK + _GAP, -0.3, -0.2), (_THICK + _GAP + 0.01, 0.3, 0.2))],
    )
    theta, n = _ANGLES, _GLASS.eta
    directions = np.stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)], 1)
    origins = -0.05 * directions
    sin_t = np.sin(theta) / n
    cos_t = np.sqrt(1.0 - sin_t**2)

    def landing(eta: mi.Float | None = None, shift: mi.Float | None = None) -> mi.Float:
        ray = bundle(origins, directions)
        if shift is not None:
            ray.o = ray.o + shift * mi.Vector3f(1.0, 0.0, 0.0)
        return refract(kernel, ray, eta=_index(kernel, eta), derivatives=True).point.y

    # y = d tan(theta_t) + ...: d tan / d theta_t = 1 / cos^2 and d theta_t / d n = -tan(theta_t) / n.
    by_index = -_THICK * sin_t / (n * cos_t**3)
    by_place = -np.tan(theta)  # an eye that comes nearer by one lands lower by the tangent
    limit = 100.0 * (2 * ROUNDINGS * EPS / np.cos(theta) ** 2 + _start(kernel) / np.cos(theta) ** 2)
    basis = "float32, start offset over the slab's thickness"
    checks = [
        worst(
            "Derivative of a slab's landing point by the index",
            by_index,
            _forward(lambda x: landing(eta=x), n),
            limit,
            basis,
            relative=True,
            bound=DERIVATIVE_BOUND,
        ),
        worst(
            "Derivative of a slab's landing point by the eye's place",
            by_place,
            _forward(lambda x: landing(shift=x), 0.0),
            limit,
            basis,
            relative=True,
            bound=DERIVATIVE_BOUND,
        ),
    ]

    def dimmed(sigma: mi.Float) -> mi.Float:
        table = mi.Float(kernel.surfaces.sigma_a_rgb)
        glass = 3 * kernel.surfaces.media.index(_GLASS)
        dr.scatter(table, sigma, mi.UInt32(glass))
        return dr.log(refract(kernel, bundle(origins, directions), sigma_a=table, derivatives=True).transmittance.x)

    law = -_THICK / cos_t
    checks.append(
        worst(
            "Derivative of a slab's log transmittance by its absorption",
            law,
            _forward(dimmed, _GLASS.sigma_a[0]),
            limit,
            basis,
            relative=True,
            bound=DERIVATIVE_BOUND,
        )
    )
    return checks


def ball_by_differences(heights: int = 24) -> list[Check]:
    """Differentiate where rays land behind a ball, by its index and by moving it: against central differences.

    Both are smooth functions of one number with the same rays: nothing is random, so what is common is everything.

    Parameters
    ----------
    heights : int
        Number of rays, off the axis by up to half the radius.
    """
    radius, subdivisions = 0.04, 6
    kernel = loaded(interface(ball(radius, subdivisions), _GLASS), props=[screen((0.1, -0.2, -0.2), (0.11, 0.2, 0.2))])
    height = radius * np.linspace(0.2, 0.5, heights)
    origins = np.stack([np.full(heights, -0.1), height, 0.3 * height], 1)
    directions = np.broadcast_to([1.0, 0.0, 0.0], origins.shape)

    def landing(eta: mi.Float) -> mi.Float:
        return refract(kernel, bundle(origins, directions), eta=_index(kernel, eta), derivatives=True).point.y

    moved = _mover(kernel)

    def landing_moved(shift: mi.Float) -> mi.Float:
        moved(shift)
        return refract(kernel, bundle(origins, directions), derivatives=True).point.y

    # A step may cross the edge between two facets, the derivative does not. Facets lean against the sphere by at most
    # this angle: where a hit moves along a facet it leaves the sphere by it. That shifts the ray by the tangent of its
    # turn, and turns it by the changed normal, over the distance to the screen.
    lean, n = 1.11 * 2.0**-subdivisions / np.sqrt(3.0), _GLASS.eta
    sin_i = height * np.sqrt(1.09) / radius  # rays lie 0.3 of their height aside
    turn = np.arcsin(sin_i) - np.arcsin(sin_i / n)
    a_metre = lean * (np.tan(turn) + (n - 1.0) * sin_i * 0.1 / radius)
    # How far hits move by one of the parameter: by the index only the second one, by the place both, the second twice.
    moves = {"index": 2.0 * radius * sin_i / n**2, "place of its vertices": 3.0}

    checks = []
    for what, function, at, h in (
        ("index", landing, _GLASS.eta, 4e-3),
        ("place of its vertices", landing_moved, 0.0, 1e-3 * radius),
    ):
        ours = _forward(function, at)
        law = _central(function, at, h)
        half = _central(function, at, 0.5 * h)
        # The difference's own error: rounding of the landing points over the step, and its third-order term, which
        # falls to a quarter with half the step.
        own = a_metre * moves[what] + 2.0 * EPS * ROUNDINGS * 0.1 / h + 4.0 / 3.0 * np.abs(law - half)
        limit = 100.0 * (own / np.abs(law) + 4 * ROUNDINGS * EPS)
        name = f"Derivative of a ball's landing point by the {what}"
        basis = "central difference: rounding, third order; facets"
        checks.append(worst(name, law, ours, limit, basis, relative=True, bound=DERIVATIVE_BOUND))
    moved(_number(0.0))
    return checks


def _start(kernel: LoadedScene) -> float:
    return 2.0 * kernel.offset / _THICK


def _index(kernel: LoadedScene, eta: mi.Float | None) -> mi.Float | None:
    """Return the column of indices with the glass's replaced."""
    if eta is None:
        return None
    table = mi.Float(kernel.surfaces.eta_d)
    dr.scatter(table, eta, mi.UInt32(kernel.surfaces.media.index(_GLASS)))
    return table


def _mover(kernel: LoadedScene) -> Callable[[mi.Float], None]:
    """Return a function that shifts the glass along y by a number that may carry derivatives."""
    parameters = mi.traverse(kernel.mi_scene)
    names = [name for name in parameters.keys() if name.endswith("vertex_positions")]  # noqa: SIM118
    counts = {name: dr.width(parameters[name]) for name in names}
    key = max(counts, key=counts.__getitem__)  # the ball has by far the most vertices
    start = dr.unravel(mi.Point3f, mi.Float(parameters[key]))

    def move(shift: mi.Float) -> None:
        parameters[key] = dr.ravel(start + shift * mi.Vector3f(0.0, 1.0, 0.0))
        parameters.update()

    return move


def _number(value: float) -> mi.Float:
    """Return a number that is not compiled into the kernel: both sides of a difference then use the same one."""
    return dr.opaque(mi.Float, value)


def _forward(function: Callable[[mi.Float], mi.Float], at: float) -> np.ndarray:
    x = _number(at)
    dr.enable_grad(x)
    y = function(x)
    dr.set_grad(x, 1.0)
    dr.enqueue(dr.ADMode.Forward, x)
    dr.traverse(dr.ADMode.Forward)
    return np.array(dr.grad(y), np.float64)


def _central(function: Callable[[mi.Float], mi.Float], at: float, h: float) -> np.ndarray:
    high, low = (np.array(dr.detach(function(_number(at + sign * h))), np.float64) for sign in (1.0, -1.0))
    # The step is what float32 makes of it.
    return (high - low) / (float(np.float32(at + h)) - float(np.float32(at - h)))
