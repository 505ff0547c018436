"""Glints of the sun in glass: the light of the sun, with less noise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glassware.procedural.description.picture import Picture
from glassware.procedural.description.surroundings import SkyEnvironment
from glassware.procedural.surroundings.colour import luminance
from glassware.render.pictures.picture import PATH_TRACER, trace_picture
from glassware.render.scene.loaded_scene import load

#: A sun four times as wide as the real one: paths find it often enough for a comparison.
RADIUS = math.radians(1.0)


@pytest.fixture(scope="module")
def tumbler(backend, optical_bench):
    """A ball of glass in the sun, loaded; pixels of 0.7 degrees make the wide disc one of 2 degrees."""
    camera = optical_bench.camera((0.3, 0.0, 0.2), (0.0, 0.0, 0.05))
    scene = optical_bench.scene(optical_bench.ball(0.05, 4, (0.0, 0.0, 0.06)), optical_bench.medium(1.5), camera)
    sky = SkyEnvironment(
        sun_elevation=0.9,
        sun_illuminance=80.0,
        sun_radius=RADIUS,
        turbidity=3.0,
        cloudiness=0.0,
        ground=(0.2, 0.2, 0.2),
        seed=1,
    )
    return load(scene.model_copy(update={"environment": sky, "picture": Picture(spp=1024, light="path")}))


def test_glass_shows_the_light_of_the_sun_with_less_noise(tumbler) -> None:
    from glassware.render._mitsuba import mi
    from glassware.render.pictures.integrator import StoredCaustics, trace
    from glassware.render.pictures.picture import Tracer
    from glassware.render.scene.lighting import sun_glints

    def tracer(glints):
        def shade(si, barycentric, ray, bounce):
            return mi.Color3f(0.0), mi.Color3f(0.0)  # no caustics

        def traced(loaded, ray, weight, sampler, picture):
            return trace(loaded, ray, weight, sampler, picture, caustics=StoredCaustics(shade, glints))

        return Tracer(traced, PATH_TRACER.weights)

    glints = sun_glints(tumbler.description)
    assert glints is not None
    camera = tumbler.description.cameras[0]
    wide, real = (trace_picture(tumbler, camera, "left", 3, tracer(sun)) for sun in (glints, None))
    glass = wide.guides.glass
    assert glass.sum() > 200
    light = [luminance(image.radiance)[glass].sum(dtype=np.float64) for image in (wide, real)]
    errors = [np.sqrt((luminance(np.sqrt(image.variance))[glass] ** 2).sum()) for image in (wide, real)]
    assert errors[1] < 0.04 * light[1]
    assert abs(light[0] - light[1]) < 3.0 * math.hypot(*errors)
    assert errors[0] < 0.6 * errors[1]
    # The open table is lit by the sun as it is: the same to the last bit.
    table = np.zeros_like(glass)
    table[:4] = table[-4:] = True
    np.testing.assert_array_equal(wide.radiance[table], real.radiance[table])


def test_a_spread_disc_keeps_the_light_of_the_sun(tumbler, rng) -> None:
    from glassware.procedural.surroundings.sun_glints import wide_sun
    from glassware.render._mitsuba import mi
    from glassware.render.scene.lighting import sun_glints

    scene = tumbler.description
    glints, sun = sun_glints(scene), wide_sun(scene.environment, 1.0 / scene.cameras[0].focal)
    assert glints is not None
    assert sun is not None
    # Directions within 0.4 of the sun, uniform by solid angle; spreads as long as 0.2 in any direction, across them.
    count, versine = 1 << 16, 1.0 - math.cos(0.4)
    z, turn = 1.0 - versine * rng.random(count), 2.0 * math.pi * rng.random(count)
    local = mi.Vector3f(*np.stack([np.sqrt(1.0 - z**2) * np.cos(turn), np.sqrt(1.0 - z**2) * np.sin(turn), z]))
    direction = mi.Frame3f(mi.Vector3f(*sun.direction.tolist())).to_world(local)
    for a, b in (((0.0, 0.0), (0.0, 0.0)), ((0.2, 0.05), (0.0, 0.1)), ((0.15, 0.0), (0.0, 0.0))):
        frame = mi.Frame3f(direction)
        spread = tuple(x * frame.s + y * frame.t for x, y in (a, b))
        dark = mi.Color3f(0.0)
        found = luminance(np.array(glints(dark, direction, spread)).T).mean() * 2.0 * math.pi * versine
        # Noise of 2^16 directions of which a hundredth or more hit: three of 1 / sqrt(655).
        assert found == pytest.approx(float(luminance(sun.light)), rel=0.12)


def test_a_glint_of_a_wall_whose_curvature_changes_keeps_its_light(tumbler) -> None:
    from glassware.procedural.surroundings.sun_glints import wide_sun
    from glassware.render._mitsuba import mi
    from glassware.render.scene.lighting import sun_glints

    scene = tumbler.description
    glints, sun = sun_glints(scene), wide_sun(scene.environment, 1.0 / scene.cameras[0].focal)
    assert glints is not None
    assert sun is not None
    # Places in a pixel mirror directions that are A x + B x^2 / 2 and A y away from the sun [rad]: by the change of
    # variables the glint at 0 has the sun's light over A^2.
    A, B, half = 1.0, 4.0, 0.2
    grid = (np.arange(1024) + 0.5) / 1024 * 2.0 * half - half
    x, y = (values.ravel() for values in np.meshgrid(grid, grid))
    frame = mi.Frame3f(mi.Vector3f(*sun.direction.tolist()))
    away = A * x + 0.5 * B * x**2, A * y
    z = np.sqrt(np.maximum(1.0 - away[0] ** 2 - away[1] ** 2, 0.0))
    direction = frame.to_world(mi.Vector3f(*(values.astype(np.float32) for values in (*away, z))))
    spread = mi.Float((A + B * x).astype(np.float32)) * frame.s, mi.Float(A) * frame.t
    found = luminance(np.array(glints(mi.Color3f(0.0), direction, spread)).T).mean() * (2.0 * half) ** 2
    assert found * A**2 / float(luminance(sun.light)) == pytest.approx(1.0, abs=0.03)
