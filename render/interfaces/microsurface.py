"""Rough interfaces: a random walk on the microsurface, which loses no light.

Heitz, Hanika, d'Eon, Dachsbacher 2016, "Multiple-Scattering Microfacet BSDFs with the Smith Model" (ACM TOG 35(4)):
the rough surface is a random height field of GGX facets. A ray walks on it, reflected or refracted by facet after
facet, until it leaves. With one event only, as in most renderers, light that a facet sends at another is lost (7 % and
more at a roughness of 0.5); the walk keeps it. Heights are uniform in [-1, 1]: the choice does not change the outcome
(section 4.1).

Vectors are in the local frame of the surface, z along the macroscopic normal on the side that the ray comes from.
"""

from __future__ import annotations

from .._mitsuba import dr, mi, syntax

#: Most facets met in one walk. The chance to stay falls below 1e-4 by then, even at roughness 1; what remains is lost.
MAX_FACETS = 32


@syntax
def walk(
    wi: mi.Vector3f, alpha: mi.Float, eta: mi.Float, seed: mi.UInt32, first: mi.Point3f | None = None
) -> tuple[mi.Vector3f, mi.Bool, mi.Bool]:
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
    first : mi.Point3f, optional
        Numbers for the first facet, two for its normal and one for Fresnel's coin, where better ones are to be had.

    Returns
    -------
    direction : mi.Vector3f
        Unit direction in which it leaves.
    transmitted : mi.Bool
        Whether it leaves behind the surface.
    alive : mi.Bool
        False for the few that were still walking at the end.
    """
    numbers = mi.PCG32(initstate=mi.UInt64(seed))
    direction, height = mi.Vector3f(-wi), mi.Float(1.0)
    above, walking, facets = mi.Bool(True), mi.Bool(True), mi.UInt32(0)

    while walking:
        # Below the surface the height field is the same, upside down (section 5.2).
        sign = dr.select(above, mi.Float(1.0), mi.Float(-1.0))
        reached, leaves = next_height(sign * direction, sign * height, alpha, numbers.next_float32())
        height = sign * reached
        walking &= ~leaves
        facet_at = mi.Point2f(numbers.next_float32(), numbers.next_float32())
        coin = numbers.next_float32()
        if first is not None:
            given = facets == 0
            facet_at.x = dr.select(given, first.x, facet_at.x)
            facet_at.y = dr.select(given, first.y, facet_at.y)
            coin = dr.select(given, first.z, coin)
        if walking:
            towards = -sign * direction
            facet = visible_facet(towards, alpha, facet_at)
            left, mirrored = facet_event(towards, facet, dr.select(above, eta, dr.rcp(eta)), coin)
            direction = sign * left
            above = above == mirrored
        facets += 1
        walking &= facets < MAX_FACETS

    return direction, ~above, facets < MAX_FACETS


def facet_event(towards: mi.Vector3f, facet: mi.Vector3f, eta: mi.Float, coin: mi.Float) -> tuple[mi.Vector3f, mi.Bool]:
    """Return the direction in which a facet sends a ray, and whether it mirrors it, by Fresnel's share."""
    cos_i = dr.dot(towards, facet)
    reflectance, cos_t, _, eta_ti = mi.fresnel(cos_i, eta)
    mirrored = coin < reflectance
    refracted = facet * dr.fma(cos_i, eta_ti, cos_t) - towards * eta_ti
    return dr.normalize(dr.select(mirrored, mi.reflect(towards, facet), refracted)), mirrored


def next_height(
    direction: mi.Vector3f, height: mi.Float, alpha: mi.Float, sample: mi.Float
) -> tuple[mi.Float, mi.Bool]:
    """Return the height of the next facet met, and whether there is none (Heitz et al. 2016, section 4.2, eq. 11)."""
    cdf = 0.5 * (height + 1.0)
    exponent = smith_lambda(direction, alpha)
    # A ray that climbs leaves with the probability cdf^Lambda; one that goes down always meets a facet.
    leaves = (direction.z > 0.0) & (1.0 - sample <= dr.power(cdf, exponent))
    level = (1.0 - sample) ** dr.rcp(exponent)
    met = 2.0 * cdf / level - 1.0
    steep = dr.abs(direction.z) > 0.9999
    leaves |= steep & (direction.z > 0.0)
    met = dr.select(steep, 2.0 * sample * cdf - 1.0, met)
    return dr.clip(met, -1.0, 1.0), leaves


def smith_lambda(direction: mi.Vector3f, alpha: mi.Float) -> mi.Float:
    """Return Smith's Lambda for GGX, for directions up and down (Heitz et al. 2016, table 2)."""
    slope2 = dr.square(alpha) * dr.maximum(1.0 - dr.square(direction.z), 0.0) / dr.square(direction.z)
    root = dr.sqrt(1.0 + slope2)
    return 0.5 * (dr.select(direction.z > 0.0, root, -root) - 1.0)


def visible_facet(wi: mi.Vector3f, alpha: mi.Float, sample: mi.Point2f) -> mi.Vector3f:
    """Draw a facet's normal from those visible from `wi`, which may look from below the horizon.

    Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps" (CGF 42(8)), algorithm 1.
    """
    stretched = dr.normalize(mi.Vector3f(alpha * wi.x, alpha * wi.y, wi.z))
    z = dr.fma(1.0 - sample.y, 1.0 + stretched.z, -stretched.z)
    sin_theta = dr.safe_sqrt(1.0 - z * z)
    sin_phi, cos_phi = dr.sincos(dr.two_pi * sample.x)
    half = mi.Vector3f(sin_theta * cos_phi, sin_theta * sin_phi, z) + stretched
    return dr.normalize(mi.Vector3f(alpha * half.x, alpha * half.y, dr.maximum(half.z, 0.0)))
