"""Score function d log p / d alpha of the random walk on a rough interface (`microsurface.walk`).

The density of the direction in which a walk leaves has no closed form, but that of each step has. The score is the sum
of d log p / d alpha over the steps. The mean of a quantity times the score is the derivative of the quantity's mean
(likelihood ratio method, REINFORCE: Glynn 1990, "Likelihood Ratio Gradient Estimation for Stochastic Systems", CACM
33(10), eq. 4), because nothing else in a path depends on the roughness.
"""

from __future__ import annotations

from .._mitsuba import dr, mi, syntax
from ..interfaces.microsurface import MAX_FACETS, facet_event, next_height, visible_facet

#: |cos| to the normal above which heights do not depend on the roughness [1] (`microsurface.next_height`).
_STEEP = 0.9999
#: Keeps logarithms and quotients finite in float32 [1]: at the lowest height, for a horizontal ray.
_TINY = 1e-7


@syntax
def walk_score(wi: mi.Vector3f, alpha: mi.Float, eta: mi.Float, seed: mi.UInt32) -> tuple[mi.Float, mi.Vector3f]:
    """Repeat a walk and return its score.

    Parameters
    ----------
    wi, alpha, eta, seed
        The arguments of `microsurface.walk`.

    Returns
    -------
    score : mi.Float
        d log p / d alpha of the whole walk.
    direction : mi.Vector3f
        Unit direction in which it leaves, the same as the walk's.
    """
    random = mi.PCG32(initstate=mi.UInt64(seed))
    direction, height, score = mi.Vector3f(-wi), mi.Float(1.0), mi.Float(0.0)
    above, walking, facets = mi.Bool(True), mi.Bool(True), mi.UInt32(0)

    while walking:
        sign = dr.select(above, mi.Float(1.0), mi.Float(-1.0))
        sample = random.next_float32()
        reached, leaves = next_height(sign * direction, sign * height, alpha, sample)
        score += height_score(sign * direction, sign * height, alpha, sample, leaves)
        height = sign * reached
        walking &= ~leaves
        u_normal = mi.Point2f(random.next_float32(), random.next_float32())
        u_lobe = random.next_float32()
        if walking:
            towards = -sign * direction
            facet = visible_facet(towards, alpha, u_normal)
            score += facet_score(towards, facet, alpha)
            outgoing, reflected = facet_event(towards, facet, dr.select(above, eta, dr.rcp(eta)), u_lobe)
            direction = sign * outgoing
            above = above == reflected
        facets += 1
        walking &= facets < MAX_FACETS

    return score, direction


def height_score(
    direction: mi.Vector3f, height: mi.Float, alpha: mi.Float, sample: mi.Float, leaves: mi.Bool
) -> mi.Float:
    """Return d log p / d alpha of sampling the next height, or of leaving.

    From the height with cdf C, a ray reaches the height with cdf C' without an intersection with the probability
    (C / C')^Lambda (Heitz et al. 2016, eq. 11), which is 1 - `sample`. So a facet has the log density log |Lambda|
    + Lambda log(C / C') plus terms without alpha, and leaving has the log probability Lambda log C.
    """
    z, sin2 = dr.abs(direction.z), dr.maximum(1.0 - dr.square(direction.z), 0.0)
    w = dr.sqrt(dr.square(z) + dr.square(alpha) * sin2)  # |z| times the root in Lambda, finite at the horizon
    growth = dr.select(direction.z > 0.0, (w + z) / (alpha * w), alpha * sin2 / (w * (w + z)))  # d log |Lambda|/d alpha
    slope = 0.5 * alpha * sin2 / dr.maximum(z * w, _TINY)  # d Lambda / d alpha of an upward ray
    hits = growth * (1.0 + dr.log(dr.maximum(1.0 - sample, _TINY)))
    misses = slope * dr.log(dr.maximum(0.5 * (height + 1.0), _TINY))
    return dr.select(z > _STEEP, 0.0, dr.select(leaves, misses, hits))


def facet_score(wi: mi.Vector3f, facet: mi.Vector3f, alpha: mi.Float) -> mi.Float:
    """Return d log p / d alpha of sampling a facet from the visible normals of `wi`.

    p is proportional to D(facet) / sigma(wi) (Heitz et al. 2016, eq. 4): with GGX, D = alpha^2 / (pi (alpha^2 z^2 + x^2
    + y^2)^2), and the projected area sigma = (z + w) / 2 with w^2 = z^2 + alpha^2 (1 - z^2).
    """
    flat = dr.square(facet.z)
    spread = dr.square(facet.x) + dr.square(facet.y)  # not 1 - z^2, which cancels at small roughness
    of_facets = 2.0 / alpha * (spread - dr.square(alpha) * flat) / (spread + dr.square(alpha) * flat)
    sin2 = dr.maximum(1.0 - dr.square(wi.z), 0.0)
    w = dr.sqrt(dr.square(wi.z) + dr.square(alpha) * sin2)
    from_above, from_below = alpha * sin2 / (w * (w + dr.abs(wi.z))), (w - wi.z) / (alpha * w)
    return of_facets - dr.select(wi.z > 0.0, from_above, from_below)
