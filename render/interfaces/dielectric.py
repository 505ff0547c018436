"""Scattering at a dielectric interface: Fresnel reflection or refraction, smooth or rough (unpolarised BSDF sampling).

All vectors are in the world frame; `wi` points back along the arriving ray.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from .._mitsuba import dr, mi, syntax
from .microsurface import walk

#: Probability of reflection, given `wi`, the shading normal and the Fresnel reflectance: the hook for path guiding.
#: As a text, since `mi` has no types before a variant is set.
ReflectProbability: TypeAlias = "Callable[[mi.Vector3f, mi.Normal3f, mi.Float], mi.Float]"


@dataclass(frozen=True, eq=False)
class InterfaceHit:
    """A ray at a dielectric interface, with the random numbers of its scattering event."""

    wi: mi.Vector3f  #: unit direction to where the ray came from
    n: mi.Normal3f  #: geometric normal on the side of `wi`: ``dot(n, wi) > 0``
    ns: mi.Normal3f  #: shading normal, on the same side as `n`
    eta: mi.Float  #: index of the medium behind the interface over the index of the medium before it
    alpha: mi.Float  #: GGX roughness; 0 is smooth
    u_lobe: mi.Float  #: uniform random number: reflect or refract, where smooth
    seed: mi.UInt32  #: seed of the random walk on the microsurface, where rough
    u_facet: mi.Point3f | None = None  #: sample for the first facet of that walk, see `microsurface.walk`


@dataclass(frozen=True, eq=False)
class Scattered:
    """A sampled scattering event."""

    direction: mi.Vector3f  #: unit, away from the surface
    weight: mi.Float  #: factor on the path's throughput (of radiance, so it contains the squared ratio of indices)
    transmitted: mi.Bool
    eta_squared: mi.Float  #: (eta_t / eta_i)^2 where transmitted, else 1: what Russian roulette must not count as loss
    probability: mi.Float  #: of the sampled lobe (reflection or refraction); 1 where rough, which samples no lobe


@syntax
def scatter(hit: InterfaceHit, reflect_probability: ReflectProbability | None = None) -> Scattered:
    """Sample a scattering event at an interface.

    Parameters
    ----------
    hit : InterfaceHit
        The ray at the interface.
    reflect_probability : callable, optional
        Probability of reflection at smooth interfaces; by default the Fresnel reflectance. The weight compensates it
        (importance sampling), so the mean does not depend on it.
    """
    wi, n, eta, alpha = hit.wi, hit.n, hit.eta, hit.alpha
    seed, u_facet = hit.seed, hit.u_facet
    facet = consistent_normal(wi, n, hit.ns, eta)
    cos_i = dr.dot(wi, facet)
    reflectance, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    p_reflect = reflectance if reflect_probability is None else reflect_probability(wi, facet, reflectance)
    transmitted = hit.u_lobe >= p_reflect
    direction = dr.select(transmitted, refracted(wi, facet, cos_i, cos_t, eta_ti), mi.reflect(wi, facet))
    probability = dr.select(transmitted, 1.0 - p_reflect, p_reflect)
    fresnel = dr.select(transmitted, 1.0 - reflectance, reflectance)
    weight = mi.Float(1.0) if reflect_probability is None else fresnel / probability

    if alpha > 0.0:
        frame = mi.Frame3f(facet)
        end = walk(frame.to_local(wi), alpha, eta, seed, u_facet)
        transmitted = end.transmitted
        direction = frame.to_world(end.direction)
        # A shading normal may leave the walk on the wrong side of the geometric surface: the ray is reflected back to
        # the side that the walk sampled, which keeps its light.
        wrong = (dr.dot(direction, n) < 0.0) != transmitted
        direction = dr.select(wrong, direction - 2.0 * dr.dot(direction, n) * n, direction)
        weight, probability = dr.select(end.alive, mi.Float(1.0), 0.0), mi.Float(1.0)

    # Radiance is scaled by eta^2 on entering a denser medium (Veach 1997, eq. 5.6).
    eta_squared = dr.select(transmitted, dr.square(eta), 1.0)
    return Scattered(dr.normalize(direction), weight * dr.rcp(eta_squared), transmitted, eta_squared, probability)


def consistent_normal(wi: mi.Vector3f, n: mi.Normal3f, ns: mi.Normal3f, eta: mi.Float) -> mi.Normal3f:
    """Return the shading normal, or the geometric one where the shading normal would send light to the wrong side.

    Near the edge of a curved wall an interpolated normal can face away from the ray, or turn the reflected or the
    refracted ray through the geometric surface. Without this check rims of glasses are dark.
    """
    cos_i = dr.dot(wi, ns)
    _, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    reflects = dr.dot(mi.reflect(wi, ns), n) > 0.0
    refracts = (dr.dot(refracted(wi, ns, cos_i, cos_t, eta_ti), n) < 0.0) | (cos_t == 0.0)
    return dr.select((cos_i > 0.0) & reflects & refracts, ns, n)


def refracted(wi: mi.Vector3f, facet: mi.Normal3f, cos_i: mi.Float, cos_t: mi.Float, eta_ti: mi.Float) -> mi.Vector3f:
    """Return the refracted direction by Snell's law in vector form, from the values that `mi.fresnel` returns.

    `cos_t` has the sign opposite to `cos_i`; `eta_ti` is the index before the surface over the index behind it.
    """
    return mi.Vector3f(facet) * dr.fma(cos_i, eta_ti, cos_t) - wi * eta_ti


def transmission(wi: mi.Vector3f, n: mi.Normal3f, ns: mi.Normal3f, eta: mi.Float) -> tuple[mi.Vector3f, mi.Float]:
    """Return the refracted direction and the Fresnel transmittance 1 - R; the reflected one and 1 where total."""
    facet = consistent_normal(wi, n, ns, eta)
    cos_i = dr.dot(wi, facet)
    reflectance, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    total = cos_t == 0.0
    direction = dr.select(total, mi.reflect(wi, facet), refracted(wi, facet, cos_i, cos_t, eta_ti))
    return dr.normalize(direction), dr.select(total, 1.0, 1.0 - reflectance)
