"""Rough dielectric interfaces: multiple-scattering microfacet BSDF by a random walk on the microsurface (GGX, Smith).

Heitz, Hanika, d'Eon, Dachsbacher 2016, "Multiple-Scattering Microfacet BSDFs with the Smith Model" (ACM TOG 35(4)):
the rough surface is a random height field of GGX facets. A ray walks on it, reflected or refracted by one facet after
another, until it leaves. Single-scattering microfacet models lose the light that one facet sends to another (7 % and
more at a roughness of 0.5); the walk conserves it. Heights are uniform in [-1, 1]: the choice does not change the
result (section 4.1).

Vectors are in the local frame of the surface, z along the macroscopic normal on the side that the ray comes from.
"""

from __future__ import annotations

from dataclasses import dataclass

from .._mitsuba import dr, mi, syntax

#: Maximum number of facets in one walk. The probability of a longer walk is below 1e-4, even at roughness 1; the light
#: of longer walks is lost.
MAX_FACETS = 32


@dataclass(frozen=True, eq=False)
class WalkEnd:
    """How a walk on the microsurface ends."""

    direction: mi.Vector3f  #: unit direction in which the ray leaves
    transmitted: mi.Bool  #: whether it leaves behind the surface
    alive: mi.Bool  #: False for the few walks that reach `MAX_FACETS`


@syntax
def walk(
    wi: mi.Vector3f, alpha: mi.Float, eta: mi.Float, seed: mi.UInt32, u_facet: mi.Point3f | None = None
) -> WalkEnd:
    """Follow a ray over the microsurface of an interface until it leaves.

    Parameters
    ----------
    wi : mi.Vector3f
        Unit direction to where the ray came from, ``wi.z > 0``.
    alpha : mi.Float
        GGX roughness, > 0.
    eta : mi.Float
        Index behind the surface over the index before it.
    seed : mi.UInt32
        Seed of the walk's own random numbers.
    u_facet : mi.Point3f, optional
        Sample for the first facet, for example of a low-discrepancy sequence: two numbers for its normal and one for
        reflection or refraction.
    """
    random = mi.PCG32(initstate=mi.UInt64(seed))
    direction, height = mi.Vector3f(-wi), mi.Float(1.0)
    above, walking, facets = mi.Bool(True), mi.Bool(True), mi.UInt32(0)

    while walking:
        # Below the surface the height field is the same, upside down (section 5.2).
        sign = dr.select(above, mi.Float(1.0), mi.Float(-1.0))
        reached, leaves = next_height(sign * direction, sign * height, alpha, random.next_float32())
        height = sign * reached
        walking &= ~leaves
        u_normal = mi.Point2f(random.next_float32(), random.next_float32())
        u_lobe = random.next_float32()
        if u_facet is not None:
            is_first = facets == 0
            u_normal.x = dr.select(is_first, u_facet.x, u_normal.x)
            u_normal.y = dr.select(is_first, u_facet.y, u_normal.y)
            u_lobe = dr.select(is_first, u_facet.z, u_lobe)
        if walking:
            towards = -sign * direction
            facet = visible_facet(towards, alpha, u_normal)
            outgoing, reflected = facet_event(towards, facet, dr.select(above, eta, dr.rcp(eta)), u_lobe)
            direction = sign * outgoing
            above = above == reflected
        facets += 1
        walking &= facets < MAX_FACETS

    return WalkEnd(direction, ~above, facets < MAX_FACETS)


def facet_event(
    towards: mi.Vector3f, facet: mi.Vector3f, eta: mi.Float, u_lobe: mi.Float
) -> tuple[mi.Vector3f, mi.Bool]:
    """Sample reflection or refraction at a facet by the Fresnel reflectance.

    Returns
    -------
    direction : mi.Vector3f
        Unit direction after the event.
    reflected : mi.Bool
        Whether the ray is reflected.
    """
    cos_i = dr.dot(towards, facet)
    reflectance, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    reflected = u_lobe < reflectance
    refracted = facet * dr.fma(cos_i, eta_ti, cos_t) - towards * eta_ti
    return dr.normalize(dr.select(reflected, mi.reflect(towards, facet), refracted)), reflected


def next_height(
    direction: mi.Vector3f, height: mi.Float, alpha: mi.Float, sample: mi.Float
) -> tuple[mi.Float, mi.Bool]:
    """Sample the height of the next facet (Heitz et al. 2016, section 4.2, eq. 11).

    Returns
    -------
    height : mi.Float
        Height of the next facet, in [-1, 1].
    leaves : mi.Bool
        Whether the ray leaves the microsurface instead.
    """
    cdf = 0.5 * (height + 1.0)
    exponent = smith_lambda(direction, alpha)
    # An upward ray leaves with the probability cdf^Lambda; a downward ray always meets a facet.
    leaves = (direction.z > 0.0) & (1.0 - sample <= dr.power(cdf, exponent))
    level = (1.0 - sample) ** dr.rcp(exponent)
    reached = 2.0 * cdf / level - 1.0
    steep = dr.abs(direction.z) > 0.9999
    leaves |= steep & (direction.z > 0.0)
    reached = dr.select(steep, 2.0 * sample * cdf - 1.0, reached)
    return dr.clip(reached, -1.0, 1.0), leaves


def smith_lambda(direction: mi.Vector3f, alpha: mi.Float) -> mi.Float:
    """Return Smith's Lambda for GGX, for directions up and down (Heitz et al. 2016, table 2)."""
    slope2 = dr.square(alpha) * dr.maximum(1.0 - dr.square(direction.z), 0.0) / dr.square(direction.z)
    root = dr.sqrt(1.0 + slope2)
    return 0.5 * (dr.select(direction.z > 0.0, root, -root) - 1.0)


def visible_facet(wi: mi.Vector3f, alpha: mi.Float, sample: mi.Point2f) -> mi.Vector3f:
    """Sample the normal of a facet from the distribution of visible normals (VNDF); `wi` may be below the horizon.

    Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps" (CGF 42(8)), algorithm 1.
    """
    stretched = dr.normalize(mi.Vector3f(alpha * wi.x, alpha * wi.y, wi.z))
    z = dr.fma(1.0 - sample.y, 1.0 + stretched.z, -stretched.z)
    sin_theta = dr.safe_sqrt(1.0 - z * z)
    sin_phi, cos_phi = dr.sincos(dr.two_pi * sample.x)
    half = mi.Vector3f(sin_theta * cos_phi, sin_theta * sin_phi, z) + stretched
    return dr.normalize(mi.Vector3f(alpha * half.x, alpha * half.y, dr.maximum(half.z, 0.0)))
