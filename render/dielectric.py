"""What one interface does to a ray: Fresnel's coin, mirror or refraction, smooth or rough.

All vectors are in the world frame; `wi` points back along the arriving ray. Rough interfaces follow Walter et al.
2007, "Microfacet Models for Refraction through Rough Surfaces", with GGX normals drawn from the visible ones after
Heitz 2018, "Sampling the GGX Distribution of Visible Normals" (JCGT 7(4)).
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi


@dataclass(frozen=True, eq=False)
class Scattered:
    """One scattering event."""

    direction: mi.Vector3f  #: unit, away from the surface
    weight: mi.Float  #: factor on the path's throughput (radiance, so with the ratio of indices squared)
    transmitted: mi.Bool
    eta_squared: mi.Float  #: (eta_t / eta_i)^2 where transmitted, else 1: what roulette must not count as loss


def scatter(
    wi: mi.Vector3f,
    n: mi.Vector3f,
    ns: mi.Vector3f,
    eta: mi.Float,
    alpha: mi.Float,
    coin: mi.Float,
    sample: mi.Point2f,
) -> Scattered:
    """Scatter at an interface.

    Parameters
    ----------
    wi : mi.Vector3f
        Unit direction to where the ray came from.
    n, ns : mi.Vector3f
        Geometric and shading normal, both on the side of `wi` by the geometric one: ``dot(n, wi) > 0``.
    eta : mi.Float
        Index of the medium behind the interface over the index of the medium that the ray comes from.
    alpha : mi.Float
        GGX roughness; 0 is smooth.
    coin, sample : mi.Float, mi.Point2f
        Uniform random numbers: reflect or refract, and the microfacet.
    """
    facet, masking = _facet(wi, ns, alpha, sample)
    # A shading normal that would send light to the wrong side of the real surface is dropped for the real one: rims
    # stay bright. (Rough facets may do so by nature; there the light is lost in the surface.)
    smooth = alpha <= 0.0
    facet = dr.select(smooth & ~_keeps_sides(wi, n, facet, eta), n, facet)
    cos_i = dr.dot(wi, facet)
    reflectance, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    mirrored = coin < reflectance
    direction = dr.select(mirrored, mi.reflect(wi, facet), _refracted(wi, facet, cos_i, cos_t, eta_ti))
    right_side = (dr.dot(direction, n) > 0.0) == mirrored
    shadowing = dr.select(smooth, 1.0, _smith_g1(direction, ns, alpha))
    weight = dr.select(right_side & (cos_i > 0.0), masking * shadowing, 0.0)
    # Radiance is squeezed by eta^2 on entering a denser medium (Veach 1997, eq. 5.6).
    weight *= dr.select(mirrored, 1.0, dr.square(eta_ti))
    return Scattered(dr.normalize(direction), weight, ~mirrored, dr.select(mirrored, 1.0, dr.square(eta)))


def _keeps_sides(wi: mi.Vector3f, n: mi.Vector3f, facet: mi.Vector3f, eta: mi.Float) -> mi.Bool:
    cos_i = dr.dot(wi, facet)
    _, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    reflects = dr.dot(mi.reflect(wi, facet), n) > 0.0
    refracts = (dr.dot(_refracted(wi, facet, cos_i, cos_t, eta_ti), n) < 0.0) | (cos_t == 0.0)
    return (cos_i > 0.0) & reflects & refracts


def _refracted(wi: mi.Vector3f, facet: mi.Vector3f, cos_i: mi.Float, cos_t: mi.Float, eta_ti: mi.Float) -> mi.Vector3f:
    # Snell's law in vector form; mi.fresnel gives cos_t with the sign opposite to cos_i.
    return facet * dr.fma(cos_i, eta_ti, cos_t) - wi * eta_ti


def _facet(wi: mi.Vector3f, ns: mi.Vector3f, alpha: mi.Float, sample: mi.Point2f) -> tuple[mi.Vector3f, mi.Float]:
    """Return the microfacet's normal (the shading normal where smooth) and its share of masking, 1 by construction."""
    frame = mi.Frame3f(ns)
    local = frame.to_local(wi)
    local.z = dr.maximum(local.z, 1e-6)  # a shading normal may look away from wi; visible normals need it above
    stretched = dr.normalize(mi.Vector3f(alpha * local.x, alpha * local.y, local.z))
    # Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps", algorithm 1.
    phi = dr.two_pi * sample.x
    z = dr.fma(1.0 - sample.y, 1.0 + stretched.z, -stretched.z)
    sin_theta = dr.safe_sqrt(1.0 - z * z)
    sin_phi, cos_phi = dr.sincos(phi)
    half = mi.Vector3f(sin_theta * cos_phi, sin_theta * sin_phi, z) + stretched
    micro = dr.normalize(mi.Vector3f(alpha * half.x, alpha * half.y, dr.maximum(half.z, 0.0)))
    return dr.select(alpha > 0.0, frame.to_world(micro), ns), mi.Float(1.0)


def _smith_g1(direction: mi.Vector3f, ns: mi.Vector3f, alpha: mi.Float) -> mi.Float:
    """Return Smith's masking for GGX (Walter et al. 2007, eq. 34)."""
    cos2 = dr.square(dr.dot(direction, ns))
    tan2 = dr.maximum(1.0 - cos2, 0.0) / dr.maximum(cos2, 1e-12)
    return 2.0 / (1.0 + dr.sqrt(1.0 + dr.square(alpha) * tan2))
