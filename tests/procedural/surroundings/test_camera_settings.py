"""Intrinsics, presets and placements of cameras, as they are asked for."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from glassware.procedural.surroundings.camera_presets import PRESETS
from glassware.procedural.surroundings.camera_settings import CameraSettings
from glassware.procedural.surroundings.intrinsics import Intrinsics, fit_distance

# Rounding of a few float64 operations on numbers of order 1000.
EXACT = 1e-9
K = ((600.0, 0.0, 322.0), (0.0, 610.0, 238.0), (0.0, 0.0, 1.0))


def made(**settings: Any) -> CameraSettings:
    return CameraSettings.model_validate(settings)


def test_K_and_its_four_numbers_are_the_same_camera():
    lens = Intrinsics(640, 480, 600.0, 610.0, 322.0, 238.0)
    assert made(K=K).intrinsics() == lens
    assert made(fx=600, fy=610, cx=322, cy=238).intrinsics() == lens
    np.testing.assert_array_equal(lens.camera(np.eye(4), 0.05, 1.0).K, K)


def test_one_focal_length_is_for_both_directions_and_at_the_pictures_own_size():
    lens = made(fx=400, width=320, height=240).intrinsics()
    assert (lens.fx, lens.fy, lens.cx, lens.cy) == (400.0, 400.0, 159.5, 119.5)


def test_a_scale_keeps_the_edges_of_the_view_where_they_are():
    whole, half = made(K=K).intrinsics(), made(K=K, scale=0.37).intrinsics()
    assert (half.width, half.height) == (237, 178)
    assert half.half_angles() == pytest.approx(whole.half_angles(), abs=EXACT)


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_a_preset_is_size_lens_and_baseline(name):
    camera, preset = made(preset=name), PRESETS[name]
    assert camera.intrinsics() == preset.lens
    assert camera.baseline == preset.baseline
    assert preset.source
    again = CameraSettings.model_validate(camera.model_dump(mode="json"))
    assert again == camera


def test_published_fields_of_view_are_met():
    """The data sheets: D435 87 by 58 degrees, D415 65 by 40, both within their 3 degrees or the units' spread."""
    left, right, up, down = PRESETS["d435"].lens.half_angles()
    assert math.degrees(left + right) == pytest.approx(87.0, abs=3.0)
    assert math.degrees(up + down) == pytest.approx(58.0, abs=3.0)


@pytest.mark.parametrize("degrees", [20.0, 69.0, 120.0])
def test_a_field_of_view_reaches_from_the_left_edge_of_the_picture_to_the_right(degrees):
    for lens in (made(fov=f"{degrees}deg").intrinsics(), made(fov=math.radians(degrees), preset="d435").intrinsics()):
        left, right, _, _ = lens.half_angles()
        assert math.degrees(left + right) == pytest.approx(degrees, abs=1e-9)
        assert lens.fx == lens.fy


def test_what_is_given_takes_precedence_over_the_preset():
    assert made(preset="d435", baseline="55mm").baseline == 0.055
    own = made(preset="d435", fx=500, width=640, height=480).intrinsics()
    assert own == Intrinsics(640, 480, 500.0, 500.0, 319.5, 239.5)
    assert made(preset="d435", cy=240.0).intrinsics().cy == 240.0


def test_another_size_of_a_preset_has_the_same_field_of_view():
    whole = made(preset="d435").intrinsics()
    for size in ({"width": 424}, {"height": 240}, {"width": 424, "height": 240}):
        half = made(preset="d435", **size).intrinsics()
        assert (half.width, half.height) == (424, 240)
        assert half.half_angles() == pytest.approx(whole.half_angles(), abs=EXACT)
    resized = made(preset="keypose", width=756, height=424).intrinsics()  # the pictures that KeyPose's network sees
    assert resized.fx == pytest.approx(400.0, rel=0.005)


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"preset": "d345"}, r"expected one of .*\(is it d435\?\), found 'd345'"),
        ({"preset": "d435", "width": 640, "height": 480}, r"height: expected 362, the shape of d435 \(848 x 480\)"),
        ({"K": K, "fx": 600}, "K: expected it or fx fy cx cy, found it with fx"),
        ({"K": K, "fov": 1.0}, "fov: expected it or K or fx fy cx cy, found it with K"),
        ({"fx": 600, "fov": 1.0}, "fov: expected it or K or fx fy cx cy, found it with fx"),
        ({"fy": 600}, "fy: expected fx beside it, found 600 alone"),
        (
            {"K": K, "width": 320, "height": 240},
            r"K: expected cx of 127.5 to 191.5 px in a picture of width 320",
        ),
        ({"K": K, "width": 1280, "height": 960}, r"K: expected cx of 511.5 to 767.5 px .*a width of 645 would fit"),
        ({"cy": 400}, "cy: expected 191.5 to 287.5 px in a picture of height 480"),
        ({"K": ((600, 1, 320), (0, 600, 240), (0, 0, 1))}, "K: expected rows fx 0 cx, 0 fy cy, 0 0 1"),
        ({"K": ((0, 0, 320), (0, 600, 240), (0, 0, 1))}, "K: expected focal lengths of 1 to 1e6 px, found 0 and 600"),
        ({"elevation": (1.0, 0.5)}, "expected the smaller number first"),
        ({"elevation": ("-5deg", "5deg")}, "greater than or equal to 0"),
        ({"azimuth": ("-190deg", "180deg")}, "azimuth: expected a range of at most 360deg, found 370deg"),
        ({"distance": (0.4, 0.8), "angle_jitter": "5deg"}, "angle_jitter: expected 0 beside the range of distance"),
        ({"poses": "p.txt", "roll": "5deg"}, "roll: expected none beside cameras.poses"),
        ({"poses": "p.txt", "distance": (0.4, 0.8)}, "distance: expected none beside cameras.poses"),
        ({"world_T_poses": np.eye(4).tolist()}, "world_T_poses: expected cameras.poses beside it"),
        ({"look_jitter": "25deg"}, r"look_jitter: expected at most 19\.\d*deg, .*, found 25deg"),
        ({"views": 58}, "views: expected less than or equal to 57 on the grid"),
    ],
    ids=lambda value: str(value)[:50],
)
def test_what_cannot_be_together_is_one_line_with_the_field(settings, says):
    with pytest.raises(ValidationError, match=says):
        made(**settings)


def test_off_the_grid_there_may_be_more_views():
    assert made(views=1000, distance=(0.4, 0.8)).views == 1000


def test_a_ball_fits_the_picture_of_a_camera_whose_middle_is_off_its_axis():
    lens, baseline, radius, tilt = Intrinsics(640, 480, 500.0, 620.0, 280.0, 260.0), 0.05, 0.15, 0.05
    distance = fit_distance(lens, baseline, radius, tilt)
    directions = np.random.default_rng(5).normal(size=(4000, 3))
    ball = radius * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    tightest = math.inf
    for turn in np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False):
        ahead = (math.sin(tilt) * math.cos(turn), math.sin(tilt) * math.sin(turn), math.cos(tilt))
        for shift in (0.0, baseline):
            points = ball + distance * np.array(ahead) - [shift, 0.0, 0.0]
            pixels = points[:, :2] / points[:, 2:] * (lens.fx, lens.fy) + (lens.cx, lens.cy)
            margin = min((pixels + 0.5).min(), ((lens.width, lens.height) - pixels - 0.5).min())
            tightest = min(tightest, margin)
    assert 0.0 <= tightest <= 3.0  # px: the shortest distance leaves next to nothing on one side
