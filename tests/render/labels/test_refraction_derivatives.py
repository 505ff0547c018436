"""Derivatives of the refracted ray against closed forms and central differences with the same rays."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.render.labels.refraction import refract
from glassware.render.scene.loaded_scene import load

#: The slab's derivative is float32 arithmetic on a closed form, and the ray offset moves it by 1e-5 of the wall.
CLOSED_FORM = 1e-3
#: Central differences: what the issue asks for.
CENTRAL = 0.01
ETA = 1.52


@pytest.fixture(scope="module")
def slab(backend, optical_bench):
    body = optical_bench.box((3.0, 3.0, 0.05), (0.013, 0.007, 0.2))
    return load(optical_bench.scene(body, optical_bench.medium(ETA, (3.0, 1.0, 0.5))))


@pytest.fixture(scope="module")
def ball(backend, optical_bench):
    body = optical_bench.ball(0.05, 5, (0.0, 0.0, 0.2))
    return load(optical_bench.scene(body, optical_bench.medium(ETA)))


def _fan(optical_bench):
    theta = np.radians(np.arange(5.0, 65.0))
    direction = np.stack([np.sin(theta), np.zeros_like(theta), -np.cos(theta)], axis=1)
    return theta, optical_bench.rays(np.array([0.0, 0.0, 0.4]), direction)


def _bundle(rng):
    """Origins and directions of rays from above through the inner part of the ball, none of which is near its edge."""
    target = np.concatenate([rng.uniform(-0.025, 0.025, size=(400, 2)), np.full((400, 1), 0.2)], axis=1)
    origin = np.array([0.02, -0.05, 0.6])
    return origin, target - origin


def _etas(kernel, index: float):
    import mitsuba as mi

    return mi.Float([1.0 if medium.eta == 1.0 else index for medium in kernel.surfaces.media])


def _number(value: float):
    """A number that is not compiled into the kernel: both sides of a difference use the same one."""
    import drjit as dr
    import mitsuba as mi

    return dr.opaque(mi.Float, value)


def _sum(end, weights):
    """One number of many landing points: weights keep its parts from cancelling."""
    import drjit as dr
    import mitsuba as mi

    return dr.sum(dr.dot(end.point, dr.opaque(mi.Vector3f, weights.tolist())))


def test_forward_mode_gives_the_slab_s_derivative_by_its_index(slab, optical_bench):
    import drjit as dr

    theta, ray = _fan(optical_bench)
    eta = _etas(slab, ETA)
    dr.enable_grad(eta)
    end = refract(slab, ray, eta, derivatives=True)
    dr.set_grad(eta, [0.0, 1.0])
    dr.forward_to(end.point)
    # x = t tan(theta'), sin(theta') = sin(theta) / n: dx / dn = -t n sin(theta) / (n^2 - sin(theta)^2)^(3/2).
    expected = -0.05 * ETA * np.sin(theta) / (ETA**2 - np.sin(theta) ** 2) ** 1.5
    assert np.abs(np.array(dr.grad(end.point.x)) / expected - 1).max() < CLOSED_FORM


def test_reverse_mode_gives_the_slab_s_derivatives_by_index_and_absorption(slab, optical_bench):
    import drjit as dr
    import mitsuba as mi

    theta, ray = _fan(optical_bench)
    eta, sigma_a = _etas(slab, ETA), mi.Float(slab.surfaces.sigma_a_rgb)
    dr.enable_grad(eta, sigma_a)
    end = refract(slab, ray, eta, sigma_a, derivatives=True)
    dr.backward(dr.sum(end.point.x))
    expected = -0.05 * ETA * np.sin(theta) / (ETA**2 - np.sin(theta) ** 2) ** 1.5
    assert np.array(dr.grad(eta))[1] == pytest.approx(expected.sum(), rel=CLOSED_FORM)

    dr.set_grad(eta, 0.0)
    end = refract(slab, ray, eta, sigma_a, derivatives=True)
    dr.backward(dr.sum(end.transmittance.x))
    inside = optical_bench.snell(theta, ETA)
    path = 0.05 / np.cos(inside)
    share = (1 - optical_bench.fresnel(theta, ETA)) ** 2 * np.exp(-3.0 * path)
    assert np.array(dr.grad(sigma_a))[3] == pytest.approx(-(path * share).sum(), rel=CLOSED_FORM)


def test_the_derivative_by_a_ball_s_index_is_the_central_difference(ball, optical_bench, rng):
    import drjit as dr

    ray, weights = optical_bench.rays(*_bundle(rng)), rng.normal(size=3).astype(np.float32)
    eta = _etas(ball, ETA)
    dr.enable_grad(eta)
    dr.backward(_sum(refract(ball, ray, eta, derivatives=True), weights))
    step = 2e-3  # far above float32 rounding of the points, far below the curvature in the index
    high, low = (_sum(refract(ball, ray, _etas(ball, ETA + side)), weights) for side in (step, -step))
    assert np.array(dr.grad(eta))[1] == pytest.approx((high - low)[0] / (2 * step), rel=CENTRAL)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_derivative_by_the_camera_s_place_is_the_central_difference(ball, optical_bench, rng, axis):
    import drjit as dr
    import mitsuba as mi

    origin, direction = _bundle(rng)
    ray, weights = optical_bench.rays(origin, direction), rng.normal(size=3).astype(np.float32)
    along = dr.opaque(mi.Vector3f, np.eye(3)[axis].tolist())

    def landed(shift: mi.Float, derivatives: bool) -> mi.Float:
        moved = mi.Ray3f(ray)
        moved.o = moved.o + shift * along
        return _sum(refract(ball, moved, derivatives=derivatives), weights)

    shift = _number(0.0)
    dr.enable_grad(shift)
    dr.backward(landed(shift, True))
    step = 2e-4
    expected = (landed(_number(step), False) - landed(_number(-step), False))[0] / (2 * step)
    assert dr.grad(shift)[0] == pytest.approx(expected, rel=CENTRAL)


def test_the_derivative_by_the_camera_s_turn_is_the_central_difference(ball, optical_bench, rng):
    import drjit as dr
    import mitsuba as mi

    ray, weights = optical_bench.rays(*_bundle(rng)), rng.normal(size=3).astype(np.float32)

    def landed(angle: mi.Float, derivatives: bool) -> mi.Float:
        sin, cos = dr.sincos(angle)
        turned = mi.Ray3f(ray)
        turned.d = mi.Vector3f(cos * ray.d.x + sin * ray.d.z, ray.d.y, cos * ray.d.z - sin * ray.d.x)
        return _sum(refract(ball, turned, derivatives=derivatives), weights)

    angle = _number(0.0)
    dr.enable_grad(angle)
    dr.backward(landed(angle, True))
    step = 3e-4
    expected = (landed(_number(step), False) - landed(_number(-step), False))[0] / (2 * step)
    assert dr.grad(angle)[0] == pytest.approx(expected, rel=CENTRAL)


@pytest.mark.parametrize("change", ["lifted", "grown"])
def test_the_derivative_by_vertex_positions_is_the_central_difference(backend, optical_bench, rng, change):
    import drjit as dr
    import mitsuba as mi

    # A kernel of its own: its vertices are moved.
    body = optical_bench.ball(0.05, 5, (0.0, 0.0, 0.2))
    kernel = load(optical_bench.scene(body, optical_bench.medium(ETA)))
    parameters = mi.traverse(kernel.mi_scene)
    (name,) = (key for key in parameters.keys() if key.endswith("body1.vertex_positions"))  # noqa: SIM118
    start = dr.unravel(mi.Point3f, mi.Float(parameters[name]))
    away = mi.Vector3f(start - mi.Point3f(0.0, 0.0, 0.2))
    shift = dr.full(mi.Float, 1.0, dr.width(away)) * mi.Vector3f(0.0, 0.0, 1.0) if change == "lifted" else away
    dr.make_opaque(start, shift)
    ray, weights = optical_bench.rays(*_bundle(rng)), rng.normal(size=3).astype(np.float32)

    def landed(amount: mi.Float, derivatives: bool) -> mi.Float:
        parameters[name] = dr.ravel(start + amount * shift)
        parameters.update()
        return _sum(refract(kernel, ray, derivatives=derivatives), weights)

    amount = _number(0.0)
    dr.enable_grad(amount)
    dr.backward(landed(amount, True))
    step = 2e-4 if change == "lifted" else 4e-3
    expected = (landed(_number(step), False) - landed(_number(-step), False))[0] / (2 * step)
    assert dr.grad(amount)[0] == pytest.approx(expected, rel=CENTRAL)


def test_a_variant_without_derivatives_is_told_so(slab, optical_bench, monkeypatch):
    import drjit as dr

    _, ray = _fan(optical_bench)
    monkeypatch.setattr(dr, "is_diff_v", lambda _: False)
    with pytest.raises(InputError, match="derivatives: expected a variant with AD"):
        refract(slab, ray, derivatives=True)
