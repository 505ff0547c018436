from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from glassware.dataset.depth_cameras.errors import depth_errors
from glassware.dataset.depth_cameras.measure import HIDDEN, MEASURED, OUT_OF_RANGE, SATURATED, UNLIT, UNSEEN, measured
from glassware.dataset.depth_cameras.registration import projected, registered


def wall(planes, device, z, **changes):
    infrared = replace(planes.plane(device, z), **changes)
    colour = planes.colour_camera(device)
    Z = np.full((colour.height, colour.width), z, np.float32)
    return measured(device, infrared, colour, Z, (1, 0, 0)), colour


def test_pixels_with_a_depth_and_only_those_are_measured_and_in_whole_units(planes):
    found, _ = wall(planes, planes.small(), 0.6)
    assert found.depth.dtype == np.uint16
    assert ((found.reason == MEASURED) == (found.depth > 0)).all()
    assert abs(np.nanmedian(found.metres) - 0.6) < 1.5e-3


def test_what_the_right_infrared_camera_does_not_see_is_hidden(planes):
    device = planes.small()
    found, colour = wall(planes, device, 0.6)
    edge = device.imager.focal * device.baseline / 0.6  # columns that are outside the right picture
    column, _ = projected(np.full(found.depth.shape, 0.6), colour, device.infrared_pair(colour), device.place)
    outside = (column > 1) & (column < edge - 2)
    assert outside.any()
    assert (found.reason[outside] == HIDDEN).mean() > 0.95
    assert (found.reason[column < -2] == UNSEEN).mean() > 0.9  # the others are wrong matches, as real ones are


def test_depths_outside_the_range_are_not_reported(planes):
    found, _ = wall(planes, planes.small(range=(0.2, 0.5)), 0.6)
    assert (found.depth == 0).all()
    assert (found.reason == OUT_OF_RANGE).mean() > 0.8


def test_reasons_say_what_is_true_of_pixels_without_a_match(planes):
    device = planes.small()
    infrared = planes.plane(device, 0.6)
    dots = infrared.dots[0].copy(), infrared.dots[1].copy()
    lit = infrared.lit.copy()
    for one in dots:
        one[:60] = 0.0
    dots[0][80:110, 200:260] = 1e3  # one camera is blinded
    lit[:60] = False
    found, _ = wall(planes, device, 0.6, dots=dots, lit=lit)
    assert (found.reason[8:50, 60:] == UNLIT).mean() > 0.9
    assert (found.reason == SATURATED).sum() > 500


def test_surroundings_at_infinity_are_out_of_range_and_not_hidden(planes):
    device = planes.small()
    infrared = planes.plane(device, 0.6)
    dots = infrared.dots[0].copy(), infrared.dots[1].copy()
    lit, shared, Z = infrared.lit.copy(), infrared.shared.copy(), infrared.Z.copy()
    for one in dots:
        one[:60] = 0.0
    lit[:60] = shared[:60] = False  # no point is there that anything could see
    Z[:60] = np.inf
    colour = planes.colour_camera(device)
    seen = np.where(np.arange(colour.height)[:, None] < 60, np.inf, np.full((colour.height, colour.width), 0.6))
    found = measured(device, replace(infrared, dots=dots, lit=lit, shared=shared, Z=Z), colour, seen, (1, 0, 0))
    assert (found.reason[8:50, 60:300] == OUT_OF_RANGE).mean() > 0.95
    assert (found.reason[70:, 60:300] == MEASURED).mean() > 0.95


def test_registration_projects_with_parallax_and_leaves_a_shadow_on_the_left_of_what_is_in_front(planes):
    device = planes.small()
    colour = planes.colour_camera(device, focal=860.0)
    pair = device.infrared_pair(colour)
    Z = np.full((device.imager.height, device.imager.width), 1.0, np.float32)
    Z[40:80, 150:200] = 0.5
    found = registered(Z, pair, colour, device.place)
    # The block: columns from 150 to 199, seen from 15 mm to the left of them, so moved to the right.
    first = 860.0 * ((149.5 - pair.centre[0]) / pair.fx + device.place / 0.5) + colour.centre[0]
    row = found[60]
    near = np.flatnonzero(row == np.float32(0.5))
    assert abs(near[0] - first) <= 1
    shadow = np.isnan(row)
    # It moves twice as far as the wall, which so is uncovered where the block was, on its left.
    assert shadow[near[0] - 10 : near[0]].all()
    assert abs(shadow.sum() - 860.0 * device.place * (1 / 0.5 - 1 / 1.0)) < 3
    assert not shadow[near[0] : near[-1] + 20].any()


def test_registration_to_coarse_pixels_has_the_noise_of_one_depth_and_no_preference_for_near_ones(planes, rng):
    device = planes.small()
    colour = planes.colour_camera(device, focal=143.0)  # nine infrared pixels in each of the colour camera's
    Z = rng.normal(1.0, 0.002, (device.imager.height, device.imager.width)).astype(np.float32)
    Z[:, 200:] -= 0.5
    pair = device.infrared_pair(colour)
    found = registered(Z, pair, colour, device.place, alike=1.0 / (device.imager.focal * device.baseline))
    far, near = found[found > 0.75], found[found < 0.75]
    assert min(far.size, near.size) > 600
    for depths, truth in ((far, 1.0), (near, 0.5)):
        assert depths.mean() == pytest.approx(truth, abs=4e-4)
        assert depths.std() == pytest.approx(0.002, rel=0.15)


def test_the_five_numbers_of_an_object_are_fractions_of_its_pixels():
    Z, mask = np.full((60, 60), 0.5), np.zeros((60, 60), bool)
    mask[10:50, 10:50] = True
    reported = Z.copy()
    reported[10:17, 10:50] = np.nan  # a part of the rim: 280 px of 924
    reported[17:27, 17:37] += 0.05
    reported[27:32, 17:37] -= 0.03
    found = depth_errors(reported, Z, mask)
    left = 1600 - 280
    assert found.missing == 280 / 1600
    assert (found.behind, found.front) == (200 / left, 100 / left)
    assert found.right == 1 - 300 / left
    assert np.isnan(found.rim)  # nothing is missing inside
    reported[25:35, 25:35] = np.nan
    assert np.isclose(depth_errors(reported, Z, mask).rim, (280 / 924) / (100 / 676))
