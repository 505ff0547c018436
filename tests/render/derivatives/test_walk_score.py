"""The score of walks on rough interfaces against closed forms and central differences."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.render.derivatives.walk_score import facet_score, walk_score
from glassware.render.interfaces.microsurface import visible_facet, walk

#: Standard errors that a right mean may be off; one in 15,000 is farther (normal law), and there are some 30 means.
SIGMAS = 4.0
WALKS = 1 << 19


def _number(value: float):
    """A number that is not compiled into the kernel: all cases then use the same one."""
    import drjit as dr
    import mitsuba as mi

    return dr.opaque(mi.Float, value)


def _seeds(count: int, first: int = 0):
    import drjit as dr
    import mitsuba as mi

    return mi.sample_tea_32(dr.arange(mi.UInt32, count), mi.UInt32(first + 1), 4)[0]


def _arriving(degrees: float):
    import drjit as dr
    import mitsuba as mi

    theta = np.radians(degrees)
    return dr.opaque(mi.Vector3f, [float(np.sin(theta)), 0.0, float(np.cos(theta))])


def _off(values: np.ndarray, expected: float) -> float:
    """How many standard errors a mean is off."""
    return abs(values.mean() - expected) / (values.std(ddof=1) / np.sqrt(len(values)))


def test_the_replayed_walk_leaves_as_the_walk_does(backend):
    given = _arriving(60.0), _number(0.4), _number(1 / 1.5), _seeds(10_000)
    assert np.array_equal(np.array(walk_score(*given)[1]), np.array(walk(*given).direction))


def test_facets_seen_from_straight_above_spread_as_the_closed_form_says(backend):
    import drjit as dr
    import mitsuba as mi

    # GGX: the squared slope s is below x for x / (x + alpha^2) of the facets, so the mean of z^2 = 1 / (1 + s) is
    def mean(alpha: float) -> float:
        a = alpha**2
        return a * np.log(a) / (1 - a) ** 2 + 1 / (1 - a)

    alpha, h = 0.3, 1e-5
    numbers = mi.PCG32(size=WALKS)
    wi = dr.zeros(mi.Vector3f, WALKS) + mi.Vector3f(0.0, 0.0, 1.0)
    facet = visible_facet(wi, mi.Float(alpha), mi.Point2f(numbers.next_float32(), numbers.next_float32()))
    product = np.array(dr.square(facet.z) * facet_score(wi, facet, mi.Float(alpha)), np.float64)
    expected = (mean(alpha + h) - mean(alpha - h)) / (2 * h)
    assert _off(product, expected) < SIGMAS
    assert _off(1.05 * product, expected) > SIGMAS  # so a score that is a twentieth off is found


@pytest.mark.parametrize("eta", [1.5, 1 / 1.5])
@pytest.mark.parametrize(("alpha", "degrees"), [(0.05, 30.0), (0.3, 0.0), (0.3, 75.0), (0.9, 60.0)])
def test_scores_have_mean_zero_and_give_the_derivative_of_any_mean(backend, eta, alpha, degrees):
    wi, eta, seeds = _arriving(degrees), _number(eta), _seeds(WALKS, 1)
    score, direction = (np.array(x, np.float64) for x in walk_score(wi, _number(alpha), eta, seeds))
    assert np.isfinite(score).all()
    assert _off(score, 0.0) < SIGMAS

    # A step of 4 % leaves some 0.03 % of the derivative out, less than the noise.
    h = 0.04 * alpha
    for seen in (lambda d: d[2] > 0.0, lambda d: d[0], lambda d: d[2] ** 2):
        up, down = (np.array(walk(wi, _number(alpha + s), eta, seeds).direction, np.float64) for s in (h, -h))
        difference = (seen(up) * 1.0 - seen(down)) / (2 * h)
        value = seen(direction) * 1.0
        assert _off((value - value.mean()) * score - difference, 0.0) < SIGMAS
