from __future__ import annotations

import numpy as np
import pytest

from glassware.dataset.depth_cameras.measure import MEASURED
from glassware.dataset.depth_cameras.time_of_flight import NO_RETURN, WEAK, timed
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import Scene
from glassware.procedural.description.surroundings import ConstantEnvironment
from glassware.procedural.description.time_of_flight import TimeOfFlightCamera
from glassware.procedural.optics.catalogue import FUSED_SILICA
from glassware.procedural.optics.dispersion import D_LINE, index
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives import bodies, scenes
from glassware.procedural.sensors.time_of_flight import TIME_OF_FLIGHT_CAMERAS
from glassware.render.frame import Beams
from glassware.render.infrared.beams import group_index

HEIGHT, INDEX, THICK = 0.6, 1.5, 0.03
GLASS = Medium(name="glass", eta=INDEX)


def device(**changes: object) -> TimeOfFlightCamera:
    """The L515 with a small picture of half its resolution, in the place of the colour camera."""
    small = {"width": 64, "height": 48, "focal": 60.0, "place": 0.0}
    return TIME_OF_FLIGHT_CAMERAS["l515"].model_copy(update=small | changes)


def above(glass=(), props=(), sensor: TimeOfFlightCamera | None = None, eye=(0.0, 0.0, HEIGHT)) -> Scene:
    scene = scenes.scene(
        glass,
        [scenes.camera(eye, width=32, height=24)],
        props=props,
        table=scenes.board((8.0, 8.0, 0.02), scenes.matte()),
        environment=ConstantEnvironment(strength=0.05),
        picture=Picture(spp=1, light="path", denoise=False, refraction=False, layers=0),
    )
    return scene.model_copy(update={"depth_camera": sensor or device()})


def beams_of(scene: Scene) -> Beams:
    from glassware.render.renderer import Renderer

    return Renderer(scene).beams(0)


def slopes(camera) -> np.ndarray:
    """Tangent of the angle between the rays of the pixels and the axis."""
    rows, columns = np.indices((camera.height, camera.width))
    return np.hypot(columns - camera.centre[0], rows - camera.centre[1]) / camera.fx


MIDDLE = 4  # of the nine rays of a pixel


def test_what_is_behind_a_slab_is_as_much_too_far_as_glass_delays_light(backend):
    slab = bodies.slab((0.8, 0.7, THICK), GLASS, (0.0, 0.0, 0.2))
    bare, through = beams_of(above()), beams_of(above(glass=(slab,)))
    slope = slopes(bare.camera)
    np.testing.assert_allclose(bare.path[MIDDLE], HEIGHT * np.sqrt(1 + slope**2), rtol=1e-5)
    # By Snell's law: (Z - t) / cos in air, and n t / cos' in glass; on the axis t (n - 1) more than without.
    sine = slope / np.sqrt(1 + slope**2) / INDEX
    expected = (HEIGHT - THICK) * np.sqrt(1 + slope**2) + INDEX * THICK / np.sqrt(1 - sine**2)
    seen = slope > 0.05  # in the middle the slab mirrors the beam itself
    np.testing.assert_allclose(through.path[MIDDLE][seen], expected[seen], atol=2e-5)  # rays leave faces 5 um off
    closest = np.argmin(np.where(seen, slope, 9.0))
    extra = through.path[MIDDLE].flat[closest] - bare.path[MIDDLE].flat[closest]
    assert extra == pytest.approx(THICK * (INDEX - 1), rel=0.01)
    # Light that goes out and back meets four faces; a third of a millimetre of way changes 1 / z^2 by 0.1 %.
    cos = 1 / np.sqrt(1 + slope**2)
    inner = np.sqrt(1 - sine**2)
    s, p = (cos - INDEX * inner) / (cos + INDEX * inner), (INDEX * cos - inner) / (INDEX * cos + inner)
    ratio = (through.strength[MIDDLE] / bare.strength[MIDDLE])[seen]
    length = (HEIGHT - THICK) / cos + THICK / inner
    due = (1 - 0.5 * (s**2 + p**2)) ** 4 * (HEIGHT / cos / length) ** 2
    np.testing.assert_allclose(ratio, due[seen], rtol=0.03)  # the lobe of the board depends on the angle


def test_glass_that_faces_the_beam_is_the_strongest_return_and_the_first(backend):
    slab = bodies.slab((0.8, 0.7, THICK), GLASS, (0.0, 0.0, 0.2))
    sensor = device(width=65, height=49, error=(0.0, 0.0))
    found = beams_of(above(glass=(slab,), sensor=sensor))
    assert found.path[MIDDLE][24, 32] == pytest.approx(HEIGHT - 0.2 - THICK / 2, abs=1e-5)
    assert found.path[MIDDLE][24, 55] > HEIGHT


def test_a_mirror_shows_things_as_far_behind_it_as_they_are_in_front_and_itself_nothing(backend):
    chrome = scenes.matte((0.9, 0.9, 0.9), "chrome").model_copy(update={"roughness": 0.02, "metallic": 1.0})
    wall = scenes.block(bodies.box_mesh((0.02, 2.0, 3.0), "wall", (0.16, 0.0, 1.51)), chrome, id=2)
    found = beams_of(above(props=(wall,)))
    side = found.Z < HEIGHT - 0.02
    assert side.sum() > 200
    # The image of the table in the wall lies where the table would go on.
    slope = slopes(found.camera)
    np.testing.assert_allclose(found.path[MIDDLE][side], (HEIGHT * np.sqrt(1 + slope**2))[side], rtol=1e-4)


def test_grazing_surfaces_drop_out_and_say_that_their_return_is_weak(backend):
    # On a matte board that a ray meets at the angle a, rho cos a / z^2 = rho h / z^3 fades below the least return.
    sensor = device(reach=2.0, error=(0.0, 0.0))
    eye = (0.0, -0.05, 0.15)
    scene = above(sensor=sensor)
    camera = scenes.camera(eye, (0.0, 2.0, 0.0), width=32, height=24)
    scene = scene.model_copy(update={"cameras": (camera,)})
    found = beams_of(scene)
    colour = scene.cameras[0]
    report = timed(sensor, found, colour, np.full((24, 32), 1.0, np.float32), (0, 0, 0))
    distance = found.path[MIDDLE]
    hit = np.isfinite(distance) & (distance < 3.0)
    strength = found.strength[MIDDLE]
    # Burley's diffuse lobe towards where the light comes from, and a GGX one of alpha 1 (SIGGRAPH 2012 course).
    cos = np.where(hit, eye[2] / distance, 1.0)
    lobes = 0.5 * cos * (1 + 1.5 * (1 - cos) ** 5) ** 2 + 0.04 * cos / (1 + cos) ** 2
    np.testing.assert_allclose(strength[hit], (lobes / distance**2)[hit], rtol=0.05)
    has = np.isfinite(report.Z)
    assert has.any()
    assert (~has).any()
    # Apart from pixels that the edge of what can be measured divides.
    sure = hit & (np.abs(strength - sensor.least) > 0.3 * sensor.least)
    assert ((strength > sensor.least) == has)[sure].all()
    np.testing.assert_allclose(report.Z[has & sure], found.Z[has & sure], rtol=0.02)
    assert {MEASURED, WEAK, NO_RETURN} >= set(np.unique(report.reason)) - {0}


def test_pulses_in_glass_are_as_slow_as_the_slope_of_its_index_says():
    assert group_index(GLASS, 860.0) == INDEX
    # Malitson's fused silica (J. Opt. Soc. Am. 55, 1205, 1965) at 860 nm: n 1.4525, dn/dlambda -0.0151 / um.
    silica = Medium(name="silica", eta=round(float(index(FUSED_SILICA, D_LINE)), 6), dispersion=FUSED_SILICA)
    assert group_index(silica, 860.0) == pytest.approx(1.4525 + 0.86 * 0.0151, abs=3e-4)
