"""One event at an interface against Fresnel's equations, Snell's law and the density of visible facets."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chisquare, ks_2samp

from glassware.render.interfaces.dielectric import InterfaceHit
from glassware.render.interfaces.dielectric import scatter as event
from glassware.render.interfaces.microsurface import visible_facet, walk

#: float32 directions through a square root near total reflection.
ANGLE_TOLERANCE = 2e-5
#: Chance that a right sampler fails with another seed.
SIGNIFICANCE = 1e-4
#: The sampler draws multiples of 2^-24 below 1.
LARGEST_COIN = 1.0 - 2.0**-24
RATIOS = [1.52, 1.33, 1.0 / 1.52, 1.52 / 1.33, 1.33 / 1.52]


@pytest.fixture
def scatter(backend):
    """Directions, coins and normals as NumPy arrays -> the events as NumPy arrays."""
    import drjit as dr
    import mitsuba as mi

    def run(wi, eta, coin, alpha=0.0, n=(0, 0, 1), ns=None):
        count = len(wi)

        # Plain numbers would be compiled into the kernel, as the alignment of NumPy's memory is: each case would have
        # a kernel of its own. What is computed has neither.
        def numbers(values):
            return mi.Float(np.broadcast_to(np.asarray(values, np.float32), count).copy()) + dr.opaque(mi.Float, 0.0)

        def vector(rows, kind):
            return kind(*map(numbers, np.broadcast_to(rows, (count, 3)).T))

        hit = InterfaceHit(
            vector(wi, mi.Vector3f),
            vector(n, mi.Normal3f),
            vector(n if ns is None else ns, mi.Normal3f),
            numbers(eta),
            numbers(alpha),
            numbers(coin),
            mi.sample_tea_32(dr.arange(mi.UInt32, count), 1)[0],
        )
        dr.eval(hit)
        found = event(hit)
        dr.eval(found)
        names = ("weight", "transmitted", "eta_squared")
        return np.array(found.direction).T.astype(float), *(np.array(getattr(found, name)) for name in names)

    return run


def _directions(count: int) -> np.ndarray:
    """From straight down to 89 degrees, all round."""
    theta, phi = np.linspace(0.0, np.deg2rad(89.0), count), np.linspace(0.0, 40.0, count)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)


def _fresnel(cos_i: np.ndarray, eta: float) -> np.ndarray:
    """Unpolarised reflectance (Born and Wolf 1999, section 1.5.2, eq. 21), 1 beyond the critical angle."""
    sin_t2 = (1.0 - cos_i**2) / eta**2
    cos_t = np.sqrt(np.maximum(1.0 - sin_t2, 0.0))
    s, p = (cos_i - eta * cos_t) / (cos_i + eta * cos_t), (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    return np.where(sin_t2 >= 1.0, 1.0, 0.5 * (s**2 + p**2))


@pytest.mark.parametrize("eta", RATIOS)
def test_a_ray_is_mirrored_exactly_where_the_coin_falls_below_fresnels_reflectance(scatter, eta):
    wi = _directions(500)
    expected = _fresnel(wi[:, 2], eta)
    below, above = expected - 1e-4, expected + 1e-4  # float32 rounding of a reflectance near 1
    assert not scatter(wi, eta, np.maximum(below, 0.0))[2][below > 0.0].any()
    assert scatter(wi, eta, above)[2][above < 1.0].all()


@pytest.mark.parametrize("eta", RATIOS)
def test_directions_follow_snells_law_and_the_law_of_reflection(scatter, eta):
    wi = _directions(500)
    mirrored, weight, transmitted, scale = scatter(wi, eta, -1.0)
    assert not transmitted.any()
    np.testing.assert_allclose(mirrored, wi * [-1.0, -1.0, 1.0], atol=ANGLE_TOLERANCE)
    np.testing.assert_array_equal((weight, scale), 1.0)

    refracted, _, transmitted, _ = scatter(wi, eta, 2.0)
    sin_t = wi[:, :2] / eta
    possible = (sin_t**2).sum(1) < 1.0 - 1e-6
    assert transmitted[possible].all()
    np.testing.assert_allclose(refracted[possible, :2], -sin_t[possible], atol=ANGLE_TOLERANCE)
    assert (refracted[possible, 2] < 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(refracted, axis=1), 1.0, atol=1e-6)


def test_beyond_the_critical_angle_everything_is_mirrored(scatter):
    eta = 1.0 / 1.52
    wi = _directions(500)
    total = wi[:, 2] < np.sqrt(1.0 - eta**2) - 1e-4
    assert total.any()

    direction, _, transmitted, _ = scatter(wi, eta, LARGEST_COIN)
    assert not transmitted[total].any()
    assert (direction[total, 2] > 0.0).all()


@pytest.mark.parametrize("eta", RATIOS)
def test_radiance_is_scaled_by_the_square_of_the_indices_where_it_passes(scatter, eta):
    _, weight, transmitted, scale = scatter(_directions(100)[:20], eta, 1.0)
    assert transmitted.all()
    # From a dense medium into a thin one (eta < 1) light spreads, seen from the camera's side: weight 1 / eta^2.
    np.testing.assert_allclose(weight, 1.0 / eta**2, rtol=1e-6)
    np.testing.assert_allclose(weight * scale, 1.0, rtol=1e-6)


@pytest.mark.parametrize("eta", [1.52, 1.0 / 1.52])
@pytest.mark.parametrize("coin", [-1.0, 0.5, LARGEST_COIN])
def test_the_geometric_normal_decides_the_side(scatter, rng, eta, coin):
    # Shading normals up to a right angle off, as at the edge of a curved wall.
    wi = _directions(2000)
    ns = rng.normal(size=wi.shape) * [1, 1, 0.3]
    ns[:, 2] = np.abs(ns[:, 2])
    ns /= np.linalg.norm(ns, axis=1, keepdims=True)
    direction, weight, transmitted, _ = scatter(wi, eta, coin, ns=ns)
    np.testing.assert_array_equal(direction[:, 2] < 0.0, transmitted)
    assert (weight > 0.0).all()  # rims keep their light


@pytest.mark.parametrize("eta", [1.52, 1.0 / 1.52, 1.33 / 1.52])
@pytest.mark.parametrize("alpha", [0.02, 0.2, 0.8])
def test_a_rough_interface_loses_no_light_and_keeps_to_its_side(scatter, eta, alpha):
    wi = np.repeat(_directions(9)[[0, 4, 7]], 2000, axis=0)
    direction, weight, transmitted, scale = scatter(wi, eta, 0.0, alpha=alpha)
    np.testing.assert_array_equal(direction[:, 2] < 0.0, transmitted)
    # What still walks at the end of 32 facets is lost: at most one in ten thousand, as its source says.
    assert (weight * scale < 1.0 - 1e-5).mean() < 1e-3
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, atol=1e-5)


def test_a_nearly_smooth_rough_interface_is_the_smooth_one(scatter):
    wi = np.repeat(_directions(9)[[0, 3, 6]], 4000, axis=0)
    direction, _, transmitted, _ = scatter(wi, 1.52, 0.0, alpha=1e-3)
    for start in range(0, len(wi), 4000):
        part = slice(start, start + 4000)
        expected = float(_fresnel(wi[start, 2], 1.52))
        error = 4.0 * np.sqrt(expected * (1 - expected) / 4000)  # four standard deviations of a binomial share
        assert abs((~transmitted[part]).mean() - expected) < error
        mean = direction[part][transmitted[part]].mean(0)
        np.testing.assert_allclose(mean, [*(-wi[start, :2] / 1.52), mean[2]], atol=1e-3)


@pytest.mark.parametrize("alpha", [0.1, 0.5])
@pytest.mark.parametrize("angle", [0.0, 45.0, 80.0])
def test_facets_are_drawn_by_how_much_of_them_is_seen(backend, rng, alpha, angle):
    """Chi-square against D_v(m) = G1(w) max(0, w.m) D(m) / w.z (Heitz 2014, eq. 16), integrated over cells."""
    import drjit as dr
    import mitsuba as mi

    count, cells, fine = 40_000, (6, 8), 24
    w = np.array([np.sin(np.deg2rad(angle)), 0.0, np.cos(np.deg2rad(angle))])
    numbers = mi.Point2f(rng.uniform(size=(2, count)).astype(np.float32))
    towards, rough = dr.opaque(mi.Vector3f, w.tolist()), dr.opaque(mi.Float, alpha)
    m = np.array(visible_facet(towards, rough, numbers)).T.astype(float)
    # Cells of equal size in (tan^2 / (alpha^2 + tan^2), azimuth), where D cos is uniform.
    tan2 = (m[:, 0] ** 2 + m[:, 1] ** 2) / m[:, 2] ** 2
    u, phi = tan2 / (alpha**2 + tan2), np.arctan2(m[:, 1], m[:, 0]) % (2.0 * np.pi)
    seen = np.histogram2d(u, phi, bins=cells, range=((0, 1), (0, 2 * np.pi)))[0]

    uc = (np.arange(cells[0] * fine) + 0.5) / (cells[0] * fine)
    pc = 2.0 * np.pi * (np.arange(cells[1] * fine) + 0.5) / (cells[1] * fine)
    tan = alpha * np.sqrt(uc / (1.0 - uc))[:, None]
    cos = 1.0 / np.sqrt(1.0 + tan**2)
    dot = np.maximum(cos * (tan * np.cos(pc)[None] * w[0] + w[2]), 0.0)
    # D cos dm is du dphi / (2 pi), so that D_v dm is G1 (w.m) / (cos w.z) of it.
    weight = dot / cos
    expected = weight.reshape(cells[0], fine, cells[1], fine).sum((1, 3))
    kept = expected > 5.0 * expected.sum() / count  # the rule of thumb for chi-square cells
    assert seen[expected == 0.0].sum() == 0
    expected = expected[kept] / expected[kept].sum() * seen[kept].sum()
    assert chisquare(seen[kept], expected).pvalue > SIGNIFICANCE


@pytest.mark.parametrize("alpha", [0.1, 0.6])
def test_walks_leave_alike_whoever_draws_their_first_facet(backend, rng, alpha):
    import drjit as dr
    import mitsuba as mi

    count = 40_000
    seeds = mi.sample_tea_32(dr.arange(mi.UInt32, count), 3)[0]
    others = mi.sample_tea_32(dr.arange(mi.UInt32, count), 4)[0]
    wi, numbers = mi.Vector3f(0.6, 0.0, 0.8), mi.Point3f(rng.uniform(size=(3, count)).astype(np.float32))
    rough = dr.opaque(mi.Float, alpha)
    own = walk(wi, rough, mi.Float(1.5), seeds)
    given = walk(wi, rough, mi.Float(1.5), others, numbers)
    dr.eval(own, given)
    assert np.isclose(*(np.array(x.transmitted).mean() for x in (own, given)), atol=4.0 * 0.5 / np.sqrt(count / 2))
    for axis in range(3):
        pair = (np.array(x.direction[axis]) for x in (own, given))
        assert ks_2samp(*pair).pvalue > SIGNIFICANCE


def test_the_third_of_the_numbers_given_is_the_first_facets_coin(backend, rng):
    import drjit as dr
    import mitsuba as mi

    seeds = mi.sample_tea_32(dr.arange(mi.UInt32, 10_000), 4)[0]
    u, v = rng.uniform(size=(2, 10_000)).astype(np.float32)
    mirrored, passed = (
        np.array(
            walk(mi.Vector3f(0.6, 0.0, 0.8), mi.Float(0.1), mi.Float(1.5), seeds, mi.Point3f(u, v, coin)).transmitted
        )
        for coin in (0.0, LARGEST_COIN)
    )
    # On a surface as smooth as this one walk in a hundred meets a second facet.
    assert mirrored.mean() < 0.02
    assert passed.mean() > 0.98
