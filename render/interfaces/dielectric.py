"""What one interface does to a ray: Fresnel's coin, mirror or refraction, smooth or rough.

All vectors are in the world frame; `wi` points back along the arriving ray.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .._mitsuba import dr, mi, syntax
from .microsurface import walk

#: How often to mirror, given `wi`, the normal and Fresnel's share: for rays that are to be steered.
Odds = Callable[..., Any]


@dataclass(frozen=True, eq=False)
class Scattered:
    """One scattering event."""

    direction: mi.Vector3f  #: unit, away from the surface
    weight: mi.Float  #: factor on the path's throughput (radiance, so with the ratio of indices squared)
    transmitted: mi.Bool
    eta_squared: mi.Float  #: (eta_t / eta_i)^2 where transmitted, else 1: what roulette must not count as loss
    share: mi.Float  #: how often the coin falls so; 1 where rough, which tosses no coin


@syntax
def scatter(
    wi: mi.Vector3f,
    n: mi.Normal3f,
    ns: mi.Normal3f,
    eta: mi.Float,
    alpha: mi.Float,
    coin: mi.Float,
    seed: mi.UInt32,
    odds: Odds | None = None,
    first: mi.Point3f | None = None,
) -> Scattered:
    """Scatter at an interface.

    Parameters
    ----------
    wi : mi.Vector3f
        Unit direction to where the ray came from.
    n, ns : mi.Normal3f
        Geometric and shading normal, both on the side of `wi` by the geometric one: ``dot(n, wi) > 0``.
    eta : mi.Float
        Index of the medium behind the interface over the index of the medium that the ray comes from.
    alpha : mi.Float
        GGX roughness; 0 is smooth.
    coin : mi.Float
        Uniform random number: reflect or refract, where smooth.
    seed : mi.UInt32
        Seed of the walk on the microsurface, where rough.
    odds : callable, optional
        How often to mirror; by default as often as Fresnel's share says. The weight makes up for it.
    first : mi.Point3f, optional
        As in `microsurface.walk`, where rough.
    """
    facet = upright_normal(wi, n, ns, eta)
    cos_i = dr.dot(wi, facet)
    reflectance, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    mirrored = reflectance if odds is None else odds(wi, facet, reflectance)
    transmitted = coin >= mirrored
    direction = dr.select(transmitted, refracted(wi, facet, cos_i, cos_t, eta_ti), mi.reflect(wi, facet))
    share = dr.select(transmitted, 1.0 - mirrored, mirrored)
    weight = mi.Float(1.0) if odds is None else dr.select(transmitted, 1.0 - reflectance, reflectance) / share

    if alpha > 0.0:
        frame = mi.Frame3f(facet)
        local, transmitted, alive = walk(frame.to_local(wi), alpha, eta, seed, first)
        direction = frame.to_world(local)
        # A shading normal may leave the walk on the wrong side of the real surface: the ray is mirrored back to the
        # side that it chose, which keeps its light.
        wrong = (dr.dot(direction, n) < 0.0) != transmitted
        direction = dr.select(wrong, direction - 2.0 * dr.dot(direction, n) * n, direction)
        weight, share = dr.select(alive, mi.Float(1.0), 0.0), mi.Float(1.0)

    # Radiance is squeezed by eta^2 on entering a denser medium (Veach 1997, eq. 5.6).
    eta_squared = dr.select(transmitted, dr.square(eta), 1.0)
    return Scattered(dr.normalize(direction), weight * dr.rcp(eta_squared), transmitted, eta_squared, share)


def upright_normal(wi: mi.Vector3f, n: mi.Normal3f, ns: mi.Normal3f, eta: mi.Float) -> mi.Normal3f:
    """Return the shading normal, or the geometric one where the first would send light to the wrong side.

    Rims stay bright: near the edge of a curved wall a smoothed normal can look away from the ray, or turn the mirrored
    or the refracted ray through the real surface.
    """
    cos_i = dr.dot(wi, ns)
    _, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    reflects = dr.dot(mi.reflect(wi, ns), n) > 0.0
    refracts = (dr.dot(refracted(wi, ns, cos_i, cos_t, eta_ti), n) < 0.0) | (cos_t == 0.0)
    return dr.select((cos_i > 0.0) & reflects & refracts, ns, n)


def refracted(wi: mi.Vector3f, facet: mi.Normal3f, cos_i: mi.Float, cos_t: mi.Float, eta_ti: mi.Float) -> mi.Vector3f:
    """Return the refracted direction by Snell's law in vector form, with the numbers that `mi.fresnel` returns.

    Its `cos_t` has the sign opposite to `cos_i`; `eta_ti` is the index before the surface over the one behind it.
    """
    return mi.Vector3f(facet) * dr.fma(cos_i, eta_ti, cos_t) - wi * eta_ti


def through(wi: mi.Vector3f, n: mi.Normal3f, ns: mi.Normal3f, eta: mi.Float) -> tuple[mi.Vector3f, mi.Float]:
    """Return the direction behind an interface and the share of light that takes it; mirrored where that is total."""
    facet = upright_normal(wi, n, ns, eta)
    cos_i = dr.dot(wi, facet)
    reflectance, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    total = cos_t == 0.0
    direction = dr.select(total, mi.reflect(wi, facet), refracted(wi, facet, cos_i, cos_t, eta_ti))
    return dr.normalize(direction), dr.select(total, 1.0, 1.0 - reflectance)
