"""The transmittance of `geometry.exr`: what the straight ray to the background passes, without bending."""

from __future__ import annotations

from itertools import pairwise

import drjit as dr
import numpy as np

from glassware.procedural.optics.medium import Medium
from glassware.render.labels.geometry import straight_hits
from glassware.render.scene.loaded_scene import LoadedScene

from .bodies import ball, box
from .bundles import bundle, rows
from .check import EPS, ROUNDINGS, Check, worst
from .fresnel import reflectance
from .loading import interface, loaded

#: What the project promises [%].
BOUND = 0.1
#: Absorption in three colours [1/m] of a green and of a bronze glass, strong enough to see the length of the path.
_GREEN = Medium(name="green glass", eta=1.52, sigma_a=(120.0, 20.0, 60.0))
_BRONZE = Medium(name="bronze glass", eta=1.52, sigma_a=(60.0, 90.0, 200.0))
_CLEAR, _WATER = Medium(name="clear glass", eta=1.52), Medium(name="water", eta=1.333, sigma_a=(2.0, 0.5, 0.2))
#: Layers of each wall: medium and thickness [m].
WALLS = {
    "green glass, 3 mm": ((_GREEN, 0.003),),
    "bronze glass, 4 mm": ((_BRONZE, 0.004),),
    "glass, water, glass": ((_CLEAR, 0.003), (_WATER, 0.03), (_CLEAR, 0.003)),
}


def walls(theta: np.ndarray) -> list[Check]:
    """Send straight rays through walls with parallel faces at angles [rad] to the normal."""
    return [_wall_check(theta, name) for name in WALLS]


def _wall_check(theta: np.ndarray, name: str) -> Check:
    layers = WALLS[name]
    kernel = _wall(layers)
    directions = np.stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)], axis=1)
    found = _straight(kernel, -0.05 * directions, directions)
    expected, slack = _through_layers(theta, layers, kernel.offset)
    title = f"Straight transmittance, {name}, 0-{np.degrees(theta.max()):.0f} deg"
    return worst(title, expected, found, 100.0 * slack, "float32, start offset", relative=True, bound=BOUND)


def absorbing_ball(subdivisions: int = 6) -> list[Check]:
    """Send straight rays through a ball of coloured glass: the refracted path is a chord at the refracted angle."""
    radius, theta = 0.01, np.radians(np.arange(0.0, 66.0, 5.0))
    kernel = loaded(interface(ball(radius, subdivisions), _GREEN))
    height = radius * np.sin(theta)
    origins = np.stack([np.full_like(height, -0.05), height * np.cos(1.0), height * np.sin(1.0)], axis=1)
    found = _straight(kernel, origins, np.broadcast_to([1.0, 0.0, 0.0], origins.shape))
    inside = np.sqrt(1.0 - (np.sin(theta) / _GREEN.eta) ** 2)
    optical_depth = 2.0 * radius * inside[:, None] * np.array(_GREEN.sigma_a)
    through = (1.0 - reflectance(theta, _GREEN.eta)) ** 2
    # A facet lies under the sphere by edge^2 / 6 at its middle; an angle is off by that over the cosine, at both ends.
    sagitta = (1.11 * 2.0**-subdivisions) ** 2 / 6.0
    angle = 2.0 * sagitta * np.tan(theta) / np.cos(theta)
    by_angle = 2.0 * np.abs(_log_slope(theta, _GREEN.eta)) * angle
    slack = optical_depth * (2.0 * sagitta + angle * np.tan(theta))[:, None] + by_angle[:, None] + _ROUNDING
    expected = through[:, None] * np.exp(-optical_depth)
    name = "Straight transmittance, ball of green glass, 0-65 deg"
    return [worst(name, expected, found, 100.0 * slack, "facets, float32", relative=True)]


_ROUNDING = 4 * ROUNDINGS * EPS


def _wall(layers: tuple[tuple[Medium, float], ...]) -> LoadedScene:
    """Return nested boxes: the outermost layers are one medium, as the two walls of a vessel are."""
    total, half = sum(thickness for _, thickness in layers), 2.0
    surfaces = [interface(box((0.0, -half, -half), (total, half, half)), layers[0][0])]
    if len(layers) == 3:
        first, (water, depth) = layers[0][1], layers[1]
        inner = box((first, 0.1 - half, 0.1 - half), (first + depth, half - 0.1, half - 0.1), "inner")
        surfaces.append(interface(inner, water, front=layers[0][0]))
    return loaded(*surfaces)


def _straight(kernel: LoadedScene, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    hits = straight_hits(kernel, bundle(origins, directions))
    dr.eval(hits)
    return rows(hits.transmittance)


def _through_layers(
    theta: np.ndarray, layers: tuple[tuple[Medium, float], ...], offset: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the transmittance by Fresnel, Snell, Beer and Lambert in float64, and its relative slack, (n, 3) each."""
    index = [1.0, *(medium.eta for medium, _ in layers), 1.0]
    angle = [np.arcsin(np.sin(theta) / n) for n in index]
    passed = np.ones((len(theta), 3))
    slack = np.full((len(theta), 3), _ROUNDING)
    for i, (before, behind) in enumerate(pairwise(index)):
        passed *= (1.0 - reflectance(angle[i], behind / before))[:, None]
        # The cosine of the straight ray rounds, which is an angle of that over its sine.
        slack += (np.abs(_log_slope(theta, behind / before)) * ROUNDINGS * EPS)[:, None]
    for (medium, thickness), inside in zip(layers, angle[1:-1], strict=True):
        sigma = np.array(medium.sigma_a)
        passed *= np.exp(-sigma * (thickness / np.cos(inside))[:, None])
        lost = offset + ROUNDINGS * EPS * thickness
        slack += sigma * (lost / np.cos(inside))[:, None]
    return passed, slack


def _log_slope(theta: np.ndarray, eta: float) -> np.ndarray:
    """Return an upper bound of d log T / d theta of an interface by the straight angle: T falls as the cosine."""
    return 1.0 / np.maximum(np.cos(theta), 1e-3) * max(eta, 1.0 / eta)
