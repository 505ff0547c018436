from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from glassware.core.images import srgb8
from glassware.dataset.cameras.develop import PairLight, develop, lost_pixels
from glassware.dataset.cameras.model import ColourCamera, Distortion
from glassware.dataset.cameras.presets import CAMERAS

HEIGHT, WIDTH = 48, 64
OPTICS = (61.0, 61.0, 31.5, 23.5)


@pytest.fixture(scope="module")
def light() -> PairLight:
    rng = np.random.default_rng(5)
    left, right = (rng.random((HEIGHT, WIDTH, 3), np.float32) for _ in range(2))
    Z = rng.uniform(0.5, 0.7, (HEIGHT, WIDTH)).astype(np.float32)
    return PairLight(left, right, Z, OPTICS, baseline=0.065, exposure=1.3)


def grey(light: PairLight, level: float) -> PairLight:
    even = np.full_like(light.left, level)
    return replace(light, left=even, right=even)


def test_the_ideal_camera_is_the_srgb_curve_bit_for_bit(light: PairLight) -> None:
    left, right = develop(CAMERAS["ideal"], light, 1, 2, 3)
    assert np.array_equal(left, srgb8(light.left, 1.3))
    assert np.array_equal(right, srgb8(light.right, 1.3))


@pytest.mark.parametrize("name", ["d435", "phone", "webcam"])
def test_the_same_seed_gives_the_same_pictures_and_each_view_and_eye_has_its_own(light: PairLight, name: str) -> None:
    even, camera = grey(light, 0.3), CAMERAS[name]
    left, right = develop(camera, even, 1, 2, 3)
    again = develop(camera, even, 1, 2, 3)
    assert np.array_equal(left, again[0])
    assert np.array_equal(right, again[1])
    assert not np.array_equal(left, right)
    for seed, scene, view in ((2, 2, 3), (1, 3, 3), (1, 2, 4)):
        assert not np.array_equal(left, develop(camera, even, seed, scene, view)[0])


def test_the_exposure_error_has_its_spread_in_stops(light: PairLight) -> None:
    camera = ColourCamera(name="own", exposure_error=0.3)
    even = replace(grey(light, 0.05), exposure=1.0)
    values = np.array([develop(camera, even, 7, 0, view)[0][0, 0, 0] for view in range(400)]) / 255
    stops = np.log2(((values + 0.055) / 1.055) ** 2.4 / 0.05)
    assert stops.mean() == pytest.approx(0, abs=4 * 0.3 / np.sqrt(400))
    assert stops.std() == pytest.approx(0.3, rel=4 / np.sqrt(800))


def test_a_view_that_is_too_bright_as_a_whole_is_exposed_less_and_others_are_not(light: PairLight) -> None:
    scene, own = ColourCamera(name="scene"), ColourCamera(name="own", brightest_median=0.7)
    window, room = grey(light, 40.0), replace(grey(light, 0.5), exposure=1.0)
    assert np.all(develop(scene, window, 1, 0, 0)[0] == 255)
    for picture in develop(own, window, 1, 0, 0):  # both eyes
        assert np.all(picture == srgb8(np.full((1, 1, 3), 0.7, np.float32), 1.0))
    assert np.array_equal(develop(own, room, 1, 0, 0)[0], develop(scene, room, 1, 0, 0)[0])
    # A window that is less than half of the picture changes nothing.
    some = replace(room, left=np.where(np.arange(WIDTH)[:, None] < WIDTH // 3, np.float32(40.0), room.left))
    assert np.array_equal(develop(own, some, 1, 0, 0)[0], develop(scene, some, 1, 0, 0)[0])


def test_what_is_left_of_the_falloff_is_what_the_correction_leaves(light: PairLight) -> None:
    even = replace(grey(light, 0.5), exposure=1.0)
    x, y = 60, 2
    cosine = 1 / np.sqrt(1 + ((x - 31.5) / 61) ** 2 + ((y - 23.5) / 61) ** 2)
    for correction in (0.0, 0.7, 1.0):
        camera = ColourCamera(name="own", falloff=4.0, shading_correction=correction)
        value = develop(camera, even, 0, 0, 0)[0][y, x, 0] / 255
        assert ((value + 0.055) / 1.055) ** 2.4 == pytest.approx(0.5 * cosine ** (4 * (1 - correction)), abs=0.004)


def test_pixels_that_were_not_rendered_are_black_and_marked(light: PairLight) -> None:
    for k1, rectified in ((0.2, True), (-0.2, False)):
        changed = {"rectified": rectified, "distortion": Distortion(k1=k1)}
        camera = CAMERAS["webcam"].model_copy(update=changed)
        lost = lost_pixels(camera, OPTICS, WIDTH, HEIGHT)
        assert lost is not None
        assert not lost[12:36, 16:48].any()
        assert (develop(camera, light, 0, 0, 0)[0][lost] == 0).all()
    assert lost_pixels(CAMERAS["phone"], OPTICS, WIDTH, HEIGHT) is None


def test_light_far_beyond_saturation_is_white(light: PairLight) -> None:
    for name in ("d435", "phone"):
        camera = CAMERAS[name].model_copy(update={"falloff": 0.0, "brightest_median": None})
        assert (develop(camera, grey(light, 50.0), 0, 0, 0)[0] >= 254).all()
