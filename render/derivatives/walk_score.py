"""How likely a walk on a rough interface becomes as its roughness grows: the score of `microsurface.walk`.

The law of the direction in which a walk leaves has no closed form, but each of its steps has. The score is the sum of
d log p / d alpha over the steps. The mean of anything times the score is the derivative of that thing's mean (the
likelihood ratio method: Glynn 1990, "Likelihood Ratio Gradient Estimation for Stochastic Systems", CACM 33(10), eq. 4),
because nothing else in a path depends on the roughness.
"""

from __future__ import annotations

from .._mitsuba import dr, mi, syntax
from ..interfaces.microsurface import MAX_FACETS, facet_event, next_height, visible_facet

#: Directions this steep meet heights that do not depend on the roughness (`microsurface.next_height`).
_STEEP = 0.9999
#: Keeps logarithms and quotients finite where a float32 has come to its end: a height at the bottom, a level ray.
_TINY = 1e-7


@syntax
def walk_score(wi: mi.Vector3f, alpha: mi.Float, eta: mi.Float, seed: mi.UInt32) -> tuple[mi.Float, mi.Vector3f]:
    """Replay a walk.

    Parameters
    ----------
    wi, alpha, eta, seed
        What `microsurface.walk` was given.

    Returns
    -------
    score : mi.Float
        d log p / d alpha of the whole walk.
    direction : mi.Vector3f
        Unit direction in which it leaves, the same as the walk's.
    """
    numbers = mi.PCG32(initstate=mi.UInt64(seed))
    direction, height, score = mi.Vector3f(-wi), mi.Float(1.0), mi.Float(0.0)
    above, walking, facets = mi.Bool(True), mi.Bool(True), mi.UInt32(0)

    while walking:
        sign = dr.select(above, mi.Float(1.0), mi.Float(-1.0))
        sample = numbers.next_float32()
        reached, leaves = next_height(sign * direction, sign * height, alpha, sample)
        score += height_score(sign * direction, sign * height, alpha, sample, leaves)
        height = sign * reached
        walking &= ~leaves
        facet_at = mi.Point2f(numbers.next_float32(), numbers.next_float32())
        coin = numbers.next_float32()
        if walking:
            towards = -sign * direction
            facet = visible_facet(towards, alpha, facet_at)
            score += facet_score(towards, facet, alpha)
            left, mirrored = facet_event(towards, facet, dr.select(above, eta, dr.rcp(eta)), coin)
            direction = sign * left
            above = above == mirrored
        facets += 1
        walking &= facets < MAX_FACETS

    return score, direction


def height_score(
    direction: mi.Vector3f, height: mi.Float, alpha: mi.Float, sample: mi.Float, leaves: mi.Bool
) -> mi.Float:
    """Return d log p / d alpha of the draw of the next height, or of leaving.

    From the height with cdf C, a ray passes the one with cdf C' unhindered with the probability (C / C')^Lambda
    (Heitz et al. 2016, eq. 11), which `sample` is one less of. So a facet has the log density log |Lambda|
    + Lambda log(C / C') but for terms without alpha, and leaving has the log probability Lambda log C.
    """
    z, sin2 = dr.abs(direction.z), dr.maximum(1.0 - dr.square(direction.z), 0.0)
    w = dr.sqrt(dr.square(z) + dr.square(alpha) * sin2)  # |z| times the root in Lambda, which is finite at the horizon
    growth = dr.select(direction.z > 0.0, (w + z) / (alpha * w), alpha * sin2 / (w * (w + z)))  # d log |Lambda|/d alpha
    slope = 0.5 * alpha * sin2 / dr.maximum(z * w, _TINY)  # d Lambda / d alpha of a ray that climbs
    met = growth * (1.0 + dr.log(dr.maximum(1.0 - sample, _TINY)))
    left = slope * dr.log(dr.maximum(0.5 * (height + 1.0), _TINY))
    return dr.select(z > _STEEP, 0.0, dr.select(leaves, left, met))


def facet_score(wi: mi.Vector3f, facet: mi.Vector3f, alpha: mi.Float) -> mi.Float:
    """Return d log p / d alpha of the draw of a facet from those visible from `wi`.

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
