"""What a lens needs beyond the frame, and pictures that have it: no pixel is lost."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from glassware.core.margin import NO_MARGIN, Sides, in_frame, pixel_grid
from glassware.dataset.cameras.develop import PairLight, develop, lost_pixels, rendered_margin
from glassware.dataset.cameras.lens import margins, undistorted, warps
from glassware.dataset.cameras.model import ColourCamera, Distortion
from glassware.dataset.cameras.presets import CAMERAS

WIDTH, HEIGHT = 160, 120
OPTICS = (150.0, 152.0, 80.3, 58.9)
BARREL = Distortion(k1=-0.2, k2=0.03, p1=0.002, p2=-0.001)
WIDE = Distortion(k1=-0.28, p1=0.002, p2=-0.001)
PINCUSHION = Distortion(k1=0.12, p1=-0.001, p2=0.002)
WEBCAM = CAMERAS["webcam"].distortion
#: Side of the chequer's fields [px].
SIDE = 20


def chequer(margin: Sides) -> np.ndarray:
    """Return a chequer that goes on beyond the frame."""
    return (pixel_grid(WIDTH, HEIGHT, margin) // SIDE).sum(axis=2).astype(np.float32) % 2


def smooth(margin: Sides) -> np.ndarray:
    """Return smooth light that goes on beyond the frame, (..., 3) float32."""
    x, y = np.moveaxis(pixel_grid(WIDTH, HEIGHT, margin), -1, 0)
    return np.dstack([0.4 + 0.3 * np.sin(x / 15 + hue) * np.cos(y / 12) for hue in range(3)]).astype(np.float32)


def light_of(picture: np.ndarray, margin: Sides) -> PairLight:
    return PairLight(picture, picture, np.ones(picture.shape[:2], np.float32), OPTICS, 0.065, 1.0, margin=margin)


@pytest.mark.parametrize("lens", [WIDE, BARREL, PINCUSHION])
def test_fields_of_a_chequer_beyond_the_frame_appear_where_opencv_finds_their_rays(lens: Distortion) -> None:
    margin, _ = margins(lens, False, OPTICS, WIDTH, HEIGHT)
    maps = warps(lens, OPTICS, WIDTH, HEIGHT, margin)
    assert not maps.outside.any()
    warped = maps.distort.applied(chequer(margin))
    assert warped.shape == (HEIGHT, WIDTH)
    fx, fy, cx, cy = OPTICS
    K = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    pixels = pixel_grid(WIDTH, HEIGHT, NO_MARGIN).reshape(-1, 1, 2).astype(np.float64)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 200, 1e-9)
    seen = cv2.undistortImagePoints(pixels, K, np.array(lens.coefficients), None, stop).reshape(HEIGHT, WIDTH, 2)
    field, place = np.divmod(seen + 0.5, SIDE)
    inside = ((place > 1) & (place < SIDE - 1)).all(axis=2)  # bilinear: no pixel of another field has a part
    assert np.array_equal(warped[inside], (field.sum(axis=2) % 2)[inside])
    beyond = ((seen < -0.5) | (seen > [WIDTH - 0.5, HEIGHT - 0.5])).any(axis=2)
    assert (inside & beyond).sum() > 100 or lens is PINCUSHION  # these need the margin


@pytest.mark.parametrize("lens", [BARREL, PINCUSHION, WEBCAM])
def test_a_rectified_picture_with_a_margin_is_the_pinholes_up_to_its_border(lens: Distortion) -> None:
    rendered, sensed = margins(lens, True, OPTICS, WIDTH, HEIGHT)
    maps = warps(lens, OPTICS, WIDTH, HEIGHT, rendered, sensed)
    assert not maps.lost.any()
    again = maps.rectify.applied(maps.distort.applied(smooth(rendered)))
    assert np.abs(again - smooth(NO_MARGIN)).max() < 0.005  # two bilinear samplings of a smooth picture


@pytest.mark.parametrize("lens", [BARREL, PINCUSHION])
def test_the_margin_is_no_wider_than_the_border_of_the_lens_sees(lens: Distortion) -> None:
    rendered, sensed = margins(lens, False, OPTICS, WIDTH, HEIGHT)
    assert sensed == NO_MARGIN
    fx, fy, cx, cy = OPTICS
    slopes = (pixel_grid(WIDTH, HEIGHT, NO_MARGIN) - [cx, cy]) / [fx, fy]
    x, y = np.moveaxis(undistorted(slopes, lens) * [fx, fy] + [cx, cy], -1, 0)
    farthest = [-x.min(), -y.min(), x.max() - (WIDTH - 1), y.max() - (HEIGHT - 1)]
    assert rendered == tuple(max(0, int(np.ceil(far))) for far in farthest)
    assert any(rendered) == (lens is BARREL)


@pytest.mark.parametrize("rectified", [True, False])
@pytest.mark.parametrize("lens", [BARREL, PINCUSHION, WEBCAM])
def test_a_camera_with_its_margin_loses_no_pixel(lens: Distortion, rectified: bool) -> None:
    camera = CAMERAS["webcam"].model_copy(update={"distortion": lens, "rectified": rectified})
    margin = rendered_margin(camera, OPTICS, WIDTH, HEIGHT)
    assert lost_pixels(camera, OPTICS, WIDTH, HEIGHT, margin) is None
    even = np.full_like(smooth(margin), 0.3)
    for picture in develop(camera, light_of(even, margin), 1, 2, 3):
        assert picture.shape == (HEIGHT, WIDTH, 3)
        assert picture.min() > 0


def test_without_distortion_a_margin_changes_nothing() -> None:
    margin = (3, 5, 7, 2)
    for name in ("ideal", "d435", "phone"):
        camera = CAMERAS[name].model_copy(update={"aperture": 0.0})  # defocus brings light in from the margin
        assert rendered_margin(camera, OPTICS, WIDTH, HEIGHT) == NO_MARGIN
        with_margin = develop(camera, light_of(smooth(margin), margin), 1, 2, 3)
        without = develop(camera, light_of(smooth(NO_MARGIN), NO_MARGIN), 1, 2, 3)
        assert all(np.array_equal(*pair) for pair in zip(with_margin, without, strict=True))


@pytest.mark.parametrize("rectified", [True, False])
def test_where_nothing_is_lost_a_margin_changes_no_colour(rectified: bool) -> None:
    for lens in (BARREL, PINCUSHION):
        camera = ColourCamera(name="own", distortion=lens, rectified=rectified)
        margin = rendered_margin(camera, OPTICS, WIDTH, HEIGHT)
        with_margin = develop(camera, light_of(smooth(margin), margin), 1, 2, 3)[0].astype(int)
        without = develop(camera, light_of(smooth(NO_MARGIN), NO_MARGIN), 1, 2, 3)[0].astype(int)
        lost = lost_pixels(camera, OPTICS, WIDTH, HEIGHT)
        near = np.zeros((HEIGHT, WIDTH), np.uint8) if lost is None else lost.astype(np.uint8)
        kept = in_frame(cv2.dilate(near, np.ones((5, 5), np.uint8)) == 0, (2, 2, 2, 2))
        step = np.abs(in_frame(with_margin - without, (2, 2, 2, 2)))[kept]
        assert step.max() <= 1  # OpenCV resamples in steps of 1/32 px


def test_the_margin_counts_neither_for_exposure_nor_for_focus() -> None:
    camera = ColourCamera(name="own", brightest_median=0.3, aperture=1e-3)
    margin = (80, 60, 80, 60)
    light = light_of(np.full_like(smooth(margin), 50.0), margin)
    in_frame(light.left, margin)[:] = 0.3
    in_frame(light.Z, margin)[:] = 0.5
    whole = replace(light, left=np.full_like(light.left, 0.3), right=np.full_like(light.left, 0.3))
    middle = slice(40, 80), slice(40, 120)
    assert np.array_equal(develop(camera, light, 1, 2, 3)[0][middle], develop(camera, whole, 1, 2, 3)[0][middle])
