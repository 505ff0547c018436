"""Lenses in the paraxial limit, and a glass of water seen from the side."""

from __future__ import annotations

import numpy as np

from glassware.procedural.optics.catalogue import catalogue
from glassware.procedural.optics.medium import Medium
from glassware.render.scene.loaded_scene import LoadedScene

from .bodies import ball, plano_convex, tube
from .bundles import refracted_rays, rows
from .check import EPS, ROUNDINGS, Check, worst
from .loading import interface, loaded

#: What the project promises of focal lengths [%].
FOCAL_BOUND = 0.5
_GLASS = Medium(name="glass", eta=1.52)
#: Rays of one height about the axis: they meet different places of the facets.
_AZIMUTHS = 64


def ball_lens(subdivisions: int = 6) -> list[Check]:
    """Measure the focal length of a ball of 40 mm: ``n D / (4 (n - 1))`` (Hecht, "Optics", sec. 6.1).

    Parameters
    ----------
    subdivisions : int
        Of the icosphere that stands for the ball; its edges are ``1.11 * 2^-subdivisions`` radii long.
    """
    radius, n = 0.02, _GLASS.eta
    kernel = loaded(interface(ball(radius, subdivisions), _GLASS))
    expected = n * radius / (2.0 * (n - 1.0))
    # A facet lies under the sphere by edge^2 / 8 at its sides and edge^2 / 6 at its middle. Its smoothed normal is that
    # of the point of the sphere in its direction, so heights are off by that share at each of the two surfaces.
    sagitta = (1.11 * 2.0**-subdivisions) ** 2 / 6.0
    return [_focal("Focal length of a ball lens", kernel, np.array([0.0, 0.0, -1.0]), radius, expected, 2.0 * sagitta)]


def plano_convex_lens(rings: int = 65, segments: int = 256) -> list[Check]:
    """Measure the focal length of a plano-convex lens, light on its curved face: ``R / (n - 1)`` (Hecht, eq. 5.16).

    Parameters
    ----------
    rings, segments : int
        Of the curved face's mesh.
    """
    radius, aperture = 0.05, 0.0125
    kernel = loaded(interface(plano_convex(radius, aperture, 0.002, rings, segments), _GLASS))
    expected = radius / (_GLASS.eta - 1.0)
    edge = np.arcsin(aperture / radius) / (rings - 1)
    # Along a meridian facets are chords of the sphere. Around it they are chords of the ring: heights shrink by that.
    sagitta = edge**2 / 6.0 + (2.0 * np.pi / segments) ** 2 / 6.0
    return [
        _focal("Focal length of a plano-convex lens", kernel, np.array([0.0, 0.0, -1.0]), radius, expected, sagitta)
    ]


def _focal(name: str, kernel: LoadedScene, along: np.ndarray, radius: float, expected: float, sagitta: float) -> Check:
    """Measure the focal length by rays parallel to the axis at two heights, extrapolated to height 0.

    A ray at height h leaves towards the axis at the tangent ``h / f``, where f falls as h^2 (third-order aberration).
    Two heights, one twice the other, remove that term; what is left goes with ``(h / R)^4`` and has coefficients of
    order 10 here.
    """
    share = 0.02
    near, far = (_power(kernel, along, scale * share * radius) for scale in (1.0, 2.0))
    power = (4.0 * near - far) / 3.0
    # The tangent share R / f comes from float32 directions of length 1, at two interfaces.
    rounding = 2 * ROUNDINGS * EPS * expected / (share * radius)
    limit = 100.0 * (sagitta + 5.0 / 3.0 * rounding + 10.0 * 4.0 * (2.0 * share) ** 4)
    basis = "facets, float32, fourth-order aberration"
    return worst(name, expected * 1e3, 1e3 / power, limit, basis, unit="mm", relative=True, bound=FOCAL_BOUND)


def _power(kernel: LoadedScene, along: np.ndarray, height: float) -> float:
    turn = 2.0 * np.pi * (np.arange(_AZIMUTHS) + 0.5) / _AZIMUTHS
    out = np.stack([np.cos(turn), np.sin(turn), np.zeros(_AZIMUTHS)], 1)
    end = refracted_rays(kernel, height * out - 0.1 * along, np.broadcast_to(along, out.shape))
    direction = rows(end.direction)
    return float((-(direction * out).sum(1) / (direction @ along)).mean() / height)


def glass_of_water(segments: int = 2048) -> list[Check]:
    """Send level rays through an upright glass of water: air, glass, water, glass, air.

    Round a centre ``n r sin(angle)`` stays the same (Bouguer; Born and Wolf, sec. 3.2), so the whole turn of a ray
    that passes at the distance b is the sum over the interfaces of ``2 (asin(b / (n_out r)) - asin(b / (n_in r)))``.
    With the media in another order, or a gap of air, it is another angle.

    Parameters
    ----------
    segments : int
        Of the two cylinders.
    """
    radius, bore, height = 0.035, 0.032, 0.1
    media = catalogue()
    water, glass = media["water"], media["soda-lime glass"]
    kernel = loaded(
        interface(tube(radius, height, segments, "outside"), glass),
        interface(tube(bore, height - 0.006, segments, "wet-wall", inwards=True), glass, water, part="wet_wall"),
    )
    b = np.concatenate([np.linspace(0.05, 0.85, 33), np.linspace(0.05, 0.85, 33) + 1e-3]) * bore
    outer, inner = (radius, 1.0, glass.eta), (bore, glass.eta, water.eta)
    terms = [(np.arcsin(b / (n * r)), r, n) for r, *pair in (outer, inner) for n in pair]
    expected = 2.0 * (terms[0][0] - terms[1][0] + terms[2][0] - terms[3][0])
    # A facet's middle lies under the cylinder by (half an angle)^2 / 2; its smoothed normal is the cylinder's. The ray
    # then meets it at another angle: tan(angle) times that share, at each of four surfaces, on both sides of each.
    sagitta = (np.pi / segments) ** 2 / 2.0
    limit = sum(2.0 * np.tan(angle) for angle, *_ in terms) * sagitta + 8 * ROUNDINGS * EPS / np.cos(terms[0][0])
    origins = np.stack([np.full_like(b, -0.08), b, np.zeros_like(b)], 1)
    end = refracted_rays(kernel, origins, np.broadcast_to([1.0, 0.0, 0.0], origins.shape))
    x, y, _ = rows(end.direction).T
    return [
        worst(
            "Glass of water: turn of level rays",
            np.degrees(expected),
            np.degrees(-np.arctan2(y, x)),
            np.degrees(limit),
            "facets, float32",
            unit="deg",
            bound=0.01,
        )
    ]
