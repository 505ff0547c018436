"""Ray differentials: where neighbouring rays of a pixel go, against the rays themselves."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.render.scene.loaded_scene import load

#: Step between the rays that are compared [px], and what curvature and float32 change over it [relative].
STEP, TOLERANCE = 0.05, 0.03


@pytest.fixture(scope="module")
def ball(backend, optical_bench):
    """A finely meshed ball of glass and the loaded scene: interpolated normals are those of a sphere."""
    camera = optical_bench.camera((0.3, 0.0, 0.2), (0.0, 0.0, 0.05), width=48, height=36)
    return load(optical_bench.scene(optical_bench.ball(0.05, 5, (0.0, 0.0, 0.06)), optical_bench.medium(1.5), camera))


def _two_interfaces(loaded, reflected: bool):
    """Follow three rays, of a pixel and its neighbours, through two interfaces; with the first one's footprint."""
    from glassware.render._mitsuba import dr, mi
    from glassware.render.cache.footprint import camera_footprint, followed, normal_derivatives
    from glassware.render.interfaces.dielectric import InterfaceHit, scatter
    from glassware.render.scene.rays import leave
    from glassware.render.scene.surfaces import relative_index_d, surface_media

    derivatives = normal_derivatives(loaded)
    pose, angle = loaded.description.cameras[0].world_T_camera, 1.0 / loaded.description.cameras[0].focal
    away = np.array((0.012, 0.008, 0.06)) - pose[:3, 3]
    first = mi.Vector3f(*map(float, away / np.linalg.norm(away)))
    footprint = camera_footprint(derivatives, first)
    u, v = (np.array(x).ravel() for x in (footprint.d_u, footprint.d_v))
    assert np.linalg.norm(u) == pytest.approx(angle, rel=1e-5)
    directions = np.array(first).ravel()[None] + STEP * np.stack([0.0 * u, u, v])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    ray = mi.Ray3f(mi.Point3f(*map(float, pose[:3, 3])), mi.Vector3f(directions.T.astype(np.float32)))
    footprint = camera_footprint(derivatives, ray.d)
    for number in range(2):
        pi = loaded.mi_scene.ray_intersect_preliminary(ray, False)
        si = pi.compute_surface_interaction(ray, mi.RayFlags.ShadingFrame)
        surface = surface_media(loaded.surfaces, si, ray, si.is_valid())
        eta = relative_index_d(loaded.surfaces.eta_d, surface)
        lobe = mi.Float(0.0 if reflected and number == 1 else 1.0)
        hit = InterfaceHit(-ray.d, surface.n, surface.ns, eta, mi.Float(0.0), lobe, mi.UInt32(0))
        event = scatter(hit)
        triangle = pi.prim_index, dr.sign(dr.dot(si.n, surface.n))
        footprint = followed(footprint, derivatives, triangle, surface, ray.d, event, eta)
        assert footprint is not None
        ray = leave(si, event.direction, mi.Float(1e-7))
    return (
        np.array(x).reshape(3, -1).T for x in (ray.o, ray.d, footprint.p_u, footprint.p_v, footprint.d_u, footprint.d_v)
    )


@pytest.mark.parametrize("reflected", [False, True])
def test_footprints_are_the_differences_of_neighbouring_rays(ball, reflected) -> None:
    origin, direction, p_u, p_v, d_u, d_v = _two_interfaces(ball, reflected)
    for number, (p, d) in enumerate(((p_u, d_u), (p_v, d_v)), start=1):
        moved, turned = ((values[number] - values[0]) / STEP for values in (origin, direction))
        np.testing.assert_allclose(p[0], moved, atol=TOLERANCE * float(np.linalg.norm(moved)))
        np.testing.assert_allclose(d[0], turned, atol=TOLERANCE * float(np.linalg.norm(turned)))
    # Refraction in and out turns a pixel's rays by several pixels' angles.
    assert np.linalg.norm(d_u[0]) > 2.0 / ball.description.cameras[0].focal


def test_the_derivative_along_a_triangle_is_that_of_its_interpolation(rng) -> None:
    from glassware.render.cache.footprint import along_triangles

    points, values = rng.normal(size=(2, 5, 3, 3))
    found = along_triangles(points, values)
    a, b = rng.uniform(0.0, 0.5, (2, 5, 1))
    step, change = (a * (x[:, 1] - x[:, 0]) + b * (x[:, 2] - x[:, 0]) for x in (points, values))
    np.testing.assert_allclose((found @ step[..., None])[..., 0], change, atol=1e-9)
