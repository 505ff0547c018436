from __future__ import annotations

import numpy as np
import pytest

from glassware.annotate.boxes import EDGES, amodal_box, box_corners, clipped_box, modal_box


def test_the_bits_of_a_corners_number_say_its_sides():
    corners = box_corners((2.0, 4.0, 6.0))
    assert corners[0].tolist() == [-1, -2, -3]
    assert corners[1].tolist() == [1, -2, -3]
    assert corners[2].tolist() == [-1, 2, -3]
    assert corners[4].tolist() == [-1, -2, 3]
    assert corners[7].tolist() == [1, 2, 3]


def test_a_box_has_twelve_edges_four_along_each_axis():
    corners = box_corners((2.0, 4.0, 6.0))
    steps = sorted(tuple((corners[b] - corners[a]).tolist()) for a, b in EDGES)
    assert steps == sorted([(2.0, 0.0, 0.0)] * 4 + [(0.0, 4.0, 0.0)] * 4 + [(0.0, 0.0, 6.0)] * 4)
    assert len(set(EDGES)) == 12


def test_a_modal_box_is_as_wide_as_its_pixels():
    mask = np.zeros((10, 12), bool)
    mask[3:5, 7] = True
    assert modal_box(mask) == (6.5, 2.5, 7.5, 4.5)


def test_an_object_that_is_not_seen_has_no_modal_box():
    assert modal_box(np.zeros((4, 4), bool)) is None


def test_the_amodal_box_of_a_ball_is_that_of_its_exact_projection():
    # A sphere's image along u is bounded by tangent planes: tan(a +- b), with sin b = r / distance (in the plane).
    K = np.array([[200.0, 0, 50], [0, 200.0, 40], [0, 0, 1]])
    centre, radius = np.array([0.1, -0.05, 0.8]), 0.06
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 400), np.linspace(0, 2 * np.pi, 800))
    ball = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1).reshape(-1, 3)
    found = amodal_box(centre + radius * ball, K)
    assert found is not None
    for axis, low, high, middle in ((0, found[0], found[2], 50), (1, found[1], found[3], 40)):
        a = np.arctan2(centre[axis], centre[2])
        b = np.arcsin(radius / np.hypot(centre[axis], centre[2]))
        # The net of 400 x 800 points misses the exact contour by r (step / 2)^2 / 2, far below a thousandth of a pixel.
        np.testing.assert_allclose([low, high], middle + 200 * np.tan([a - b, a + b]), atol=1e-3)


def test_an_amodal_box_reaches_out_of_the_picture_and_its_clipped_part_does_not():
    K = np.array([[100.0, 0, 1.5], [0, 100.0, 1.5], [0, 0, 1]])
    box = amodal_box(np.array([[-0.1, 0.0, 1.0], [0.01, 0.01, 1.0]]), K)
    assert box == pytest.approx((-8.5, 1.5, 2.5, 2.5))
    assert clipped_box(box, 4, 4) == pytest.approx((-0.5, 1.5, 2.5, 2.5))
    assert clipped_box((10.0, 0.0, 12.0, 3.0), 4, 4) is None


def test_a_surface_that_reaches_behind_the_camera_has_no_amodal_box():
    assert amodal_box(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -0.1]]), np.eye(3)) is None
    assert clipped_box(None, 4, 4) is None
